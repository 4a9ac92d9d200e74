//! One wave system of a sea: its spectrum over wavenumbers, its spreading, its direction.

use super::dispersion::Dispersion;
use super::energy::{Jonswap, OchiHubble};
use super::shoaling::{kitaigorodskii, thompson_vincent};
use super::spreading::Spreader;
use super::wavenumber::{Elfouhaily, Phillips};
use crate::scene::{DepthCorrection, Swell, SwellModel, WindModel, WindSea};

/// U wp / g of a fully developed sea (Pierson & Moskowitz 1964): what systems without a wind are spread by.
const DEVELOPED_INVERSE_AGE: f64 = 0.82;

/// A system ready to be evaluated.
#[derive(Clone, Debug)]
pub struct System {
    shape: Shape,
    depth: DepthCorrection,
    /// Factor on its energy.
    scale: f64,
    spreader: Spreader,
    /// Unit vector of travel (x, z).
    toward: (f64, f64),
    /// Wavenumber of the peak, rad/m, and its angular frequency, rad/s.
    peak_k: f64,
    peak: f64,
    m0: f64,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Jonswap(Jonswap),
    OchiHubble(OchiHubble),
    Elfouhaily(Elfouhaily),
    Phillips(Phillips),
}

impl Shape {
    /// Wavenumber of the peak, rad/m.
    fn peak_k(&self, dispersion: &Dispersion) -> f64 {
        match self {
            Self::Jonswap(shape) => dispersion.wavenumber(shape.peak()),
            Self::OchiHubble(shape) => dispersion.wavenumber(shape.peak()),
            Self::Elfouhaily(shape) => shape.peak_k(),
            Self::Phillips(shape) => shape.peak_k(),
        }
    }

    /// Range of wavenumbers, rad/m, that holds all but 1e-4 of the energy.
    fn range(&self, peak_k: f64, dispersion: &Dispersion) -> (f64, f64) {
        let by_frequency = |peak: f64| (dispersion.wavenumber(0.1 * peak), dispersion.wavenumber(150.0 * peak));
        match self {
            Self::Jonswap(shape) => by_frequency(shape.peak()),
            Self::OchiHubble(shape) => by_frequency(shape.peak()),
            // Its short waves have a hump of their own.
            Self::Elfouhaily(_) => (0.01 * peak_k, (2e4 * peak_k).max(5e3)),
            Self::Phillips(_) => (0.01 * peak_k, 2e4 * peak_k),
        }
    }
}

/// Unit vector (x, z) in which waves from `from_deg` (clockwise from north) travel; +X east, +Z south.
fn toward(from_deg: f64) -> (f64, f64) {
    let from = from_deg.to_radians();
    (-libm::sin(from), libm::cos(from))
}

impl System {
    /// A wind sea; `None` where the wind raises none.
    pub fn of_wind(wind: &WindSea, dispersion: &Dispersion) -> Option<Self> {
        let water = dispersion.water();
        let shape = match wind.model {
            WindModel::Elfouhaily => Shape::Elfouhaily(Elfouhaily::of_wind(wind, water)?),
            WindModel::Phillips => Shape::Phillips(Phillips::of_wind(wind, water)?),
            _ => Shape::Jonswap(Jonswap::of_wind(wind, water.gravity)?),
        };
        let peak_k = shape.peak_k(dispersion);
        let peak = dispersion.omega(peak_k);
        let inverse_age = wind.speed_mps * peak / water.gravity;
        let mut system = Self {
            shape,
            depth: wind.depth_correction,
            scale: 1.0,
            spreader: Spreader::new(wind.spreading, inverse_age, wind.swell),
            toward: toward(wind.direction_from_deg),
            peak_k,
            peak,
            m0: 0.0,
        };
        system.m0 = system.integrate(dispersion);
        if let Some(hs) = wind.hs_m {
            // A sea too flat to be measured can't be scaled up.
            system.scale = hs * hs / 16.0 / system.m0.max(f64::MIN_POSITIVE);
            system.m0 *= system.scale;
        }
        (system.m0 > 0.0 && system.scale.is_finite()).then_some(system)
    }

    /// A swell; `None` where it is flat.
    pub fn of_swell(swell: &Swell, dispersion: &Dispersion) -> Option<Self> {
        let shape = match swell.model {
            SwellModel::Jonswap => Shape::Jonswap(Jonswap::of_swell(swell)?),
            SwellModel::OchiHubble => Shape::OchiHubble(OchiHubble::of_swell(swell)?),
        };
        let peak_k = shape.peak_k(dispersion);
        Some(Self {
            shape,
            depth: DepthCorrection::None,
            scale: 1.0,
            spreader: Spreader::new(swell.spreading, DEVELOPED_INVERSE_AGE, swell.swell),
            toward: toward(swell.direction_from_deg),
            peak_k,
            peak: dispersion.omega(peak_k),
            m0: swell.hs_m * swell.hs_m / 16.0,
        })
    }

    /// Zeroth moment, m^2.
    pub fn m0(&self) -> f64 {
        self.m0
    }

    /// Wavenumber of the peak, rad/m.
    pub fn peak_k(&self) -> f64 {
        self.peak_k
    }

    /// Range of wavenumbers, rad/m, that holds all but 1e-4 of the energy.
    pub fn range(&self, dispersion: &Dispersion) -> (f64, f64) {
        self.shape.range(self.peak_k, dispersion)
    }

    /// F(k), m^3, with its depth correction; `omega` and `group_velocity` are those of `k`.
    pub fn over_wavenumber(&self, dispersion: &Dispersion, k: f64, omega: f64, group_velocity: f64) -> f64 {
        let density = match &self.shape {
            Shape::Jonswap(shape) => shape.density(omega) * group_velocity,
            Shape::OchiHubble(shape) => shape.density(omega) * group_velocity,
            Shape::Elfouhaily(shape) => shape.density(k),
            Shape::Phillips(shape) => shape.density(k),
        };
        if density == 0.0 {
            return 0.0;
        }
        let depth = match self.depth {
            DepthCorrection::None => 1.0,
            DepthCorrection::Kitaigorodskii => kitaigorodskii(dispersion.kd(k)),
            DepthCorrection::ThompsonVincent => {
                thompson_vincent(omega * libm::sqrt(dispersion.depth_m() / dispersion.water().gravity))
            }
        };
        self.scale * density * depth
    }

    /// D(theta), 1/rad, for waves of `omega` that travel along a unit vector (x, z).
    pub fn spreading(&self, omega: f64, unit: (f64, f64)) -> f64 {
        let cos_theta = unit.0 * self.toward.0 + unit.1 * self.toward.1;
        self.spreader.density(omega / self.peak, cos_theta)
    }

    fn integrate(&self, dispersion: &Dispersion) -> f64 {
        let (low, high) = self.range(dispersion);
        dispersion.integrate(low, high, |k, omega, cg| self.over_wavenumber(dispersion, k, omega, cg))
    }
}
