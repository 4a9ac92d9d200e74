//! One wave system of a sea: its spectrum over wavenumbers, its spreading, its direction.

use super::dispersion::Dispersion;
use super::energy::{Jonswap, OchiHubble};
use super::shoaling::{kitaigorodskii, thompson_vincent};
use super::spreading::Spreader;
use super::wavenumber::{Elfouhaily, Phillips};
use crate::scene::{DepthCorrection, Swell, SwellModel, Water, WindModel, WindSea};

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
    /// Wavenumbers of the lower end, the peak and the upper end, rad/m.
    wavenumbers: [f64; 3],
    /// Angular frequency of the peak, rad/s.
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
    /// Wavenumbers, rad/m: the least and the most that hold all but 1e-4 of the energy, and the peak between. Those of
    /// a spectrum over wavenumbers are over deep water.
    fn wavenumbers(&self, dispersion: &Dispersion) -> [f64; 3] {
        let by_frequency = |peak: f64| [0.1, 1.0, 150.0].map(|ratio| dispersion.wavenumber(ratio * peak));
        match self {
            Self::Jonswap(shape) => by_frequency(shape.peak()),
            Self::OchiHubble(shape) => by_frequency(shape.peak()),
            // Its short waves have a hump of their own.
            Self::Elfouhaily(shape) => [0.01 * shape.peak_k(), shape.peak_k(), (2e4 * shape.peak_k()).max(5e3)],
            Self::Phillips(shape) => [0.01 * shape.peak_k(), shape.peak_k(), 2e4 * shape.peak_k()],
        }
    }

    /// F(k) over deep water, m^3, of a spectrum over wavenumbers; `None` for one over frequencies.
    fn over_wavenumber(&self, k: f64) -> Option<f64> {
        match self {
            Self::Elfouhaily(shape) => Some(shape.density(k)),
            Self::Phillips(shape) => Some(shape.density(k)),
            Self::Jonswap(_) | Self::OchiHubble(_) => None,
        }
    }

    /// S(w) over deep water, m^2 s. A spectrum over wavenumbers is taken along at the same frequency.
    fn over_frequency(&self, dispersion: &Dispersion, omega: f64) -> f64 {
        match self {
            Self::Jonswap(shape) => shape.density(omega),
            Self::OchiHubble(shape) => shape.density(omega),
            Self::Elfouhaily(_) | Self::Phillips(_) => {
                let (k, group_velocity) = dispersion.over_deep(omega);
                self.over_wavenumber(k).map_or(0.0, |density| density / group_velocity)
            }
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
        let mut wavenumbers = shape.wavenumbers(dispersion);
        if shape.over_wavenumber(1.0).is_some() && wind.depth_correction != DepthCorrection::None {
            // The depth factor is one of frequencies: the same waves, shortened by the bottom.
            let deep = Dispersion::new(Water { depth_m: f64::INFINITY, ..*water });
            wavenumbers = wavenumbers.map(|k| dispersion.wavenumber(deep.omega(k)));
        }
        let peak = dispersion.omega(wavenumbers[1]);
        let inverse_age = wind.speed_mps * peak / water.gravity;
        let mut system = Self {
            shape,
            depth: wind.depth_correction,
            scale: 1.0,
            spreader: Spreader::new(wind.spreading, inverse_age, wind.swell),
            toward: toward(wind.direction_from_deg),
            wavenumbers,
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
        let wavenumbers = shape.wavenumbers(dispersion);
        Some(Self {
            shape,
            depth: DepthCorrection::None,
            scale: 1.0,
            spreader: Spreader::new(swell.spreading, DEVELOPED_INVERSE_AGE, swell.swell),
            toward: toward(swell.direction_from_deg),
            wavenumbers,
            peak: dispersion.omega(wavenumbers[1]),
            m0: swell.hs_m * swell.hs_m / 16.0,
        })
    }

    /// Zeroth moment, m^2.
    pub fn m0(&self) -> f64 {
        self.m0
    }

    /// Wavenumber of the peak, rad/m.
    pub fn peak_k(&self) -> f64 {
        self.wavenumbers[1]
    }

    /// Range of wavenumbers, rad/m, that holds all but 1e-4 of the energy.
    pub fn range(&self) -> (f64, f64) {
        (self.wavenumbers[0], self.wavenumbers[2])
    }

    /// F(k), m^3, with its depth correction; `omega` and `group_velocity` are those of `k`.
    pub fn over_wavenumber(&self, dispersion: &Dispersion, k: f64, omega: f64, group_velocity: f64) -> f64 {
        // The depth factor is one of S(w): over k it is also the group velocity that changes (Bouws et al. 1985).
        let over_frequency = || self.shape.over_frequency(dispersion, omega) * group_velocity;
        let density = match self.depth {
            DepthCorrection::None => self.shape.over_wavenumber(k).unwrap_or_else(over_frequency),
            DepthCorrection::Kitaigorodskii => over_frequency() * kitaigorodskii(dispersion.kd(k)),
            DepthCorrection::ThompsonVincent => {
                let depth = dispersion.depth_m() / dispersion.water().gravity;
                over_frequency() * thompson_vincent(omega * libm::sqrt(depth))
            }
        };
        self.scale * density
    }

    /// D(theta), 1/rad, for waves of `omega` that travel along a unit vector (x, z).
    pub fn spreading(&self, omega: f64, unit: (f64, f64)) -> f64 {
        let cos_theta = unit.0 * self.toward.0 + unit.1 * self.toward.1;
        self.spreader.density(omega / self.peak, cos_theta)
    }

    fn integrate(&self, dispersion: &Dispersion) -> f64 {
        let (low, high) = self.range();
        dispersion.integrate(low, high, |k, omega, cg| self.over_wavenumber(dispersion, k, omega, cg))
    }
}
