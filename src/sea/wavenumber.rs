//! Spectra given over wavenumbers, F(k), m^3: their integral over k is m0.

use crate::scene::{Water, WindModel, WindSea};

/// Slowest wave, m/s, and its wavenumber, rad/m (Elfouhaily et al. 1997, eq. 24).
const SLOWEST: f64 = 0.23;
const SLOWEST_K: f64 = 370.0;

/// The unified spectrum of Elfouhaily et al. (1997): long waves by age, short waves by the wind's stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elfouhaily {
    gravity: f64,
    /// Inverse wave age U10 / cp.
    age: f64,
    peak_k: f64,
    /// Half of alpha_p cp, and of alpha_m cm.
    long: f64,
    short: f64,
    ln_gamma: f64,
    sigma: f64,
}

impl Elfouhaily {
    /// Of a wind and fetch (eq. 31, 32, 37, 44); `None` without wind or fetch. The stress is by Wu's (1982) drag.
    pub fn of_wind(wind: &WindSea, water: &Water) -> Option<Self> {
        let (u, g) = (wind.speed_mps, water.gravity);
        if wind.model != WindModel::Elfouhaily || !(u > 0.0 && wind.fetch_m > 0.0) {
            return None;
        }
        let fetch = g * wind.fetch_m / (u * u);
        // The published growth has no end towards small fetches: young waves of age 5 are the limit of its data.
        let age = (0.84 * libm::pow(libm::tanh(libm::pow(fetch / 2.2e4, 0.4)), -0.75)).min(5.0);
        let friction = u * libm::sqrt((0.8 + 0.065 * u) * 1e-3);
        let stress = libm::log(friction / SLOWEST);
        // Below 2.7 m/s alpha_m would be negative, and with it the spectrum.
        let alpha_m = (1e-2 * (1.0 + if stress > 0.0 { 3.0 * stress } else { stress })).max(0.0);
        let gamma = if age < 1.0 { 1.7 } else { 1.7 + 6.0 * libm::log10(age) };
        let peak_k = g * age * age / (u * u);
        peak_k.is_finite().then_some(Self {
            gravity: g,
            age,
            peak_k,
            long: 0.5 * 6e-3 * libm::sqrt(age) * u / age,
            short: 0.5 * alpha_m * SLOWEST,
            ln_gamma: libm::log(gamma),
            sigma: 0.08 * (1.0 + 4.0 / (age * age * age)),
        })
    }

    /// Wavenumber of the peak, rad/m.
    pub fn peak_k(&self) -> f64 {
        self.peak_k
    }

    /// F(k), m^3: (B_l + B_h) / k^3 (eq. 30, 40).
    pub fn density(&self, k: f64) -> f64 {
        let root = libm::sqrt(k / self.peak_k);
        let fall = 1.25 / (root * root * root * root);
        if fall >= 700.0 || fall.is_nan() {
            return 0.0;
        }
        let off = (root - 1.0) / self.sigma;
        let peaked = libm::exp(self.ln_gamma * libm::exp(-0.5 * off * off) - fall);
        let long = self.long * libm::exp(-self.age / libm::sqrt(10.0) * (root - 1.0));
        let from_slowest = k / SLOWEST_K - 1.0;
        let short = self.short * libm::exp(-0.25 * from_slowest * from_slowest);
        let ratio = k / SLOWEST_K;
        let speed = libm::sqrt(self.gravity / k * (1.0 + ratio * ratio));
        (long + short) * peaked / (speed * k * k * k)
    }
}

/// Phillips' equilibrium range with Tessendorf's (2001, eq. 40, 41) cuts: alpha / 2 exp(-1 / (k L)^2 - (k l)^2) / k^3,
/// L = U^2 / g.
///
/// Tessendorf's A exp(-1 / (k L)^2) / k^4 cos^2 over wave vectors is this with cos^2 spreading and A = alpha / pi; his
/// A hides the size of his grid's cells, this one doesn't.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phillips {
    alpha: f64,
    /// L and l, metres.
    largest: f64,
    smallest: f64,
}

impl Phillips {
    /// Of a wind; `None` without wind.
    pub fn of_wind(wind: &WindSea, water: &Water) -> Option<Self> {
        let largest = wind.speed_mps * wind.speed_mps / water.gravity;
        let made = wind.model == WindModel::Phillips && largest > 0.0 && wind.alpha > 0.0;
        made.then_some(Self { alpha: wind.alpha, largest, smallest: wind.small_wave_m })
    }

    /// Wavenumber of the peak of the spectrum over frequencies, rad/m: (k L)^2 = 4 / 5 in deep water.
    pub fn peak_k(&self) -> f64 {
        libm::sqrt(0.8) / self.largest
    }

    /// F(k), m^3.
    pub fn density(&self, k: f64) -> f64 {
        let (kl, ks) = (k * self.largest, k * self.smallest);
        let fall = 1.0 / (kl * kl) + ks * ks;
        if fall >= 700.0 || fall.is_nan() {
            return 0.0;
        }
        0.5 * self.alpha * libm::exp(-fall) / (k * k * k)
    }
}
