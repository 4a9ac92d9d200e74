//! Foam: f <- max(d f, source(J)), and below a five-hundredth nothing.
//!
//! Only this form has a finite memory: every server that has run it long enough holds the same bits, whenever it began.

use crate::plan::FoamWork;
use crate::scene::Foam;

/// Foam shown at a tick, from the foam held since the last foam tick; on a foam tick it is then held itself.
pub fn foam(held: &mut [f32], jacobian: &[f32], threshold: f32, work: FoamWork, shown: &mut [f32]) {
    let decay = if work.restart { 0.0 } else { work.decay };
    let (flush, steepness) = (Foam::FLUSH as f32, (1.0 / Foam::SOURCE_WIDTH) as f32);
    for ((shown, held), j) in shown.iter_mut().zip(&*held).zip(jacobian) {
        let source = ((threshold - j) * steepness).clamp(0.0, 1.0);
        let foam = (decay * held).max(source);
        *shown = if foam < flush { 0.0 } else { foam };
    }
    if work.advance {
        held.copy_from_slice(shown);
    }
}
