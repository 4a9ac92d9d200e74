//! The foam recursion in f64, run over its whole memory.

use super::grid::fields;
use crate::plan::Field;
use crate::scene::Foam;
use crate::sea::{Sea, Timeline};

/// Jacobian of the horizontal mapping, sample by sample.
pub fn jacobian(dxx: &[f64], dzz: &[f64], dxz: &[f64]) -> Vec<f64> {
    (0..dxx.len()).map(|i| (1.0 + dxx[i]) * (1.0 + dzz[i]) - dxz[i] * dxz[i]).collect()
}

/// Foam of one cascade at a tick, n x n: max(d f, source(J)) over all foam ticks it can remember, nothing below
/// 1/512, and then once more from the last foam tick to this one.
pub fn foam(timeline: &Timeline, cascade: usize, tick: i64, foam: &Foam) -> Vec<f64> {
    let last = tick.div_euclid(Foam::STEP_TICKS) * Foam::STEP_TICKS;
    let first = last - foam.memory_steps() * Foam::STEP_TICKS;
    let n = timeline.layout().cascades[cascade].n;
    let mut held = vec![0.0; n * n];
    let (mut loaded, mut sea) = (first, timeline.at(first));
    let mut ticks: Vec<i64> = (first..=last).step_by(Foam::STEP_TICKS as usize).collect();
    if tick > last {
        ticks.push(tick);
    }
    let mut before = first;
    for tick in ticks {
        if !timeline.same_sea(tick, loaded) {
            (loaded, sea) = (tick, timeline.at(tick));
        }
        let decay = foam.decay_over(tick - before);
        for (held, source) in held.iter_mut().zip(source(&sea, cascade, tick)) {
            let next = (decay * *held).max(source);
            *held = if next < Foam::FLUSH { 0.0 } else { next };
        }
        before = tick;
    }
    held
}

fn source(sea: &Sea, cascade: usize, tick: i64) -> Vec<f64> {
    let derivatives = fields(sea, cascade, tick, &[Field::Dxx, Field::Dzz, Field::Dxz]);
    let jacobian = jacobian(&derivatives[0], &derivatives[1], &derivatives[2]);
    jacobian
        .into_iter()
        .map(|j| ((sea.cascades[cascade].foam_threshold - j) / Foam::SOURCE_WIDTH).clamp(0.0, 1.0))
        .collect()
}
