//! The sea of one tick as a backend wants it: per mode two amplitudes, an integer frequency and a phase offset.

use std::f64::consts::PI;

use rustfft::num_complex::Complex64;

use super::drift::Drift;
use super::layout::Cascade;
use crate::scene::Model;
use crate::wire::TICKS_PER_SECOND;

/// One wave vector (n, m) and its opposite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// h0(k), metres: the part that travels along +k.
    pub forward: Complex64,
    /// conj(h0(-k)), metres: the part that travels along -k.
    pub backward: Complex64,
    /// Whole cycles per repeat period.
    pub cycles: u32,
    /// Phase offset, in 2^-32 of a turn; what keeps the phase continuous where `cycles` changed.
    pub offset: u32,
    /// Ratio of horizontal to vertical orbit: coth(k d), at most 3.
    pub widening: f64,
}

impl Mode {
    /// Angular frequency, rad/s, of a sea that repeats after so many ticks.
    pub fn omega(&self, repeat: u64) -> f64 {
        2.0 * PI * TICKS_PER_SECOND as f64 * f64::from(self.cycles) / repeat as f64
    }
}

/// Modes of one cascade with n from 0 to half; those with n < 0 are their complex conjugates.
#[derive(Clone, Debug, PartialEq)]
pub struct CascadeModes {
    /// Patch, grid and band.
    pub cascade: Cascade,
    /// Jacobian of this cascade below which it foams.
    pub foam_threshold: f64,
    /// Column after column of n = 0..=half, each of m = -half..=half.
    pub modes: Vec<Mode>,
}

/// Everything that decides the water until the next change.
#[derive(Clone, Debug, PartialEq)]
pub struct Sea {
    /// Longest patch first.
    pub cascades: Vec<CascadeModes>,
    /// Ticks after which the phases are the same again.
    pub repeat: u64,
    /// Horizontal displacement, as a multiple of first-order Lagrangian.
    pub choppiness: f64,
    /// What the modes are summed by.
    pub model: Model,
    /// Decides what is random beside the modes.
    pub seed: u64,
    /// How noise in place of waves drifts.
    pub drift: Drift,
}

impl CascadeModes {
    /// Whether any of its water can break: no Jacobian of a sea is as low as the threshold of one that never foams.
    pub fn breaks(&self) -> bool {
        const LOWEST: f64 = -1e4;
        self.foam_threshold > LOWEST
    }

    /// Rows in a column: 2 half + 1.
    pub fn rows(&self) -> usize {
        2 * self.cascade.half + 1
    }

    /// Every mode with its wave vector (kx, kz) in rad/m, in the order of `modes`.
    pub fn with_wave_vectors(&self) -> impl Iterator<Item = (f64, f64, &Mode)> {
        let (rows, half, dk) = (self.rows(), self.cascade.half as f64, self.cascade.dk());
        self.modes.iter().enumerate().map(move |(i, mode)| {
            let (n, m) = (i / rows, i % rows);
            (n as f64 * dk, (m as f64 - half) * dk, mode)
        })
    }
}
