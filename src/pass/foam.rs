//! Foam of a grid, from its Jacobian and what is held since the last foam tick.

use crate::plan::FoamWork;
use crate::sea::HeldFoam;

/// Foam shown at a tick; on a foam tick it is then held itself.
pub fn foam(held: &mut [HeldFoam], jacobian: &[f32], threshold: f32, work: FoamWork, shown: &mut [f32]) {
    for ((shown, held), j) in shown.iter_mut().zip(held).zip(jacobian) {
        let before = if work.restart { HeldFoam::default() } else { *held };
        let now = before.step(*j, threshold, work.decay, work.growth);
        *shown = now.foam;
        if work.advance {
            *held = now;
        }
    }
}
