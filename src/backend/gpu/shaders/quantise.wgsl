// Numbers to 16-bit counts of a fixed step: twin of pass/quantise.rs, and of the averages in tile/level.rs for levels of
// foam. Two counts an invocation.

const WIDE: u32 = 1u;
const ODD: u32 = 2u;
const DONE: u32 = 4u;

struct Quantise {
    // The plane, and samples a side of it.
    plane: u32,
    n: u32,
    // Every so many samples one average; 1: the samples themselves.
    stride: u32,
    // Where the counts go, in words, and what is found about them.
    words: u32,
    found: u32,
    inverse_step: f32,
    share: f32,
    none: u32,
}

@group(0) @binding(0) var<storage, read> jobs: array<Quantise>;
@group(0) @binding(1) var<storage, read> source: array<f32>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;
@group(0) @binding(3) var<storage, read_write> found: array<atomic<u32>>;

fn sample(job: Quantise, x: u32, z: u32) -> f32 {
    let n = job.n;
    let plane = HEADER + job.plane * n * n;
    if job.stride == 1u {
        return source[plane + z * n + x];
    }
    // Weights fall linearly to nothing at the neighbouring samples.
    let reach = i32(job.stride);
    var sum = 0.0;
    for (var dz = 1 - reach; dz < reach; dz++) {
        var along = 0.0;
        let row = plane + ((z * job.stride + n + u32(dz)) % n) * n;
        for (var dx = 1 - reach; dx < reach; dx++) {
            along += f32(reach - abs(dx)) / f32(reach * reach) * source[row + (x * job.stride + n + u32(dx)) % n];
        }
        sum += f32(reach - abs(dz)) / f32(reach * reach) * along;
    }
    return min(sum, 1.0);
}

fn count(job: Quantise, x: u32, z: u32, seen: ptr<function, u32>) -> u32 {
    let value = sample(job, x, z) * job.share;
    let scaled = value * job.inverse_step;
    // Not a number, or infinite: by its bits, since shaders may assume that there is none.
    if (bitcast<u32>(value) & 0x7f800000u) == 0x7f800000u {
        *seen |= ODD;
    }
    if abs(scaled) > 32767.0 {
        *seen |= WIDE;
    }
    return u32(i32(round(clamp(scaled, -32767.0, 32767.0)))) & 0xffffu;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let job = jobs[group.y];
    let side = job.n / job.stride;
    let pair = group.x * 256u + invocation;
    if 2u * pair >= side * side {
        return;
    }
    let x = (2u * pair) % side;
    let z = (2u * pair) / side;
    var seen = select(0u, DONE, pair == 0u);
    let low = count(job, x, z, &seen);
    let high = count(job, x + 1u, z, &seen);
    counts[job.words + pair] = low | (high << 16u);
    if seen != 0u {
        atomicOr(&found[job.found], seen);
    }
}
