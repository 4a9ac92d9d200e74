//! Below which Jacobian a sea foams, so that whitecaps cover as much of it as the wind calls for.
//!
//! The whole recursion is run, not guessed at: on the Jacobian of one drifting particle, as long a time of it as counts
//! many breakers, synthesised from the covariance of the strain by frequency. What covers at a point of time covers in
//! the mean of the area. Everything is a fixed sum of portable arithmetic, so every server finds the same threshold.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex32;

use super::dispersion::Dispersion;
use super::foam_step::HeldFoam;
use super::layout::{Cascade, Layout};
use super::noise::mix;
use super::phase::cos_sin_q24;
use super::strain::{Root, Strain};
use super::table::EnergyTable;
use crate::scene::{Foam, SeaState};
use crate::wire::TICKS_PER_SECOND;

/// Thresholds stay where foam is neither everywhere nor missing from a folded crest.
const BOUNDS: (f64, f64) = (0.0, 0.95);
/// Waves shorter than this break without catching air (Jessup et al. 1997 call it microbreaking), metres.
const SHORTEST_WHITECAP_M: f64 = 2.5;
/// Threshold of a cascade that never foams: no Jacobian comes near it.
const NEVER: f64 = -1e6;

/// Foam steps of a particle's history: 14.6 hours, of which two independent ones come out of one transform.
const STEPS: usize = 1 << 19;
/// Steps at its beginning that fill foam's memory.
const FILLING: usize = 200;
/// Frequencies that its strain is told apart by.
const FREQUENCIES: usize = 64;
/// Thresholds, in deviations of the stretch below 1, at which coverage is counted.
const LADDER: [f64; 7] = [1.5, 1.8, 2.1, 2.4, 2.7, 3.0, 3.3];
/// The middle of them, about which the fit is written.
const MIDDLE: f64 = 2.4;
/// Thresholds at which the fit is trusted.
const TRUSTED: (f64, f64) = (1.2, 4.5);
/// Covered steps that a count needs to be of use, and beyond which it is no better.
const COUNTS: (f64, f64) = (200.0, 10_000.0);
/// Water this far below the threshold makes foam that covers.
const COVERING: f64 = Foam::COVERS * Foam::SOURCE_WIDTH;

/// Foam of a sea state.
#[derive(Clone, Debug, PartialEq)]
pub struct FoamThresholds {
    /// Jacobian of each cascade below which it foams.
    pub jacobian: Vec<f64>,
    /// Share of the area that foam covers, by all cascades together.
    pub coverage: f64,
}

impl FoamThresholds {
    /// Of a scene without foam.
    pub fn none(layout: &Layout) -> Self {
        Self { jacobian: vec![NEVER; layout.cascades.len()], coverage: 0.0 }
    }

    /// The same Jacobian for every cascade that foams at all, however much foam that makes: of no account for what a frame
    /// costs, and had at once.
    pub fn uncalibrated(layout: &Layout, jacobian: f64) -> Self {
        let of = |cascade: &Cascade| if foams(cascade) { jacobian } else { NEVER };
        Self { jacobian: layout.cascades.iter().map(of).collect(), coverage: 0.0 }
    }

    /// The thresholds of a sea state, for a wanted coverage of 3.84e-6 U10^3.41 (Monahan & O'Muircheartaigh 1980,
    /// eq. 5). All cascades with waves long enough share one. Without wind only folded water foams.
    pub fn new(state: &SeaState, layout: &Layout, table: &EnergyTable, choppiness: f64, foam: &Foam) -> Self {
        let dispersion = Dispersion::new(state.water);
        let breakers: Vec<Breakers> = (0..layout.cascades.len())
            .into_par_iter()
            .filter(|i| foams(&layout.cascades[*i]) && choppiness * table.strain[*i].stretch() > 1e-6)
            .map(|i| {
                Breakers::of(&dispersion, &layout.cascades[i], &table.energy[i], table.strain[i], choppiness, foam)
            })
            .collect();
        let covered = |threshold: f64| 1.0 - breakers.iter().map(|b| 1.0 - b.coverage(threshold)).product::<f64>();
        let wind = state.wind.map_or(0.0, |wind| wind.speed_mps);
        let wanted = (foam.gain * 3.84e-6 * libm::pow(wind, 3.41)).min(1.0);
        let (mut low, mut high) = BOUNDS;
        if covered(low) < wanted {
            for _ in 0..24 {
                let middle = 0.5 * (low + high);
                if covered(middle) < wanted { low = middle } else { high = middle }
            }
        }
        let jacobian = layout.cascades.iter().map(|cascade| if foams(cascade) { low } else { NEVER }).collect();
        Self { jacobian, coverage: covered(low) }
    }
}

