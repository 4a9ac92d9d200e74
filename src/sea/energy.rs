//! Frequency spectra S(w), one-sided, m^2 s: their integral over w is m0.

use crate::scene::{Swell, WindSea};

/// Non-dimensional fetch g F / U^2 at which JONSWAP's peak reaches that of a fully developed sea, fp = 0.13 g / U10
/// (Pierson & Moskowitz 1964): (22 / (2 pi 0.13))^3. Beyond it JONSWAP would grow a calm into a storm.
const FULLY_DEVELOPED: f64 = 19_538.6;

/// JONSWAP (Hasselmann et al. 1973), by wind and fetch or by height and period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jonswap {
    /// Energy scale: alpha g^2.
    scale: f64,
    /// Peak, rad/s.
    peak: f64,
    /// Logarithm of the peak enhancement.
    ln_gamma: f64,
}

impl Jonswap {
    /// A growing wind sea: alpha = 0.076 chi^-0.22, wp = 22 (g^2 / (U F))^(1/3), chi = g F / U^2, growth ending at
    /// the fully developed sea. `None` without wind or fetch.
    pub fn of_wind(wind: &WindSea, gravity: f64) -> Option<Self> {
        let (u, fetch) = (wind.speed_mps, wind.fetch_m);
        let chi = (gravity * fetch / (u * u)).min(FULLY_DEVELOPED);
        // Also false for the NaN of no wind and no fetch.
        if !(chi > 0.0 && u > 0.0) {
            return None;
        }
        let alpha = 0.076 * libm::pow(chi, -0.22);
        let peak = 22.0 * gravity / u * libm::pow(chi, -1.0 / 3.0);
        (alpha.is_finite() && peak.is_finite()).then_some(Self {
            scale: alpha * gravity * gravity,
            peak,
            ln_gamma: libm::log(wind.gamma),
        })
    }

    /// A sea of given height and peak period, normalised numerically so that Hs is exact (DNV-RP-C205 3.5.5).
    pub fn of_swell(swell: &Swell) -> Option<Self> {
        let unit = Self { scale: 1.0, peak: 2.0 * std::f64::consts::PI / swell.tp_s, ln_gamma: libm::log(swell.gamma) };
        let scale = swell.hs_m * swell.hs_m / 16.0 / unit.m0();
        (scale > 0.0).then_some(Self { scale, ..unit })
    }

    /// Peak angular frequency, rad/s.
    pub fn peak(&self) -> f64 {
        self.peak
    }

    /// S(w), m^2 s.
    pub fn density(&self, omega: f64) -> f64 {
        let x = omega / self.peak;
        let fall = 1.25 / (x * x * x * x);
        // exp(-700) is the last that is not zero; w^-5 would be infinite beside it.
        if fall >= 700.0 || fall.is_nan() {
            return 0.0;
        }
        let sigma = if x <= 1.0 { 0.07 } else { 0.09 };
        let r = libm::exp(-(x - 1.0) * (x - 1.0) / (2.0 * sigma * sigma));
        let squared = omega * omega;
        self.scale / (squared * squared * omega) * libm::exp(r * self.ln_gamma - fall)
    }

    /// Zeroth moment, m^2, to 1e-6: the integral of S(w) over w from 0.2 to 150 peaks (1e-9 of it lies outside).
    pub fn m0(&self) -> f64 {
        // Midpoint rule in ln w, with the kink of sigma at the peak on a cell's edge.
        const BELOW: i32 = 1000;
        const ABOVE: i32 = 3112;
        let width = libm::log(5.0) / f64::from(BELOW);
        let at = |i: i32| {
            let omega = self.peak * libm::exp((f64::from(i) + 0.5) * width);
            self.density(omega) * omega
        };
        (-BELOW..ABOVE).map(at).sum::<f64>() * width
    }
}

/// Kitaigorodskii's depth attenuation (Bouws et al. 1985, exact form) at the k d of a wave:
/// tanh^2(kd) / (1 + 2 kd / sinh(2 kd)).
pub fn tma(kd: f64) -> f64 {
    if kd >= 20.0 {
        return 1.0;
    }
    let tanh = libm::tanh(kd);
    // 2kd / sinh(2kd) tends to 1 in shallow water.
    let ratio = if kd < 1e-6 { 1.0 } else { 2.0 * kd / libm::sinh(2.0 * kd) };
    tanh * tanh / (1.0 + ratio)
}
