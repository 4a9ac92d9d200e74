//! Energy of every mode of every cascade for one sea state.

use rayon::prelude::*;

use super::cell::Cell;
use super::layout::{Cascade, Layout};
use super::spectrum::Spectrum;
use super::strain::Strain;
use crate::scene::SeaState;

/// Cells this near to the origin are wide in angle and in frequency: they begin in more pieces.
const SPLITS: [(i32, u32); 3] = [(3, 6), (8, 3), (20, 2)];

/// Cells of a cascade on a usual grid.
const USUAL_CELLS: f64 = 87.0 * 87.0;

/// What one sea state gives every mode. Rows of m = -half..=half, each of n = -half..=half.
#[derive(Clone, Debug)]
pub struct EnergyTable {
    /// E of each cell, m^2, per cascade.
    pub energy: Vec<Vec<f64>>,
    /// Horizontal strain of each cascade.
    pub strain: Vec<Strain>,
    /// m0 of the spectrum that was wanted, m^2.
    pub wanted_m0: f64,
}

impl EnergyTable {
    /// Integrates a sea state's spectrum over every cell of a layout.
    pub fn build(state: &SeaState, layout: &Layout) -> Self {
        let spectrum = Spectrum::new(state);
        let energy: Vec<_> = layout.cascades.iter().map(|cascade| cascade_energy(&spectrum, cascade)).collect();
        let strain = |(c, e): (&Cascade, &Vec<f64>)| Strain::of_cascade(spectrum.dispersion(), c, e);
        let strain = layout.cascades.iter().zip(&energy).map(strain).collect();
        Self { energy, strain, wanted_m0: spectrum.m0() }
    }

    /// m0 that the modes hold, m^2.
    pub fn resolved_m0(&self) -> f64 {
        self.energy.iter().flatten().sum()
    }
}

fn cascade_energy(spectrum: &Spectrum, cascade: &Cascade) -> Vec<f64> {
    let half = cascade.half as i32;
    let side = 2 * cascade.half + 1;
    let dk = cascade.dk();
    let density = |kx: f64, kz: f64| {
        let weight = cascade.weight(libm::sqrt(kx * kx + kz * kz));
        if weight > 0.0 { weight * spectrum.density(kx, kz) } else { 0.0 }
    };
    // Together, cells of a difference this small are below 1e-4 of the energy on a usual grid; the same on every grid,
    // so that a mode has the same energy on each.
    let negligible = 1e-4 * spectrum.m0() / USUAL_CELLS;
    let mut energy = vec![0.0; side * side];
    energy.par_chunks_mut(side).enumerate().for_each(|(row_index, row)| {
        let m = row_index as i32 - half;
        for (value, n) in row.iter_mut().zip(-half..=half) {
            if (n, m) != (0, 0) {
                let near = n.abs().max(m.abs());
                let split = SPLITS.iter().find(|(within, _)| near <= *within).map_or(1, |(_, split)| *split);
                let cell = Cell { kx: f64::from(n) * dk, kz: f64::from(m) * dk, half: 0.5 * dk };
                *value = cell.integral(&density, split, negligible);
            }
        }
    });
    energy
}
