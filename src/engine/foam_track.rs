//! Keeps foam's memory: which foam ticks are held, and which must be run again after a start or a jump.

use crate::plan::FoamWork;
use crate::scene::Foam;

/// Where the recursion stands. Foam is warm when every step that it can remember has been run.
#[derive(Clone, Copy, Debug)]
pub struct FoamTrack {
    foam: Foam,
    /// First foam tick that was run without a gap until `held`, and the last one.
    run: Option<(i64, i64)>,
}

impl FoamTrack {
    /// A recursion that holds nothing yet.
    pub fn new(foam: Foam) -> Self {
        Self { foam, run: None }
    }

    /// The last foam tick at or before a tick.
    fn grid(tick: i64) -> i64 {
        tick.div_euclid(Foam::STEP_TICKS) * Foam::STEP_TICKS
    }

    /// Foam tick that must be run next before foam can be shown at `tick`; `None` when it can.
    pub fn missing(&self, tick: i64) -> Option<i64> {
        let last = Self::grid(tick);
        // A frame on the foam grid advances foam itself.
        let wanted = if last == tick { last - Foam::STEP_TICKS } else { last };
        let memory = self.foam.memory_steps() * Foam::STEP_TICKS;
        match self.run {
            Some((first, held)) if held == wanted && held - first >= memory => None,
            Some((_, held)) if held < wanted && wanted - held <= memory => Some(held + Foam::STEP_TICKS),
            _ => Some(wanted - memory),
        }
    }

    /// Notes that a foam tick was run.
    pub fn ran(&mut self, tick: i64) {
        self.run = match self.run {
            Some((first, held)) if held + Foam::STEP_TICKS == tick => Some((first, tick)),
            _ => Some((tick, tick)),
        };
    }

    /// Forgets everything.
    pub fn forget(&mut self) {
        self.run = None;
    }

    /// Work of a foam tick on its own; begins anew where it doesn't follow the last one.
    pub fn catch_up(&self, tick: i64) -> FoamWork {
        let follows = self.run.is_some_and(|(_, held)| held + Foam::STEP_TICKS == tick);
        FoamWork { restart: !follows, decay: self.foam.decay_per_step() as f32, advance: true }
    }

    /// Work that shows foam at a tick whose memory is complete.
    pub fn show(&self, tick: i64) -> FoamWork {
        let since = tick - Self::grid(tick);
        let advance = since == 0;
        let decay = if advance { self.foam.decay_per_step() } else { self.foam.decay_over(since) };
        FoamWork { restart: false, decay: decay as f32, advance }
    }
}
