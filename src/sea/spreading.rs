//! Directional spreading D(w, theta) around the mean travel direction; every form integrates to 1 over theta.

use std::f64::consts::PI;

/// Largest spreading exponent: a beam of 1.8 degrees.
const MAX_S: f64 = 2000.0;

/// cos^2s(theta / 2), normalised: D in 1/rad, of the cosine of theta. `s` from 0 (even) up.
pub fn cos2s(s: f64, cos_theta: f64) -> f64 {
    let s = s.clamp(0.0, MAX_S);
    // cos^2(theta / 2) = (1 + cos theta) / 2; rounding may bring it a hair below 0.
    let squared = (0.5 + 0.5 * cos_theta).max(0.0);
    // 0^0 is 1: with s = 0 energy goes everywhere.
    let shape = if s == 0.0 { 1.0 } else { libm::exp(s * libm::log(squared)) };
    shape * cos2s_norm(s)
}

/// Gamma(s + 1) / (2 sqrt(pi) Gamma(s + 1/2)).
fn cos2s_norm(s: f64) -> f64 {
    // Stirling's series of the ratio, at s + 8 where it holds to 1e-13, brought down by Gamma(x+1) = x Gamma(x):
    // the difference of two log-gammas costs ten times as much, and this is called for every point of every cell.
    let mut down = 1.0;
    let mut x = s;
    while x < 8.0 {
        down *= (x + 0.5) / (x + 1.0);
        x += 1.0;
    }
    down * gamma_ratio(x) / (2.0 * libm::sqrt(PI))
}

/// Gamma(x + 1) / Gamma(x + 1/2) for x of 8 and more, to 1e-10 (expansion in 1/z about z = x + 1/4).
fn gamma_ratio(x: f64) -> f64 {
    let z = x + 0.25;
    let w = 1.0 / (z * z);
    libm::sqrt(z) * (1.0 + w * (1.0 / 64.0 + w * (-19.0 / 8192.0 + w * (631.0 / 524_288.0))))
}

/// Exponent s of Hasselmann et al. (1980): `x` = w / wp, `inverse_age` = U wp / g.
pub fn hasselmann_s(x: f64, inverse_age: f64) -> f64 {
    let s = if x <= 1.0 { 6.97 * power(x, 4.06) } else { 9.77 * power(x, -2.33 - 1.45 * (inverse_age - 1.17)) };
    s.clamp(0.0, MAX_S)
}

/// x^p of a positive x, to 1e-13: half the price of a correctly rounded power.
fn power(x: f64, p: f64) -> f64 {
    libm::exp(p * libm::log(x))
}

/// What swell adds to s (Horvath 2015, eq. 44): 16 tanh(wp / w) xi^2; energy narrows at low frequencies.
pub fn horvath_swell_s(x: f64, xi: f64) -> f64 {
    16.0 * libm::tanh(1.0 / x) * xi * xi
}
