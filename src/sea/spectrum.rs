//! All wave systems of a sea as one energy density over wave vectors, and its total.

use std::f64::consts::PI;

use super::dispersion::Dispersion;
use super::measured::MeasuredSea;
use super::system::System;
use crate::scene::SeaState;

/// The wanted directional spectrum of a sea.
#[derive(Clone, Debug)]
pub struct Spectrum {
    dispersion: Dispersion,
    systems: Vec<System>,
    measured: Option<MeasuredSea>,
    /// Wavenumber of the highest density of the measured record, rad/m.
    measured_peak_k: Option<f64>,
    m0: f64,
}

impl Spectrum {
    /// The spectrum of a sea state.
    pub fn new(state: &SeaState) -> Self {
        let dispersion = Dispersion::new(state.water);
        let wind = state.wind.iter().filter_map(|wind| System::of_wind(wind, &dispersion));
        let systems: Vec<_> =
            wind.chain(state.swells.iter().filter_map(|swell| System::of_swell(swell, &dispersion))).collect();
        let measured = state.measured.as_ref().filter(|record| record.m0() > 0.0);
        let m0 = systems.iter().map(System::m0).sum::<f64>() + measured.map_or(0.0, |record| record.m0());
        Self {
            dispersion,
            systems,
            measured: measured.map(MeasuredSea::new),
            measured_peak_k: measured.map(|record| dispersion.wavenumber(2.0 * PI * record.peak_hz())),
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

    /// The measured record, where there is one.
    pub fn measured(&self) -> Option<&MeasuredSea> {
        self.measured.as_ref()
    }

    /// Energy density over wave vectors, m^2 per (rad/m)^2: sum of F(k) D(w, theta) / k over all systems.
    pub fn density(&self, kx: f64, kz: f64) -> f64 {
        let k = libm::sqrt(kx * kx + kz * kz);
        if k == 0.0 {
            return 0.0;
        }
        let (omega, group_velocity) = (self.dispersion.omega(k), self.dispersion.group_velocity(k));
        let unit = (kx / k, kz / k);
        let mut sum = 0.0;
        for system in &self.systems {
            let energy = system.over_wavenumber(&self.dispersion, k, omega, group_velocity);
            if energy > 0.0 {
                sum += energy * system.spreading(omega, unit);
            }
        }
        if let Some(measured) = &self.measured {
            sum += measured.density(omega, unit) * group_velocity;
        }
        sum / k
    }

    /// F(k), m^3, of all systems, over all directions; `omega` and `group_velocity` are those of `k`.
    fn over_wavenumber(&self, k: f64, omega: f64, group_velocity: f64) -> f64 {
        let system = |system: &System| system.over_wavenumber(&self.dispersion, k, omega, group_velocity);
        let measured = self.measured.as_ref().map_or(0.0, |m| m.over_frequency(omega) * group_velocity);
        self.systems.iter().map(system).sum::<f64>() + measured
    }

    /// Longest wavelength that matters, metres: the longest peak of any system; `None` for a flat sea.
    pub fn longest_peak_m(&self) -> Option<f64> {
        self.lowest_peak().map(|k| 2.0 * PI / k)
    }

    /// Longest peak period of any system, seconds.
    pub fn longest_period_s(&self) -> Option<f64> {
        self.lowest_peak().map(|k| 2.0 * PI / self.dispersion.omega(k))
    }

    /// Wavenumber, rad/m, above which lies this share of the energy; `None` for a flat sea.
    pub fn wavenumber_below_share(&self, share: f64) -> Option<f64> {
        let (low, high) = self.range()?;
        let mut above = 0.0;
        let mut found = high;
        let wanted = share * self.m0;
        // From the short waves on.
        self.dispersion.each_wavenumber(low, high, |k, omega, cg, width| {
            if above < wanted {
                above += self.over_wavenumber(k, omega, cg) * width;
                found = k;
            }
        });
        Some(found)
    }

    /// Share of the energy in waves shorter than this, metres.
    pub fn share_shorter_than(&self, wavelength_m: f64) -> f64 {
        let Some((low, high)) = self.range() else { return 0.0 };
        let from = (2.0 * PI / wavelength_m).clamp(low, high);
        self.dispersion.integrate(from, high, |k, omega, cg| self.over_wavenumber(k, omega, cg)) / self.m0
    }

    /// Wavenumbers, rad/m, and the energy of waves about that long, m^2: the shortest first, 2000 of them.
    pub fn by_wavenumber(&self) -> Vec<(f64, f64)> {
        let Some((low, high)) = self.range() else { return Vec::new() };
        let mut waves = Vec::new();
        self.dispersion.each_wavenumber(low, high, |k, omega, cg, width| {
            waves.push((k, self.over_wavenumber(k, omega, cg) * width));
        });
        waves
    }

    /// Range of wavenumbers that holds energy, rad/m; `None` for a flat sea.
    pub fn range(&self) -> Option<(f64, f64)> {
        let systems = self.systems.iter().map(System::range);
        let measured = self.measured.iter().map(|measured| {
            let (low, high) = measured.range();
            (self.dispersion.wavenumber(low), self.dispersion.wavenumber(high))
        });
        systems.chain(measured).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Highest wavenumber that holds energy, rad/m, where there is one (a measured record ends; the others don't).
    pub fn highest_wavenumber(&self) -> Option<f64> {
        let measured = self.measured.as_ref().filter(|_| self.systems.is_empty());
        measured.map(|measured| self.dispersion.wavenumber(measured.range().1))
    }

    fn lowest_peak(&self) -> Option<f64> {
        let systems = self.systems.iter().map(System::peak_k);
        let lowest = systems.chain(self.measured_peak_k).fold(f64::INFINITY, f64::min);
        lowest.is_finite().then_some(lowest)
    }
}
