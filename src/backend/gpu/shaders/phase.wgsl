// Exact time: cosine and sine of a 32-bit fraction of a turn in integer arithmetic, bit for bit those of sea/phase.rs.

// The upper 32 bits of a product of two unsigned numbers.
fn high(a: u32, b: u32) -> u32 {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let middle = a1 * b0 + ((a0 * b0) >> 16u);
    let low = a0 * b1 + (middle & 0xffffu);
    return a1 * b1 + (middle >> 16u) + (low >> 16u);
}

// (a t2) >> 31, rounded down, where t2 is at most 2^31.
fn times_square(a: i32, t2: u32) -> i32 {
    let bits = bitcast<u32>(a);
    let upper = high(bits, t2) - select(0u, t2, a < 0);
    return bitcast<i32>((upper << 1u) | ((bits * t2) >> 31u));
}

// (a b) >> 31, rounded down.
fn times(a: i32, b: i32) -> i32 {
    let x = bitcast<u32>(a);
    let y = bitcast<u32>(b);
    let upper = high(x, y) - select(0u, y, a < 0) - select(0u, x, b < 0);
    return bitcast<i32>((upper << 1u) | ((x * y) >> 31u));
}

fn to_q24(q30: i32) -> i32 {
    return (q30 + 32) >> 6u;
}

// Reduced to an eighth of a turn either side of a quarter, then polynomials in t^2, coefficients in units of 2^-30.
fn cos_sin(turn: u32) -> vec2<f32> {
    let quarter = (turn + (1u << 29u)) >> 30u;
    let t = bitcast<i32>((turn - (quarter << 30u)) << 2u);
    let size = bitcast<u32>(abs(t));
    let t2 = (high(size, size) << 1u) | ((size * size) >> 31u);
    var c = times_square(3790, t2) - 349974;
    c = times_square(c, t2) + 17023452;
    c = times_square(c, t2) - 331168967;
    c = times_square(c, t2) + 1073741824;
    var s = times_square(-38606, t2) + 2673625;
    s = times_square(s, t2) - 86699750;
    s = times_square(s, t2) + 843314854;
    let cos = f32(to_q24(c)) * (1.0 / 16777216.0);
    let sin = f32(to_q24(times(s, t))) * (1.0 / 16777216.0);
    switch quarter & 3u {
        case 0u: { return vec2<f32>(cos, sin); }
        case 1u: { return vec2<f32>(-sin, cos); }
        case 2u: { return vec2<f32>(-cos, -sin); }
        default: { return vec2<f32>(sin, -cos); }
    }
}
