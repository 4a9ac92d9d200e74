//! The waves of a sea by length: what a layout holds of them, and what is lost where its grids are read. Expectations over
//! all seas of the spectrum, without a draw.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::engine::lost_between;
use crate::scene::SeaState;
use crate::sea::{Cascade, Layout, Spectrum};

/// Entries of the table of what is lost, from waves of any length up to those of two samples.
const ENTRIES: usize = 128;
/// Directions that it is the mean of, within a quarter of a turn.
const DIRECTIONS: usize = 8;

/// Waves by wavenumber.
pub struct Waves {
    /// Wavenumber, rad/m, and energy, m^2.
    waves: Vec<(f64, f64)>,
    /// What is lost between samples, as a share, by the phase from one to the next in steps of pi / [`ENTRIES`].
    lost: Vec<f64>,
}

/// What is missing of waves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Missing {
    /// Energy, m^2.
    pub m0: f64,
    /// Mean square of the slope.
    pub slope: f64,
}

impl Waves {
    /// Those of a sea state.
    pub fn new(state: &SeaState) -> Self {
        let lost = |entry: usize| {
            let phase = PI * (entry as f64 + 0.5) / ENTRIES as f64;
            let along = |direction: usize| {
                let angle = FRAC_PI_2 * (direction as f64 + 0.5) / DIRECTIONS as f64;
                lost_between([phase * libm::cos(angle), phase * libm::sin(angle)])
            };
            (0..DIRECTIONS).map(along).sum::<f64>() / DIRECTIONS as f64
        };
        Self { waves: Spectrum::new(state).by_wavenumber(), lost: (0..ENTRIES).map(lost).collect() }
    }

    /// Energy of all, m^2.
    pub fn m0(&self) -> f64 {
        self.waves.iter().map(|(_, energy)| energy).sum()
    }

    /// What no cascade of a layout holds: energy of any length, slopes down to a wavelength, metres.
    pub fn left_out(&self, layout: &Layout, finest_m: f64) -> Missing {
        let mut missing = Missing::default();
        for (k, energy) in &self.waves {
            let rest = energy * (1.0 - layout.cascades.iter().map(|cascade| held(cascade, *k)).sum::<f64>());
            missing.m0 += rest;
            missing.slope += if *k <= 2.0 * PI / finest_m { k * k * rest } else { 0.0 };
        }
        missing
    }

    /// Energy that is left out, or lost where a layout is read between its samples, m^2.
    pub fn lost(&self, layout: &Layout) -> f64 {
        let read = |cascade: &Cascade, k: f64| {
            let phase = k * cascade.patch_m / cascade.n as f64;
            let entry = (phase / PI * ENTRIES as f64) as usize;
            held(cascade, k) * (1.0 - self.lost[entry.min(ENTRIES - 1)])
        };
        let of = |(k, energy): &(f64, f64)| {
            energy * (1.0 - layout.cascades.iter().map(|cascade| read(cascade, *k)).sum::<f64>())
        };
        self.waves.iter().map(of).sum()
    }
}

/// Share of a wave's energy that a cascade holds. The first holds none that is longer than its patch: those would be in
/// the cell of the mode that is no wave.
fn held(cascade: &Cascade, k: f64) -> f64 {
    let least = if cascade.from_k == 0.0 { cascade.dk() / PI.sqrt() } else { 0.0 };
    if k < least { 0.0 } else { cascade.weight(k) }
}