/// Whether waves of a cascade are long enough to catch air.
fn foams(cascade: &Cascade) -> bool {
    cascade.longest_m() >= SHORTEST_WHITECAP_M
}

/// How often one cascade's water is covered, by threshold.
#[derive(Debug)]
struct Breakers {
    strain: Strain,
    choppiness: f64,
    /// Logarithm of covered over broken area, as a parabola of the deviations beyond the middle of the ladder; `None`
    /// where nothing covers. Foam outlives its breaker, and the rarer breakers are the shorter, so this varies little.
    persistence: Option<[f64; 3]>,
}

impl Breakers {
    fn of(
        dispersion: &Dispersion,
        cascade: &Cascade,
        energy: &[f64],
        strain: Strain,
        choppiness: f64,
        foam: &Foam,
    ) -> Self {
        let history = history(dispersion, cascade, energy, choppiness);
        let mut breakers = Self { strain, choppiness, persistence: None };
        let mut points = Vec::with_capacity(LADDER.len());
        for deviations in LADDER {
            let threshold = 1.0 - deviations * choppiness * strain.stretch();
            let counted = history.iter().map(|jacobian| count(jacobian, threshold, foam)).sum::<f64>();
            let broken = breakers.broken(threshold);
            if counted < COUNTS.0 || broken <= 0.0 {
                break;
            }
            let share = counted / (history.len() * (STEPS - FILLING)) as f64;
            points.push((deviations - MIDDLE, libm::log(share / broken), counted.min(COUNTS.1)));
        }
        breakers.persistence = parabola(&points);
        breakers
    }

    fn broken(&self, threshold: f64) -> f64 {
        self.strain.below(threshold - COVERING, self.choppiness)
    }

    fn coverage(&self, threshold: f64) -> f64 {
        let Some([a, b, c]) = self.persistence else { return 0.0 };
        let deviations = (1.0 - threshold) / (self.choppiness * self.strain.stretch());
        let at = deviations.clamp(TRUSTED.0, TRUSTED.1) - MIDDLE;
        (self.broken(threshold) * libm::exp(a + at * (b + at * c))).min(1.0)
    }
}

/// The parabola a + b x + c x^2 nearest to points (x, y, weight); a line or a level through fewer than three.
fn parabola(points: &[(f64, f64, f64)]) -> Option<[f64; 3]> {
    let terms = points.len().min(3);
    // Normal equations, solved by elimination: they are positive definite.
    let mut rows = [[0.0; 4]; 3];
    for (x, y, weight) in points {
        let powers = [1.0, *x, x * x];
        for (row, power) in rows.iter_mut().zip(powers) {
            for (cell, value) in row.iter_mut().zip([1.0, *x, x * x, *y]) {
                *cell += weight * power * value;
            }
        }
    }
    for i in 0..terms {
        let pivot = rows[i];
        for row in &mut rows[i + 1..terms] {
            let factor = row[i] / pivot[i];
            row.iter_mut().zip(pivot).for_each(|(cell, above)| *cell -= factor * above);
        }
    }
    let mut solved = [0.0; 3];
    for i in (0..terms).rev() {
        let known: f64 = (i + 1..terms).map(|j| rows[i][j] * solved[j]).sum();
        solved[i] = (rows[i][3] - known) / rows[i][i];
    }
    (terms > 0).then_some(solved)
}

