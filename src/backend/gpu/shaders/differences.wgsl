// Slopes of the displaced surface out of its points, by central differences or Sobel's kernel: twin of
// `slopes_of_points` in pass/assemble.rs.

struct Differences {
    frame: u32,
    n: u32,
    // Weights of the line itself and of those beside it, 1/m.
    middle: f32,
    side: f32,
}

@group(0) @binding(0) var<uniform> differences: Differences;
// Dx, Dz, two planes that are none of ours, and the height.
@group(0) @binding(1) var<storage, read> points: array<f32>;
@group(0) @binding(2) var<storage, read_write> assembled: array<f32>;

fn at(plane: u32, x: u32, z: u32) -> f32 {
    let n = differences.n;
    return points[HEADER + (plane * n + z % n) * n + x % n];
}

// Differences of a plane along x and z.
fn difference(plane: u32, x: u32, z: u32) -> vec2<f32> {
    let n = differences.n;
    // A step back is one forward round the patch.
    let l = x + n - 1u;
    let r = x + 1u;
    let u = z + n - 1u;
    let d = z + 1u;
    let across = differences.middle * (at(plane, r, z) - at(plane, l, z))
        + differences.side * ((at(plane, r, u) - at(plane, l, u)) + (at(plane, r, d) - at(plane, l, d)));
    let down = differences.middle * (at(plane, x, d) - at(plane, x, u))
        + differences.side * ((at(plane, l, d) - at(plane, l, u)) + (at(plane, r, d) - at(plane, r, u)));
    return vec2<f32>(across, down);
}

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = differences.n;
    if id.x >= n || id.y >= n {
        return;
    }
    let dx = difference(0u, id.x, id.y);
    let dz = difference(1u, id.x, id.y);
    let h = difference(4u, id.x, id.y);
    let slope = seen(h, dx.x, dx.y, dz.x, dz.y);
    let here = HEADER + id.y * n + id.x;
    assembled[here + 2u * n * n] = slope.x;
    assembled[here + 3u * n * n] = slope.y;
    if id.x == 0u && id.y == 0u {
        assembled[0] = f32(differences.frame);
    }
}
