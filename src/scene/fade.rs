//! When a change of layout cross-fades: the one place that says which ticks belong to the old and the new cascades.

use super::{Change, ChangeKind, Foam};
use crate::wire::{REST_TICKS, SLOWEST_INTERVAL, TICKS_PER_SECOND};

/// How far back what is over is still asked for: as far as foam remembers, and ten seconds more, ticks.
pub const KEEP_TICKS: i64 = Foam::MAX_MEMORY_STEPS * Foam::STEP_TICKS + 10 * TICKS_PER_SECOND;
/// Shortest cross-fade: below a second it would be a cut.
pub const MIN_FADE_TICKS: i64 = TICKS_PER_SECOND;

/// The ticks of one change of layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CrossFade {
    /// The new cascades are part of the sea from here on.
    pub from: i64,
    /// Up to here the new cascades are exactly zero: the first tick at or after `from` that has a frame at every rate,
    /// so that nobody sees them begin with a step.
    pub begins: i64,
    /// From here on the old cascades are exactly zero.
    pub ends: i64,
    /// From here on the old cascades are no part of the sea.
    pub until: i64,
}

impl CrossFade {
    /// The ticks of a change of layout; `None` for any other change.
    pub fn of(change: &Change) -> Option<Self> {
        let ChangeKind::Layout { .. } = change.kind else { return None };
        let from = change.effective_tick;
        let begins = from.saturating_add(from.wrapping_neg().rem_euclid(SLOWEST_INTERVAL));
        let ends = begins.saturating_add(change.transition_ticks.max(1));
        Some(Self { from, begins, ends, until: ends.saturating_add(REST_TICKS) })
    }

    /// Smoothstep of the way through, 0 to 1, both exact.
    pub fn share(&self, tick: i64) -> f64 {
        if tick <= self.begins {
            return 0.0;
        }
        if tick >= self.ends {
            return 1.0;
        }
        let t = (tick - self.begins) as f64 / (self.ends - self.begins) as f64;
        t * t * (3.0 - 2.0 * t)
    }

    /// The tick from which on another change of layout can be accepted: until then the numbers of the old cascades are
    /// taken, and foam may still be asked for ticks at which they were there.
    pub fn over(&self) -> i64 {
        self.until.saturating_add(KEEP_TICKS)
    }
}
