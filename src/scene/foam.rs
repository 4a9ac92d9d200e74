//! How foam appears and fades.

use super::bound::{SceneError, within};

/// Settings of the foam recursion f <- max(d f, source(J)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foam {
    /// Time in which foam fades to 1/e, seconds.
    pub decay_s: f64,
    /// Artistic factor on the wanted coverage; 1 is the sea's own.
    pub gain: f64,
}

impl Default for Foam {
    fn default() -> Self {
        Self { decay_s: 2.5, gain: 1.0 }
    }
}

impl Foam {
    /// Foam is advanced on the absolute grid of multiples of this many ticks (10 Hz).
    pub const STEP_TICKS: i64 = 720;
    /// Foam below this is none: what makes its memory finite.
    pub const FLUSH: f64 = 1.0 / 512.0;
    /// Jacobian from the threshold down to which foam grows from none to full.
    pub const SOURCE_WIDTH: f64 = 0.15;
    /// Most steps a state may remember.
    pub const MAX_MEMORY_STEPS: i64 = 200;

    /// Checks both settings.
    ///
    /// # Errors
    /// [`SceneError::Bound`] when the memory would outlast [`Self::MAX_MEMORY_STEPS`] or a number is out of bounds.
    pub fn check(self) -> Result<Self, SceneError> {
        Ok(Self {
            decay_s: within("effects.foam_decay_s", self.decay_s, 0.1, 3.15)?,
            gain: within("effects.foam_gain", self.gain, 0.0, 10.0)?,
        })
    }

    /// Share of foam left after one step.
    pub fn decay_per_step(self) -> f64 {
        self.decay_over(Self::STEP_TICKS)
    }

    /// Share of foam left after `ticks`.
    pub fn decay_over(self, ticks: i64) -> f64 {
        libm::exp(-(ticks as f64) / (7200.0 * self.decay_s))
    }

    /// Steps after which nothing of an earlier state is left: ln(1 / flush) decay times, and one for rounding.
    pub fn memory_steps(self) -> i64 {
        (libm::log(Self::FLUSH) / libm::log(self.decay_per_step())).ceil() as i64 + 1
    }
}
