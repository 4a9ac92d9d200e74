//! All wave systems of a sea as one energy density over wave vectors, and its total.

use std::f64::consts::PI;

use super::dispersion::Dispersion;
use super::energy::{Jonswap, tma};
use super::measured::MeasuredSea;
use super::spreading::{cos2s, hasselmann_s, horvath_swell_s};
use crate::scene::{SeaState, WindSea};

/// The wanted directional spectrum of a sea.
#[derive(Clone, Debug)]
pub struct Spectrum {
    dispersion: Dispersion,
    gravity: f64,
    wind: Option<(WindSea, Jonswap)>,
    /// Unit vector in which the wind sea travels.
    wind_toward: (f64, f64),
    /// Spectrum, exponent s, unit vector of travel.
    swells: Vec<(Jonswap, f64, (f64, f64))>,
    measured: Option<MeasuredSea>,
    m0: f64,
}

/// Unit vector (x, z) in which waves from `from_deg` (clockwise from north) travel; +X east, +Z south.
fn toward(from_deg: f64) -> (f64, f64) {
    let from = from_deg.to_radians();
    (-libm::sin(from), libm::cos(from))
}

impl Spectrum {
    /// The spectrum of a sea state.
    pub fn new(state: &SeaState) -> Self {
        let dispersion = Dispersion::new(state.water);
        let gravity = state.water.gravity;
        let wind = state.wind.and_then(|wind| Some((wind, Jonswap::of_wind(&wind, gravity)?)));
        let swell = |s: &crate::scene::Swell| Some((Jonswap::of_swell(s)?, s.spread_s, toward(s.direction_from_deg)));
        let swells: Vec<_> = state.swells.iter().filter_map(swell).collect();
        let mut m0: f64 = swells.iter().map(|(jonswap, ..)| jonswap.m0()).sum();
        m0 += state.measured.as_ref().map_or(0.0, crate::scene::MeasuredSpectrum::m0);
        if let Some((_, jonswap)) = &wind {
            m0 += shoaled_m0(jonswap, &dispersion);
        }
        let wind_toward = toward(wind.map_or(0.0, |(wind, _)| wind.direction_from_deg));
        Self {
            dispersion,
            gravity,
            wind,
            wind_toward,
            swells,
            measured: state.measured.as_ref().map(MeasuredSea::new),
            m0,
        }
    }

    /// Zeroth moment of everything wanted, m^2; Hs = 4 sqrt(m0).
    pub fn m0(&self) -> f64 {
        self.m0
    }

    /// The dispersion the waves obey.
    pub fn dispersion(&self) -> &Dispersion {
        &self.dispersion
    }

    /// Energy density over wave vectors, m^2 per (rad/m)^2: sum of S(w) D(w, theta) (dw/dk) / k over all systems.
    pub fn density(&self, kx: f64, kz: f64) -> f64 {
        let k = libm::sqrt(kx * kx + kz * kz);
        if k == 0.0 {
            return 0.0;
        }
        let omega = self.dispersion.omega(k);
        let unit = (kx / k, kz / k);
        let cos_to = |toward: (f64, f64)| unit.0 * toward.0 + unit.1 * toward.1;
        let mut sum = 0.0;
        if let Some((wind, jonswap)) = &self.wind {
            let energy = jonswap.density(omega);
            if energy > 0.0 {
                let x = omega / jonswap.peak();
                let inverse_age = wind.speed_mps * jonswap.peak() / self.gravity;
                let s = hasselmann_s(x, inverse_age) + horvath_swell_s(x, wind.swell);
                let depth = tma(self.dispersion.kd(k));
                sum += energy * depth * cos2s(s, cos_to(self.wind_toward));
            }
        }
        for (jonswap, s, toward) in &self.swells {
            let energy = jonswap.density(omega);
            if energy > 0.0 {
                sum += energy * cos2s(*s, cos_to(*toward));
            }
        }
        if let Some(measured) = &self.measured {
            sum += measured.density(omega, unit);
        }
        sum * self.dispersion.group_velocity(k) / k
    }

    /// Longest wavelength that matters, metres: the longest peak of any system; `None` for a flat sea.
    pub fn longest_peak_m(&self) -> Option<f64> {
        self.lowest_peak().map(|peak| 2.0 * PI / self.dispersion.wavenumber(peak))
    }

    /// Longest peak period of any system but a measured one, seconds.
    pub fn longest_period_s(&self) -> Option<f64> {
        self.lowest_peak().map(|peak| 2.0 * PI / peak)
    }

    /// Frequencies of a measured record whose directions were changed, and those that have none.
    pub fn measured_faults(&self) -> (usize, usize) {
        self.measured.as_ref().map_or((0, 0), |measured| (measured.infeasible(), measured.missing()))
    }

    fn lowest_peak(&self) -> Option<f64> {
        let wind = self.wind.iter().map(|(_, jonswap)| jonswap.peak());
        let swells = self.swells.iter().map(|(jonswap, ..)| jonswap.peak());
        let lowest = wind.chain(swells).fold(f64::INFINITY, f64::min);
        lowest.is_finite().then_some(lowest)
    }

    /// Highest wavenumber that holds energy, rad/m, where there is one (a measured record ends; the others don't).
    pub fn highest_wavenumber(&self) -> Option<f64> {
        let ends = self.wind.is_none() && self.swells.is_empty();
        self.measured.as_ref().filter(|_| ends).map(|measured| self.dispersion.wavenumber(measured.range().1))
    }
}

/// m0 of a wind sea with its depth correction, m^2.
fn shoaled_m0(jonswap: &Jonswap, dispersion: &Dispersion) -> f64 {
    // Midpoint rule in ln k, over the frequencies of `Jonswap::m0`; in k the depth correction needs no inverse.
    const STEPS: i32 = 4000;
    let low = libm::log(dispersion.wavenumber(0.2 * jonswap.peak()));
    let width = (libm::log(dispersion.wavenumber(150.0 * jonswap.peak())) - low) / f64::from(STEPS);
    let at = |i: i32| {
        let k = libm::exp(low + (f64::from(i) + 0.5) * width);
        jonswap.density(dispersion.omega(k)) * tma(dispersion.kd(k)) * dispersion.group_velocity(k) * k
    };
    (0..STEPS).map(at).sum::<f64>() * width
}