/// Steps at which foam covers, after the filling.
fn count(jacobian: &[f32], threshold: f64, foam: &Foam) -> f64 {
    let (decay, growth) = (foam.decay_over(Foam::STEP_TICKS) as f32, foam.growth_over(Foam::STEP_TICKS) as f32);
    let (mut held, mut covered) = (HeldFoam::default(), 0_u32);
    for (step, j) in jacobian.iter().enumerate() {
        held = held.step(*j, threshold as f32, decay, growth);
        covered += u32::from(step >= FILLING && held.foam > Foam::COVERS as f32);
    }
    f64::from(covered)
}

/// The Jacobian of two particles, foam step by foam step.
fn history(dispersion: &Dispersion, cascade: &Cascade, energy: &[f64], choppiness: f64) -> [Vec<f32>; 2] {
    // Covariance by frequency, evenly from 0 to the highest of the cascade.
    let highest = dispersion.omega(cascade.to_k) * 1.01;
    let mut by_frequency = [Strain::default(); FREQUENCIES];
    for ((kx, kz), e) in cascade.wave_vectors().zip(energy) {
        let place = dispersion.omega(libm::hypot(kx, kz)) / highest * FREQUENCIES as f64;
        let at = &mut by_frequency[(place as usize).min(FREQUENCIES - 1)];
        *at = at.plus(&Strain::of_mode(dispersion, kx, kz, *e));
    }
    let step_s = Foam::STEP_TICKS as f64 / TICKS_PER_SECOND as f64;
    // Waves faster than the foam step sees are seen as slower ones, as on the grid.
    let lines = (highest * step_s * STEPS as f64 / (2.0 * PI)).ceil().max(FREQUENCIES as f64);
    let lines_each = lines / FREQUENCIES as f64;
    let roots = by_frequency.map(|strain| strain.times(choppiness * choppiness / lines_each).root());
    let [xx, xz, zz] = series(&roots, lines as usize);
    let jacobian = |part: fn(&Complex32) -> f32| {
        let at = |i: usize| {
            let (xx, xz, zz) = (part(&xx[i]), part(&xz[i]), part(&zz[i]));
            (1.0 + xx) * (1.0 + zz) - xz * xz
        };
        (0..STEPS).map(at).collect()
    };
    [jacobian(|z| z.re), jacobian(|z| z.im)]
}

/// Dxx, Dxz and Dzz with random phases, as sums of `lines` frequencies; real and imaginary part are two histories,
/// independent because frequencies of both signs have phases of their own.
fn series(roots: &[Root; FREQUENCIES], lines: usize) -> [Vec<Complex32>; 3] {
    let mut series = [(); 3].map(|()| vec![Complex32::ZERO; STEPS]);
    for line in 0..lines {
        let [l11, l21, l22, l31, l32, l33] = roots[line * FREQUENCIES / lines].map(|l| l as f32);
        for (sign, place) in [(0, line % STEPS), (1, (STEPS - line % STEPS) % STEPS)] {
            let turn = |which: u64| {
                let (cos, sin) = cos_sin_q24(mix(6 * line as u64 + 3 * sign + which) as u32);
                Complex32::new(cos as f32, sin as f32) * (1.0 / 16_777_216.0)
            };
            let (a, b, c) = (turn(0), turn(1), turn(2));
            let values = [a * l11, a * l21 + b * l22, a * l31 + b * l32 + c * l33];
            series.iter_mut().zip(values).for_each(|(series, value)| series[place] += value);
        }
    }
    // Scalar code rounds alike on every processor.
    let transform = FftPlannerScalar::new().plan_fft_inverse(STEPS);
    let mut scratch = vec![Complex32::ZERO; transform.get_inplace_scratch_len()];
    series.iter_mut().for_each(|series| transform.process_with_scratch(series, &mut scratch));
    series
}
