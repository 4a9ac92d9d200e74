//! Counter-based random numbers: the draw of a mode depends on its name alone, on every machine.

/// Two independent standard normal numbers for mode (n, m) of a patch.
///
/// The same patch on another grid has the same waves. An integer hash gives u = (r + 1/2) / 2^32, never 0;
/// Box & Muller (1958) in portable f64 arithmetic makes it normal.
pub fn gaussian_pair(seed: u64, patch: u32, n: i32, m: i32) -> (f64, f64) {
    normal(place(seed, patch, n, m))
}

/// A number of random direction in the plane, its length log-normal and of mean square 2, as a Gaussian pair has.
/// `sigma` is the standard deviation of the length's logarithm.
pub fn log_normal_pair(sigma: f64, seed: u64, patch: u32, n: i32, m: i32) -> (f64, f64) {
    let bits = place(seed, patch, n, m);
    // E exp(2 sigma g) = exp(2 sigma^2).
    let length = std::f64::consts::SQRT_2 * libm::exp(sigma * normal(bits).0 - sigma * sigma);
    let angle = 2.0 * std::f64::consts::PI * unit(mix(bits) as u32);
    (length * libm::cos(angle), length * libm::sin(angle))
}

/// Random bits of a mode's name.
fn place(seed: u64, patch: u32, n: i32, m: i32) -> u64 {
    let place = (u64::from(n as u32) << 32) | u64::from(m as u32);
    mix(mix(mix(seed) ^ u64::from(patch).wrapping_mul(0x9e37_79b9_7f4a_7c15)) ^ place)
}

/// Two standard normal numbers out of 64 bits.
pub(super) fn normal(bits: u64) -> (f64, f64) {
    let radius = libm::sqrt(-2.0 * libm::log(unit((bits >> 32) as u32)));
    let angle = 2.0 * std::f64::consts::PI * unit(bits as u32);
    (radius * libm::cos(angle), radius * libm::sin(angle))
}

fn unit(bits: u32) -> f64 {
    (f64::from(bits) + 0.5) / 4_294_967_296.0
}

/// Finaliser of SplitMix64 (Steele, Lea & Flood 2014), after its own increment so that 0 is not a fixed point.
pub(super) fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
