//! Exact time: a mode's phase is a wrapping product of integers, the same after ten years as after ten seconds.

use crate::wire::TICKS_PER_SECOND;

/// Whole cycles that a wave of `omega` (rad/s) makes in one repeat period of `repeat` ticks; at least 1, because a
/// long wave must not freeze.
pub fn cycles_per_repeat(omega: f64, repeat: u64) -> u32 {
    let cycles = omega * repeat as f64 / (2.0 * std::f64::consts::PI * TICKS_PER_SECOND as f64);
    libm::round(cycles).clamp(1.0, f64::from(u32::MAX)) as u32
}

/// The tick as a 32-bit fraction of the repeat period: round(2^32 (tick mod P) / P).
pub fn turn_of_tick(tick: i64, repeat: u64) -> u32 {
    let within = i128::from(tick).rem_euclid(i128::from(repeat)) as u128;
    let repeat = u128::from(repeat);
    // A full turn wraps to none.
    (((within << 32) + repeat / 2) / repeat) as u32
}

/// Cosine and sine of a 32-bit fraction of a turn, in units of 2^-24, to 3.5e-8.
///
/// Integer arithmetic throughout, so it is the same on every processor: reduced to an eighth of a turn either side
/// of a quarter, then polynomials in t^2 fitted to the largest error, coefficients in units of 2^-30.
pub fn cos_sin_q24(turn: u32) -> (i32, i32) {
    const SIN: [i64; 4] = [843_314_854, -86_699_750, 2_673_625, -38_606];
    const COS: [i64; 5] = [1_073_741_824, -331_168_967, 17_023_452, -349_974, 3_790];
    let quarter = turn.wrapping_add(1 << 29) >> 30;
    // Sign-extended rest of the turn, stretched so that an eighth of a turn is 2^31.
    let t = i64::from((turn.wrapping_sub(quarter << 30) as i32) << 2);
    let t2 = (t * t) >> 31;
    let polynomial = |c: &[i64]| c.iter().rev().fold(0_i64, |sum, c| ((sum * t2) >> 31) + c);
    let to_q24 = |q30: i64| ((q30 + (1 << 5)) >> 6) as i32;
    let cos = to_q24(polynomial(&COS));
    let sin = to_q24((polynomial(&SIN) * t) >> 31);
    match quarter & 3 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// The same as f32: exact, since both have 24 bits.
#[inline(always)]
pub fn cos_sin(turn: u32) -> (f32, f32) {
    const Q24: f32 = 1.0 / 16_777_216.0;
    let (cos, sin) = cos_sin_q24(turn);
    (cos as f32 * Q24, sin as f32 * Q24)
}
