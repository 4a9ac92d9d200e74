// Turns a mode to a tick: h(k, t) = h0(k) e^-i phi + conj(h0(-k)) e^+i phi, and its rate; twin of pass/evolve.rs.

// With phase phi, h = (p cos + q sin) + i (r cos + t sin).
struct Mode {
    p: f32,
    q: f32,
    r: f32,
    t: f32,
    cycles: u32,
    offset: u32,
    // rad/s
    omega: f32,
    // Choppiness times widening over wavenumber, metres.
    chop: f32,
}

fn turned(mode: Mode, turn: u32) -> vec2<f32> {
    return cos_sin(mode.cycles * turn + mode.offset);
}

fn height(mode: Mode, cs: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(mode.p * cs.x + mode.q * cs.y, mode.r * cs.x + mode.t * cs.y);
}

fn rate(mode: Mode, cs: vec2<f32>) -> vec2<f32> {
    return mode.omega * vec2<f32>(mode.q * cs.x - mode.p * cs.y, mode.t * cs.x - mode.r * cs.y);
}
