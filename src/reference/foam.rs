//! The foam recursion in f64, run over its whole memory.

use super::grid::fields;
use crate::plan::Field;
use crate::scene::Foam;
use crate::sea::Timeline;

/// Foam of one cascade at the last foam tick at or before `tick`, n x n.
///
/// The form is the one of PHYSICS: max(d f, source(J)), nothing below 1/512, source rising over .15 of Jacobian.
pub fn held_foam(timeline: &Timeline, cascade: usize, tick: i64, foam: &Foam) -> Vec<f64> {
    let last = tick.div_euclid(Foam::STEP_TICKS);
    let n = timeline.layout().cascades[cascade].n;
    let mut held = vec![0.0; n * n];
    let first = (last - foam.memory_steps()) * Foam::STEP_TICKS;
    let (mut loaded, mut sea) = (first, timeline.at(first));
    for tick in (first..=last * Foam::STEP_TICKS).step_by(Foam::STEP_TICKS as usize) {
        if !timeline.same_sea(tick, loaded) {
            (loaded, sea) = (tick, timeline.at(tick));
        }
        let derivatives = fields(&sea, cascade, tick, &[Field::Dxx, Field::Dzz, Field::Dxz]);
        for (i, held) in held.iter_mut().enumerate() {
            let [dxx, dzz, dxz] = [derivatives[0][i], derivatives[1][i], derivatives[2][i]];
            let jacobian = (1.0 + dxx) * (1.0 + dzz) - dxz * dxz;
            let source = ((sea.foam_threshold - jacobian) / 0.15).clamp(0.0, 1.0);
            let next = (foam.decay_per_step() * *held).max(source);
            *held = if next < Foam::FLUSH { 0.0 } else { next };
        }
    }
    held
}
