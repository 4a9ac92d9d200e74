//! How long the newest frames took: a window of step times that the engine's thread fills.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use crate::engine::Times;
use crate::wire::TICKS_PER_SECOND;

/// Frames that are held.
const HELD: usize = 256;
/// How far back frames are looked at, ticks: three seconds, so that a hiccup is soon forgotten.
const WINDOW: i64 = 3 * TICKS_PER_SECOND;

/// Step times of the newest frames.
#[derive(Debug, Default)]
pub struct Pace(Mutex<Held>);

#[derive(Debug, Default)]
struct Held {
    /// Tick and milliseconds, the newest last.
    frames: VecDeque<(i64, f64)>,
    /// Frames so far.
    count: u64,
}

/// What was seen of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// 95 of 100 frames took no longer, milliseconds.
    pub p95_ms: f64,
    /// Frames that this was taken of.
    pub frames: usize,
    /// Frames so far in all.
    pub count: u64,
}

impl Pace {
    /// The frames of a tick took so many milliseconds. One that nobody timed is none.
    pub fn note(&self, tick: i64, step_ms: f64) {
        if step_ms <= 0.0 {
            return;
        }
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.frames.push_back((tick, step_ms));
        held.count += 1;
        if held.frames.len() > HELD {
            held.frames.pop_front();
        }
    }

    /// Those of the three seconds before the newest, but none from before a tick.
    pub fn seen(&self, from_tick: i64) -> Seen {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = held.frames.back().map_or(i64::MIN, |(tick, _)| *tick);
        let from_tick = from_tick.max(newest.saturating_sub(WINDOW));
        let times: Vec<f64> = held.frames.iter().filter(|(tick, _)| *tick >= from_tick).map(|(_, ms)| *ms).collect();
        Seen { frames: times.len(), p95_ms: Times::of(times).p95_ms, count: held.count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_newest_frames_count_and_no_more_are_held() {
        let pace = Pace::default();
        assert_eq!(pace.seen(0), Seen::default());
        for i in 0..1000 {
            pace.note(i * 240, if i < 990 { 1.0 } else { 9.0 });
        }
        pace.note(240_000, 0.0);
        assert_eq!(pace.seen(0), Seen { p95_ms: 9.0, frames: 91, count: 1000 });
        assert_eq!(pace.seen(995 * 240).frames, 5, "from a tick on");
        assert_eq!(pace.0.lock().unwrap().frames.len(), HELD);
    }
}
