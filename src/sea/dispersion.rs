//! How fast a wave of a length turns: w^2 = (g k + (sigma/rho) k^3) tanh(k d), with its exact derivative.

use crate::scene::Water;

/// Above this k d the bottom is not felt: tanh is 1 to the last bit of an f64.
const DEEP: f64 = 20.0;
/// Largest ratio of horizontal to vertical orbit that shallow water gives.
const MAX_WIDENING: f64 = 3.0;

/// Gravity-capillary dispersion over a flat bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dispersion {
    water: Water,
}

impl Dispersion {
    /// The dispersion of a water body.
    pub fn new(water: Water) -> Self {
        Self { water }
    }

    /// Angular frequency (rad/s) of wavenumber `k` (rad/m).
    pub fn omega(&self, k: f64) -> f64 {
        libm::sqrt(self.restoring(k) * self.tanh_kd(k))
    }

    /// Derivative of angular frequency by wavenumber: the group velocity, m/s. `k` above 0.
    pub fn group_velocity(&self, k: f64) -> f64 {
        let (kd, tanh) = (self.kd(k), self.tanh_kd(k));
        let Water { gravity, tension, depth_m } = self.water;
        let bottom = if kd < DEEP { self.restoring(k) * depth_m / (libm::cosh(kd) * libm::cosh(kd)) } else { 0.0 };
        ((gravity + 3.0 * tension * k * k) * tanh + bottom) / (2.0 * self.omega(k))
    }

    /// Wavenumber (rad/m) of angular frequency `omega` (rad/s), the inverse of [`Self::omega`] to 1e-12.
    pub fn wavenumber(&self, omega: f64) -> f64 {
        if omega <= 0.0 || !omega.is_finite() {
            return if omega > 0.0 { f64::INFINITY } else { 0.0 };
        }
        // omega(k) rises from 0: bracket, then bisect in the logarithm; called a few times per spectrum.
        let (mut low, mut high) = (1e-12, 1e-12);
        while self.omega(high) < omega {
            low = high;
            high *= 4.0;
        }
        for _ in 0..100 {
            let middle = libm::sqrt(low * high);
            if self.omega(middle) < omega { low = middle } else { high = middle }
        }
        libm::sqrt(low * high)
    }

    /// Ratio of horizontal to vertical orbit at the surface, coth(k d), at most 3.
    pub fn depth_widening(&self, k: f64) -> f64 {
        (1.0 / self.tanh_kd(k)).min(MAX_WIDENING)
    }

    /// k d, clamped where the bottom is no longer felt (cosh would overflow).
    pub fn kd(&self, k: f64) -> f64 {
        (k * self.water.depth_m).min(DEEP)
    }

    fn tanh_kd(&self, k: f64) -> f64 {
        let kd = self.kd(k);
        if kd < DEEP { libm::tanh(kd) } else { 1.0 }
    }

    fn restoring(&self, k: f64) -> f64 {
        self.water.gravity * k + self.water.tension * k * k * k
    }
}
