//! The foam recursion in f64, run over its whole memory.

use super::grid::fields;
use crate::plan::Field;
use crate::scene::Foam;
use crate::sea::{Sea, Timeline};

/// Jacobian of the horizontal mapping, sample by sample.
pub fn jacobian(dxx: &[f64], dzz: &[f64], dxz: &[f64]) -> Vec<f64> {
    (0..dxx.len()).map(|i| (1.0 + dxx[i]) * (1.0 + dzz[i]) - dxz[i] * dxz[i]).collect()
}

/// Foam of one cascade at a tick, n x n: max(d f, r source(J)) over all foam ticks it can remember, nothing below
/// 1/512, and then once more from the last foam tick to this one. r is the time, over that of growth, for which the
/// water has gone on breaking.
pub fn foam(timeline: &Timeline, cascade: usize, tick: i64, foam: &Foam) -> Vec<f64> {
    let repeat = timeline.scene().repeat.ticks;
    let first = Foam::step_before(tick - foam.memory_ticks(), repeat);
    let n = timeline.layout().cascades[cascade].n;
    let (mut held, mut breaking) = (vec![0.0; n * n], vec![0.0; n * n]);
    let (mut loaded, mut sea) = (first, timeline.at(first));
    let steps = std::iter::successors(Some(first), |step| Some(Foam::step_after(*step, repeat)));
    let mut before = first;
    for tick in steps.take_while(|step| *step < tick).chain([tick]) {
        if !timeline.same_sea(tick, loaded) {
            (loaded, sea) = (tick, timeline.at(tick));
        }
        let (decay, growth) = (foam.decay_over(tick - before), foam.growth_over(tick - before));
        for ((held, breaking), source) in held.iter_mut().zip(&mut breaking).zip(source(&sea, cascade, tick)) {
            *breaking = if source > 0.0 { f64::min(*breaking + growth, 1.0) } else { 0.0 };
            let next = (decay * *held).max(source * *breaking);
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
