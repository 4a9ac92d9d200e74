//! Frequency spectra S(w), one-sided, m^2 s: their integral over w is m0.

use crate::scene::{Swell, SwellModel, WindModel, WindSea};

/// Non-dimensional fetch g F / U^2 at which JONSWAP's peak reaches that of a fully developed sea, fp = 0.13 g / U10
/// (Pierson & Moskowitz 1964): (22 / (2 pi 0.13))^3. Beyond it JONSWAP would grow a calm into a storm.
const FULLY_DEVELOPED: f64 = 19_538.6;
/// Phillips' constant of Pierson & Moskowitz (1964).
const PIERSON_MOSKOWITZ: f64 = 8.1e-3;
/// Wind at 19.5 m over that at 10 m, in the neutral profile that Pierson & Moskowitz's winds had.
const U19_OVER_U10: f64 = 1.026;

/// JONSWAP (Hasselmann et al. 1973), by wind and fetch or by height and period, and its special case of gamma 1,
/// Pierson & Moskowitz (1964).
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
    /// A wind sea. By JONSWAP it grows: alpha = 0.076 chi^-0.22, wp = 22 (g^2 / (U F))^(1/3), chi = g F / U^2, growth
    /// ending at the fully developed sea; by Pierson & Moskowitz it is developed. `None` without wind or fetch, and for
    /// models that are no frequency spectra.
    pub fn of_wind(wind: &WindSea, gravity: f64) -> Option<Self> {
        let u = wind.speed_mps;
        let (alpha, peak, gamma) = match wind.model {
            WindModel::Jonswap => {
                let chi = (gravity * wind.fetch_m / (u * u)).min(FULLY_DEVELOPED);
                let peak = 22.0 * gravity / u * libm::pow(chi, -1.0 / 3.0);
                (0.076 * libm::pow(chi, -0.22), peak, wind.gamma)
            }
            WindModel::PiersonMoskowitzU10 => (PIERSON_MOSKOWITZ, 2.0 * std::f64::consts::PI * 0.13 * gravity / u, 1.0),
            WindModel::PiersonMoskowitzU19 => (PIERSON_MOSKOWITZ, 0.877 * gravity / (U19_OVER_U10 * u), 1.0),
            WindModel::Elfouhaily | WindModel::Phillips => return None,
        };
        // Without wind or fetch the peak is infinite or no number.
        (u > 0.0 && alpha > 0.0 && alpha.is_finite() && peak.is_finite()).then_some(Self {
            scale: alpha * gravity * gravity,
            peak,
            ln_gamma: libm::log(gamma),
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

/// One peak of Ochi & Hubble (1976, eq. 3): a gamma distribution of w^-4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OchiHubble {
    peak: f64,
    lambda: f64,
    /// Logarithm of everything that does not depend on w.
    ln_scale: f64,
}

impl OchiHubble {
    /// A peak of given height, period and shape; `None` when it is flat.
    pub fn of_swell(swell: &Swell) -> Option<Self> {
        if swell.model != SwellModel::OchiHubble || swell.hs_m <= 0.0 {
            return None;
        }
        let (peak, lambda) = (2.0 * std::f64::consts::PI / swell.tp_s, swell.lambda);
        let a = lambda + 0.25;
        let ln_scale = lambda * (libm::log(a) + 4.0 * libm::log(peak)) - libm::lgamma(lambda)
            + libm::log(0.25 * swell.hs_m * swell.hs_m);
        Some(Self { peak, lambda, ln_scale })
    }

    /// Peak angular frequency, rad/s.
    pub fn peak(&self) -> f64 {
        self.peak
    }

    /// S(w), m^2 s.
    pub fn density(&self, omega: f64) -> f64 {
        let x = self.peak / omega;
        let fall = (self.lambda + 0.25) * x * x * x * x;
        if fall >= 700.0 || fall.is_nan() {
            return 0.0;
        }
        libm::exp(self.ln_scale - (4.0 * self.lambda + 1.0) * libm::log(omega) - fall)
    }
}
