//! Foam of a grid, from its Jacobian and what is held since the last foam tick.

use crate::plan::FoamWork;
use crate::sea::HeldFoam;

/// Foam shown at a tick; on a foam tick it is then held itself. Without a Jacobian nothing breaks.
pub fn foam(held: &mut [HeldFoam], jacobian: &[f32], threshold: f32, work: FoamWork, shown: &mut [f32]) {
    let step = |shown: &mut f32, held: &mut HeldFoam, jacobian: f32, threshold: f32| {
        let before = if work.restart { HeldFoam::default() } else { *held };
        let now = before.step(jacobian, threshold, work.decay, work.growth);
        *shown = now.foam;
        if work.advance {
            *held = now;
        }
    };
    let samples = shown.iter_mut().zip(held);
    match work.breaks {
        true => samples.zip(jacobian).for_each(|((shown, held), j)| step(shown, held, *j, threshold)),
        false => samples.for_each(|(shown, held)| step(shown, held, 1.0, 0.0)),
    }
}
