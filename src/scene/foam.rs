//! How foam appears and fades, and when it is advanced.

use super::bound::{SceneError, within};
use crate::wire::TICKS_PER_SECOND;

/// Settings of the foam recursion f <- max(d f, r source(J)), where r is the share of its growth that water has made
/// that breaks without a pause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foam {
    /// Time that water must go on breaking until its foam is whole, seconds.
    pub growth_s: f64,
    /// Time in which foam fades to 1/e, seconds.
    pub decay_s: f64,
    /// Artistic factor on the wanted coverage; 1 is the sea's own.
    pub gain: f64,
}

impl Default for Foam {
    fn default() -> Self {
        Self { growth_s: 0.3, decay_s: 2.5, gain: 1.0 }
    }
}

impl Foam {
    /// Foam is advanced every so many ticks (10 Hz), counted from the beginning of each repeat.
    pub const STEP_TICKS: i64 = 720;
    /// Foam below this is none: what makes its memory finite.
    pub const FLUSH: f64 = 1.0 / 512.0;
    /// Jacobian from the threshold down to which foam grows from none to full.
    pub const SOURCE_WIDTH: f64 = 0.15;
    /// Foam above this counts as covering the water.
    pub const COVERS: f64 = 0.1;
    /// Longest memory, in whole steps.
    pub const MAX_MEMORY_STEPS: i64 = 200;

    /// Checks the settings; together they keep the memory below [`Self::MAX_MEMORY_STEPS`].
    ///
    /// # Errors
    /// [`SceneError::Bound`] when a number is out of bounds.
    pub fn check(self) -> Result<Self, SceneError> {
        Ok(Self {
            growth_s: within("effects.foam_growth_s", self.growth_s, 0.0, 1.0)?,
            decay_s: within("effects.foam_decay_s", self.decay_s, 0.1, 3.0)?,
            gain: within("effects.foam_gain", self.gain, 0.0, 10.0)?,
        })
    }

    /// Share of foam left after `ticks`.
    pub fn decay_over(self, ticks: i64) -> f64 {
        libm::exp(-(ticks as f64) / (TICKS_PER_SECOND as f64 * self.decay_s))
    }

    /// Share of its growth that foam makes in `ticks`, at most 1.
    pub fn growth_over(self, ticks: i64) -> f64 {
        let whole = TICKS_PER_SECOND as f64 * self.growth_s;
        if whole > ticks as f64 { ticks as f64 / whole } else { 1.0 }
    }

    /// Ticks after which nothing of an earlier state is left: ln(1 / flush) decay times and the time of growth, and a
    /// step for rounding.
    pub fn memory_ticks(self) -> i64 {
        let seconds = self.decay_s * libm::log(1.0 / Self::FLUSH) + self.growth_s;
        (seconds * TICKS_PER_SECOND as f64).ceil() as i64 + Self::STEP_TICKS
    }

    /// The last foam tick at or before `tick`, of a sea that repeats after `repeat` ticks. The grid begins anew with
    /// each repeat, so that foam repeats, too.
    pub fn step_before(tick: i64, repeat: u64) -> i64 {
        // A repeat is at most 2^32 ticks.
        let within = i128::from(tick).rem_euclid(i128::from(repeat)) as i64;
        tick - within % Self::STEP_TICKS
    }

    /// The first foam tick after `tick`.
    pub fn step_after(tick: i64, repeat: u64) -> i64 {
        let within = i128::from(tick).rem_euclid(i128::from(repeat)) as i64;
        let rest = i64::try_from(repeat).unwrap_or(i64::MAX) - within;
        tick + rest.min(Self::STEP_TICKS - within % Self::STEP_TICKS)
    }
}
