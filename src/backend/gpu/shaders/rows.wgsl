// The second pass: along x to samples, and what is assembled of them on the spot. A line of a workgroup makes two rows:
// one packing of two fields each, and one field of both in a single transform.

// Bits of `write`: planes of the two packings, of the single field, and those assembled.
const WRITE_A: u32 = 1u;
const WRITE_B: u32 = 4u;
const WRITE_SINGLE: u32 = 16u;
const WRITE_JACOBIAN: u32 = 32u;
const WRITE_EIGENVALUE: u32 = 64u;
const WRITE_NORMALS: u32 = 128u;

struct Rows {
    // Names the frame in the header.
    frame: u32,
    half: u32,
    // Blocks of 4 columns in a slot.
    blocks: u32,
    // Bits: packings a, b and the single field have columns; others are nothing.
    made: u32,
    write: u32,
    // 0: exact; 1: without the mixed derivative; 2: none.
    normals: u32,
    // Of 16-bit storage.
    unscale_a: f32,
    unscale_b: f32,
    unscale_single: f32,
}

@group(0) @binding(0) var<uniform> rows: Rows;
@group(0) @binding(1) var<storage, read> twiddles: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read> between: array<Stored>;
@group(0) @binding(3) var<storage, read_write> planes: array<f32>;
@group(0) @binding(4) var<storage, read_write> assembled: array<f32>;

fn packed_at(slot: u32, z: u32, i: u32, unscale: f32) -> vec2<f32> {
    let back = N - i;
    if i > rows.half && back > rows.half {
        return vec2<f32>(0.0, 0.0);
    }
    let c = select(2u * rows.half + 1u - back, i, i <= rows.half);
    return restored(between[intermediate(slot, rows.blocks, c, z)], unscale);
}

// Sample i of the spectrum A + i B of two rows, each Hermitian.
fn single_at(z: u32, i: u32) -> vec2<f32> {
    let back = N - i;
    if i > rows.half && back > rows.half {
        return vec2<f32>(0.0, 0.0);
    }
    let c = select(back, i, i <= rows.half);
    let a = restored(between[intermediate(2u, rows.blocks, c, z)], rows.unscale_single);
    let b = restored(between[intermediate(2u, rows.blocks, c, z + 1u)], rows.unscale_single);
    if i == 0u {
        return vec2<f32>(a.x, b.x);
    }
    if i <= rows.half {
        return vec2<f32>(a.x - b.y, a.y + b.x);
    }
    return vec2<f32>(a.x + b.y, b.x - a.y);
}

fn packed(slot: u32, z: u32, unscale: f32, at: Place) -> Eight {
    let step = N / 8u;
    var x: Eight;
    x.a = packed_at(slot, z, at.pos, unscale);
    x.b = packed_at(slot, z, at.pos + step, unscale);
    x.c = packed_at(slot, z, at.pos + 2u * step, unscale);
    x.d = packed_at(slot, z, at.pos + 3u * step, unscale);
    x.e = packed_at(slot, z, at.pos + 4u * step, unscale);
    x.f = packed_at(slot, z, at.pos + 5u * step, unscale);
    x.g = packed_at(slot, z, at.pos + 6u * step, unscale);
    x.h = packed_at(slot, z, at.pos + 7u * step, unscale);
    return transform(x, at);
}

fn single(z: u32, at: Place) -> Eight {
    let step = N / 8u;
    var x: Eight;
    x.a = single_at(z, at.pos);
    x.b = single_at(z, at.pos + step);
    x.c = single_at(z, at.pos + 2u * step);
    x.d = single_at(z, at.pos + 3u * step);
    x.e = single_at(z, at.pos + 4u * step);
    x.f = single_at(z, at.pos + 5u * step);
    x.g = single_at(z, at.pos + 6u * step);
    x.h = single_at(z, at.pos + 7u * step);
    return transform(x, at);
}

// Writes one sample of every field that is wanted.
fn write(sample: u32, a: vec2<f32>, b: vec2<f32>, c: f32) {
    let plane = N * N;
    let here = HEADER + sample;
    if (rows.write & WRITE_A) != 0u {
        planes[here] = a.x;
        planes[here + plane] = a.y;
    }
    if (rows.write & WRITE_B) != 0u {
        planes[here + 2u * plane] = b.x;
        planes[here + 3u * plane] = b.y;
    }
    if (rows.write & WRITE_SINGLE) != 0u {
        planes[here + 4u * plane] = c;
    }
    let strain = vec3<f32>(b, c);
    if (rows.write & WRITE_JACOBIAN) != 0u {
        assembled[here] = determinant(strain);
    }
    if (rows.write & WRITE_EIGENVALUE) != 0u {
        assembled[here + plane] = smaller_eigenvalue(strain);
    }
    if (rows.write & WRITE_NORMALS) != 0u {
        var slope = seen(a, strain.x, strain.z, strain.z, strain.y);
        if rows.normals == 1u {
            slope = seen_diagonal(a, strain);
        }
        if rows.normals == 2u {
            slope = vec2<f32>(0.0, 0.0);
        }
        assembled[here + 2u * plane] = slope.x;
        assembled[here + 3u * plane] = slope.y;
    }
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let at = place(invocation);
    let pair = group.x * (2048u / N) + at.line;
    let used = pair < N / 2u;
    // Lines beyond the last take part in the barriers, and write nothing.
    let z0 = 2u * min(pair, N / 2u - 1u);
    var c: Eight;
    if (rows.made & 4u) != 0u {
        c = single(z0, at);
    }
    for (var row = 0u; row < 2u; row++) {
        let z = z0 + row;
        var a: Eight;
        if (rows.made & 1u) != 0u {
            a = packed(0u, z, rows.unscale_a, at);
        }
        var b: Eight;
        if (rows.made & 2u) != 0u {
            b = packed(1u, z, rows.unscale_b, at);
        }
        if used {
            let first = z * N + at.pos;
            let step = N / 8u;
            let second = row == 1u;
            write(first, a.a, b.a, select(c.a.x, c.a.y, second));
            write(first + step, a.b, b.b, select(c.b.x, c.b.y, second));
            write(first + 2u * step, a.c, b.c, select(c.c.x, c.c.y, second));
            write(first + 3u * step, a.d, b.d, select(c.d.x, c.d.y, second));
            write(first + 4u * step, a.e, b.e, select(c.e.x, c.e.y, second));
            write(first + 5u * step, a.f, b.f, select(c.f.x, c.f.y, second));
            write(first + 6u * step, a.g, b.g, select(c.g.x, c.g.y, second));
            write(first + 7u * step, a.h, b.h, select(c.h.x, c.h.y, second));
        }
    }
    if group.x == 0u && invocation == 0u {
        planes[0] = f32(rows.frame);
        assembled[0] = f32(rows.frame);
    }
}
