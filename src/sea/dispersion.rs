//! How fast a wave of a length turns: w^2 = (g k + (sigma/rho) k^3) tanh(k d), with its exact derivative, and integrals
//! over wavenumbers.

use crate::scene::{DispersionLaw, Water};

/// Above this k d the bottom is not felt: tanh is 1 to the last bit of an f64.
const DEEP: f64 = 20.0;
/// Largest ratio of horizontal to vertical orbit that shallow water gives.
const MAX_WIDENING: f64 = 3.0;

/// Steps of an integral over wavenumbers.
const STEPS: u32 = 2000;

/// Gravity-capillary dispersion over a flat bottom, and the laws that leave out tension, or the bottom, too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dispersion {
    water: Water,
    /// Surface tension over density as the waves feel it, m^3/s^2.
    tension: f64,
    /// Depth as the waves feel it, metres.
    depth_m: f64,
}

impl Dispersion {
    /// The dispersion of a water body.
    pub fn new(water: Water) -> Self {
        let tension = match water.dispersion {
            DispersionLaw::Capillary => water.surface_tension / water.density,
            DispersionLaw::Deep | DispersionLaw::Finite => 0.0,
        };
        let depth_m = if water.dispersion == DispersionLaw::Deep { f64::INFINITY } else { water.depth_m };
        Self { water, tension, depth_m }
    }

    /// The water body.
    pub fn water(&self) -> &Water {
        &self.water
    }

    /// Depth as the waves feel it, metres.
    pub fn depth_m(&self) -> f64 {
        self.depth_m
    }

    /// Angular frequency (rad/s) of wavenumber `k` (rad/m).
    pub fn omega(&self, k: f64) -> f64 {
        libm::sqrt(self.restoring(k) * self.tanh_kd(k))
    }

    /// Wavenumber and group velocity that a wave of `omega` has over deep water.
    pub fn over_deep(&self, omega: f64) -> (f64, f64) {
        let (gravity, tension) = (self.water.gravity, self.tension);
        // Newton's method from the right on g k + tau k^3, which is convex: it never steps too far.
        let mut k = omega * omega / gravity;
        for _ in 0..40 {
            let next = k - (gravity * k + tension * k * k * k - omega * omega) / (gravity + 3.0 * tension * k * k);
            if libm::fabs(next - k) <= 1e-14 * k {
                break;
            }
            k = next;
        }
        (k, (gravity + 3.0 * tension * k * k) / (2.0 * omega))
    }

    /// Derivative of angular frequency by wavenumber: the group velocity, m/s. `k` above 0.
    pub fn group_velocity(&self, k: f64) -> f64 {
        let (kd, tanh) = (self.kd(k), self.tanh_kd(k));
        let (gravity, tension) = (self.water.gravity, self.tension);
        let bottom = if kd < DEEP { self.restoring(k) * self.depth_m / (libm::cosh(kd) * libm::cosh(kd)) } else { 0.0 };
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

    /// Integral over wavenumbers from `low` to `high` (rad/m) of a density that is told k, omega and group velocity.
    pub fn integrate(&self, low: f64, high: f64, density: impl Fn(f64, f64, f64) -> f64) -> f64 {
        let mut sum = 0.0;
        self.each_wavenumber(low, high, |k, omega, cg, width| sum += density(k, omega, cg) * width);
        sum
    }

    /// Visits cells of a range of wavenumbers, shortest waves first: k, omega, group velocity and width, rad/m. The
    /// midpoint rule in ln k.
    pub fn each_wavenumber(&self, low: f64, high: f64, mut visit: impl FnMut(f64, f64, f64, f64)) {
        let (from, width) = (libm::log(low), (libm::log(high) - libm::log(low)) / f64::from(STEPS));
        for i in (0..STEPS).rev() {
            let k = libm::exp(from + (f64::from(i) + 0.5) * width);
            visit(k, self.omega(k), self.group_velocity(k), k * width);
        }
    }

    /// k d, clamped where the bottom is no longer felt (cosh would overflow).
    pub fn kd(&self, k: f64) -> f64 {
        (k * self.depth_m).min(DEEP)
    }

    fn tanh_kd(&self, k: f64) -> f64 {
        let kd = self.kd(k);
        if kd < DEEP { libm::tanh(kd) } else { 1.0 }
    }

    fn restoring(&self, k: f64) -> f64 {
        self.water.gravity * k + self.tension * k * k * k
    }
}
