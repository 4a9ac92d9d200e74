//! Noise in place of the waves that were not kept: octaves fixed by the layout, amplitudes fitted to the sea.

use std::f64::consts::PI;

use super::modes::{CascadeModes, Sea};
use super::octave::{OCTAVE_CENTRE, Octave, kernel_energies};
use super::trochoid::{TrochoidWave, travelling, trochoid_settings};
use crate::wire::TICKS_PER_SECOND;

/// Cells of the finest octave, as a multiple of the highest mode: its energy ends where the band does.
const FINEST: f64 = 1.25;
/// Ratio of neighbouring octaves: half a real one, for an octave is narrower than that.
const RATIO: f64 = std::f64::consts::SQRT_2;
/// Fewest cells a side.
const FEWEST: f64 = 2.0;
/// Ratio of neighbouring rings of the spectrum.
const RING: f64 = 1.19;
/// Energy below the peak counts as much as this share of the peak's: noise must not fill what is empty.
const BELOW_PEAK: f64 = 0.2;
/// The sum of all rings counts so many times as much as one of them: the height of the sea is to be right.
const TOTAL: f64 = 4.0;
/// Energy of a ring below which there is none, m^2.
const LEAST: f64 = 1e-60;
/// Rounds of the fit.
const ROUNDS: usize = 400;
/// Wave periods in which a lattice point's vector becomes another.
const PERIODS: f64 = 2.0;

/// Octaves that fill up what `kept` leaves of a cascade's energy, ring by ring of wavenumber; finest first, those
/// without energy left out. None where the scene wants no turbulence.
pub fn turbulence(modes: &CascadeModes, sea: &Sea, kept: &[TrochoidWave]) -> Vec<Octave> {
    if !trochoid_settings(sea).turbulence {
        return Vec::new();
    }
    let half = modes.cascade.half;
    let cells: Vec<u32> = (0..)
        .map(|i| libm::round(FINEST * half as f64 / libm::pow(RATIO, f64::from(i))))
        .take_while(|cells| *cells >= FEWEST)
        .map(|cells| cells as u32)
        .collect();
    let rings = Rings::new(half);
    let (mut wanted, mut left) = (rings.zeros(), rings.zeros());
    for (_, n, m, _, energy) in travelling(modes) {
        rings.add(&mut wanted, n, m, energy);
    }
    left.clone_from(&wanted);
    for wave in kept {
        rings.add(&mut left, wave.n, wave.m, -0.5 * wave.amplitude * wave.amplitude);
    }
    let shapes: Vec<Vec<f64>> = cells.iter().map(|cells| rings.shape(half, *cells)).collect();
    let energies = fit(&shapes, &left, &wanted);
    let octave = |(number, (cells, energy)): (usize, (&u32, f64))| {
        (energy > 0.0).then(|| octave(modes, sea, number as u32, *cells, libm::sqrt(energy)))
    };
    cells.iter().zip(energies).enumerate().filter_map(octave).collect()
}

fn octave(modes: &CascadeModes, sea: &Sea, number: u32, cells: u32, amplitude: f64) -> Octave {
    let patch_m = modes.cascade.patch_m;
    let k = 2.0 * PI * OCTAVE_CENTRE * f64::from(cells) / patch_m;
    let omega = sea.drift.dispersion.omega(k);
    let repeat_s = sea.repeat as f64 / TICKS_PER_SECOND as f64;
    let whole = |x: f64| libm::round(x).clamp(-2e9, 2e9);
    let patches = omega / k * repeat_s / patch_m;
    let drift = sea.drift.toward.map(|toward| whole(patches * toward) as i32);
    let changes = whole(repeat_s * omega / (2.0 * PI * PERIODS)).max(1.0) as u32;
    // Modes along x: the first of them is no wave.
    let n = (libm::round(k / modes.cascade.dk()) as usize).clamp(1, modes.cascade.half.max(1));
    let widening = modes.modes.get(n * modes.rows() + modes.cascade.half).map_or(1.0, |mode| mode.widening);
    Octave { number, cells, amplitude, drift, changes, k, omega, chop: sea.choppiness * widening }
}

/// Rings of modes by |(n, m)|, from 1 to the end of the band, in steps of about a quarter of an octave.
struct Rings {
    /// Ring of every |(n, m)|^2.
    of: Vec<u16>,
    count: usize,
}

impl Rings {
    fn new(half: usize) -> Self {
        let end = half as f64 + 0.5;
        let mut edges = vec![0.5];
        while let Some(edge) = edges.last().filter(|edge| **edge < end) {
            edges.push((edge * RING).max(edge + 1.0));
        }
        let ring = |square: usize| {
            let radius = libm::sqrt(square as f64);
            edges.partition_point(|edge| *edge <= radius).max(1) as u16 - 1
        };
        let squares = (end * end) as usize + 1;
        Self { of: (0..squares).map(ring).collect(), count: edges.len() - 1 }
    }

    fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.count]
    }

    fn add(&self, rings: &mut [f64], n: i32, m: i32, energy: f64) {
        if let Some(ring) = self.of.get((n * n + m * m) as usize) {
            rings[usize::from(*ring)] += energy;
        }
    }

    /// Energy of an octave of unit amplitude in each ring.
    fn shape(&self, half: usize, cells: u32) -> Vec<f64> {
        let side = f64::from(cells);
        let along: Vec<_> = (0..=half).map(|n| kernel_energies(2.0 * PI * n as f64 / side)).collect();
        let mut shape = self.zeros();
        for (n, (an, bn)) in along.iter().enumerate() {
            for (m, (am, bm)) in along.iter().enumerate() {
                // Modes with either sign.
                let signs = f64::from(1 + u8::from(n > 0)) * f64::from(1 + u8::from(m > 0));
                self.add(&mut shape, n as i32, m as i32, signs * 0.5 * (an * bm + bn * am) / (side * side));
            }
        }
        shape
    }
}

/// Energies x >= 0 for which the sum of x times the shapes is nearest to what is left, in shares of what is wanted.
///
/// By coordinates in turn, which ends at the one best x: it depends continuously on the sea.
fn fit(shapes: &[Vec<f64>], left: &[f64], wanted: &[f64]) -> Vec<f64> {
    let mut scale = wanted.to_vec();
    let mut highest = 0.0_f64;
    for scale in scale.iter_mut().rev() {
        highest = highest.max(*scale);
        *scale = scale.max(BELOW_PEAK * highest);
    }
    let total: f64 = wanted.iter().sum();
    let over = |value: f64, scale: f64| if scale > LEAST { value / scale } else { 0.0 };
    let share = |values: &[f64]| -> Vec<f64> {
        let rings = values.iter().zip(&scale).map(|(value, scale)| over(*value, *scale));
        rings.chain([TOTAL * over(values.iter().sum(), total)]).collect()
    };
    let target = share(left);
    let columns: Vec<Vec<f64>> = shapes.iter().map(|shape| share(shape)).collect();
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let goal: Vec<f64> = columns.iter().map(|column| dot(column, &target)).collect();
    let gram: Vec<Vec<f64>> = columns.iter().map(|a| columns.iter().map(|b| dot(a, b)).collect()).collect();
    let mut x = vec![0.0; shapes.len()];
    for _ in 0..ROUNDS {
        for i in 0..x.len() {
            if gram[i][i] > 0.0 {
                let others = dot(&gram[i], &x) - gram[i][i] * x[i];
                x[i] = ((goal[i] - others) / gram[i][i]).max(0.0);
            }
        }
    }
    x
}
