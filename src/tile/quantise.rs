//! Numbers to 16-bit counts of a fixed step, within a guaranteed error.

use crate::wire::{ErrorClass, Group};

/// Steps are this much below twice the guaranteed error. Dividing and multiplying in f32 err by up to 6e-8 of the
/// value each: at the largest count, 32767, together .006 of a step.
const SHRINK: f32 = 1.0 - 1.0 / 64.0;

/// Step of a channel: one count's worth. Fixed per class and group, never per frame.
pub fn quantiser_step(class: ErrorClass, group: Group) -> f32 {
    2.0 * class.max_error(group) * SHRINK
}

/// What quantising found on its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// A sample was beyond what a count can hold and was clamped.
    pub saturated: bool,
    /// A sample was not a number, or infinite.
    pub not_finite: bool,
}

/// Writes samples as little-endian counts.
pub fn quantise(samples: impl Iterator<Item = f32>, step: f32, counts: &mut [u8]) -> Found {
    // Adding and subtracting 1.5 * 2^23 rounds to even at twice the speed of round_ties_even on baseline x86-64.
    const ROUND: f32 = 12_582_912.0;
    let inverse = 1.0 / step;
    let (mut widest, mut sum) = (0.0_f32, 0.0_f32);
    for (sample, bytes) in samples.zip(counts.as_chunks_mut::<2>().0) {
        let scaled = sample * inverse;
        widest = widest.max(scaled.abs());
        // A NaN or an infinity stays one in a sum of products with zero; max would pass over a NaN.
        sum += sample * 0.0;
        let clamped = scaled.clamp(-32767.0, 32767.0);
        *bytes = (((clamped + ROUND) - ROUND) as i16).to_le_bytes();
    }
    Found { saturated: widest > 32767.0, not_finite: sum != 0.0 }
}
