//! Keeps foam's memory: which foam ticks are held, and which must be run again after a start or a jump.

use crate::plan::FoamWork;
use crate::scene::Foam;

/// Where the recursion stands. Foam is warm when every step that it can remember has been run.
#[derive(Clone, Copy, Debug)]
pub struct FoamTrack {
    foam: Foam,
    repeat: u64,
    /// First foam tick that was run without a gap until `held`, and the last one.
    run: Option<(i64, i64)>,
}

impl FoamTrack {
    /// A recursion that holds nothing yet, of a sea that repeats after `repeat` ticks.
    pub fn new(foam: Foam, repeat: u64) -> Self {
        Self { foam, repeat, run: None }
    }

    /// Foam tick that must be run next before foam can be shown at `tick`; `None` when it can.
    pub fn missing(&self, tick: i64) -> Option<i64> {
        // A frame on the foam grid advances foam itself.
        let wanted = Foam::step_before(tick - 1, self.repeat);
        let memory = self.foam.memory_ticks();
        match self.run {
            Some((first, held)) if held == wanted && held - first >= memory => None,
            // The first step lies up to a step before the memory begins.
            Some((_, held)) if held < wanted && wanted - held < memory + Foam::STEP_TICKS => Some(self.after(held)),
            _ => Some(Foam::step_before(wanted - memory, self.repeat)),
        }
    }

    /// Notes that a foam tick was run.
    pub fn ran(&mut self, tick: i64) {
        self.run = match self.run {
            Some((first, held)) if self.after(held) == tick => Some((first, tick)),
            _ => Some((tick, tick)),
        };
    }

    /// Forgets everything.
    pub fn forget(&mut self) {
        self.run = None;
    }

    /// Work of a foam tick on its own; begins anew where it doesn't follow the last one.
    pub fn catch_up(&self, tick: i64) -> FoamWork {
        let follows = self.run.is_some_and(|(_, held)| self.after(held) == tick);
        FoamWork { restart: !follows, ..self.show(tick) }
    }

    /// Work that shows foam at a tick whose memory is complete.
    pub fn show(&self, tick: i64) -> FoamWork {
        let since = tick - Foam::step_before(tick - 1, self.repeat);
        FoamWork {
            restart: false,
            decay: self.foam.decay_over(since) as f32,
            growth: self.foam.growth_over(since) as f32,
            advance: Foam::step_before(tick, self.repeat) == tick,
            breaks: true,
        }
    }

    fn after(&self, tick: i64) -> i64 {
        Foam::step_after(tick, self.repeat)
    }
}
