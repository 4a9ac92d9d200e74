// The first pass: modes to a tick, to the spectra of a packing, and these along z. Empty columns are not made.

struct Columns {
    // The tick as a fraction of the repeat period.
    turn: u32,
    // Highest mode of this grid, and of the table.
    half: u32,
    table_half: u32,
    // Blocks of 4 columns in a slot.
    blocks: u32,
    // Of those packings that run: slot, kind, and whether it is of the rate.
    slot0: u32, kind0: u32, rate0: u32,
    slot1: u32, kind1: u32, rate1: u32,
    slot2: u32, kind2: u32, rate2: u32,
    // Spacing of wavenumbers, rad/m.
    dk: f32,
    // Of 16-bit storage, by the packings that run.
    scale0: f32, scale1: f32, scale2: f32,
}

@group(0) @binding(0) var<uniform> columns: Columns;
@group(0) @binding(1) var<storage, read> table: array<Mode>;
@group(0) @binding(2) var<storage, read> twiddles: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> between: array<Stored>;

struct Packing {
    slot: u32,
    kind: u32,
    rate: u32,
    scale: f32,
}

fn packing(index: u32) -> Packing {
    switch index {
        case 0u: { return Packing(columns.slot0, columns.kind0, columns.rate0, columns.scale0); }
        case 1u: { return Packing(columns.slot1, columns.kind1, columns.rate1, columns.scale1); }
        default: { return Packing(columns.slot2, columns.kind2, columns.rate2, columns.scale2); }
    }
}

// Sample i of the spectrum of column n, in the order m = 0, 1, .. -2, -1.
fn sample(packing: Packing, n: i32, i: u32) -> vec2<f32> {
    let half = i32(columns.half);
    let m = select(i32(i) - i32(N), i32(i), i <= columns.half);
    if abs(m) > half || abs(n) > half {
        return vec2<f32>(0.0, 0.0);
    }
    // Modes with n < 0 are the conjugates of their opposites.
    let opposite = n < 0;
    let to = select(m, -m, opposite);
    let rows = 2 * i32(columns.table_half) + 1;
    let mode = table[u32(abs(n) * rows + i32(columns.table_half) + to)];
    let cs = turned(mode, columns.turn);
    var h = height(mode, cs);
    if packing.rate != 0u {
        h = rate(mode, cs);
    }
    let k = vec2<f32>(f32(abs(n)), f32(to)) * columns.dk;
    return spectrum(packing.kind, h, k.x, k.y, mode.chop, opposite);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let packing = packing(group.y);
    let single = packing.kind == HEIGHT || packing.kind == SHEAR;
    let count = select(2u * columns.half + 1u, columns.half + 1u, single);
    let first = group.x * (2048u / N);
    if first >= count {
        return;
    }
    let at = place(invocation);
    let c = first + at.line;
    // Behind the columns of n = 0..=half those of n = -half..=-1.
    let n = select(i32(c) - i32(2u * columns.half + 1u), i32(c), c <= columns.half);
    let step = N / 8u;
    let used = c < count;
    var x: Eight;
    if used {
        x.a = sample(packing, n, at.pos);
        x.b = sample(packing, n, at.pos + step);
        x.c = sample(packing, n, at.pos + 2u * step);
        x.d = sample(packing, n, at.pos + 3u * step);
        x.e = sample(packing, n, at.pos + 4u * step);
        x.f = sample(packing, n, at.pos + 5u * step);
        x.g = sample(packing, n, at.pos + 6u * step);
        x.h = sample(packing, n, at.pos + 7u * step);
    }
    x = transform(x, at);
    if used {
        let slot = packing.slot;
        let blocks = columns.blocks;
        between[intermediate(slot, blocks, c, at.pos)] = stored(x.a, packing.scale);
        between[intermediate(slot, blocks, c, at.pos + step)] = stored(x.b, packing.scale);
        between[intermediate(slot, blocks, c, at.pos + 2u * step)] = stored(x.c, packing.scale);
        between[intermediate(slot, blocks, c, at.pos + 3u * step)] = stored(x.d, packing.scale);
        between[intermediate(slot, blocks, c, at.pos + 4u * step)] = stored(x.e, packing.scale);
        between[intermediate(slot, blocks, c, at.pos + 5u * step)] = stored(x.f, packing.scale);
        between[intermediate(slot, blocks, c, at.pos + 6u * step)] = stored(x.g, packing.scale);
        between[intermediate(slot, blocks, c, at.pos + 7u * step)] = stored(x.h, packing.scale);
    }
}
