//! The flow of one unit to one client: which of the frames in the ring it can read next.

use crate::tile::SentFrame;
use crate::wire::{BETWEEN, MAX_DEPTH, SLOWEST_INTERVAL, TICKS_PER_SECOND, UnitName, layer_of};

/// A unit that is sent: every multiple of its interval from the first tick on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flow {
    /// The unit.
    pub unit: UnitName,
    /// Ticks between its frames.
    pub interval: i64,
    /// The first tick.
    pub first: i64,
    /// The newest frame of the lowest rate that was sent, how many in a row may be predicted from with it, and the one
    /// before it.
    newest: i64,
    held: u8,
    before: i64,
    /// The newest frame halfway between two of those.
    middle: i64,
    /// What is being sent, tile by tile: tick and depth.
    sending: (i64, u8),
    /// A frame had to be passed over because the client lacks what it is predicted from.
    lost: bool,
}

impl Flow {
    /// A flow of which nothing was sent yet.
    pub fn new(unit: UnitName, interval: i64, first: i64) -> Self {
        let never = i64::MIN;
        let (newest, before, middle, sending) = (never, never, never, (never, 0));
        Self { unit, interval, first, newest, held: 0, before, middle, sending, lost: false }
    }

    /// The same flow, at another interval.
    pub fn every(self, interval: i64) -> Self {
        Self { interval, ..self }
    }

    /// Whether this frame is sent. Frames of a tick come with the deepest predictions first.
    /// With `keys`, whole seconds come as key frames.
    pub fn takes(&mut self, frame: &SentFrame, keys: bool) -> bool {
        let SentFrame { tick, depth, .. } = *frame;
        if tick % self.interval != 0 || tick < self.first {
            return false;
        }
        if !self.unit.codec.predicts() {
            return true;
        }
        if tick == self.sending.0 {
            return depth == self.sending.1;
        }
        let readable = if depth == BETWEEN {
            let gap = (SLOWEST_INTERVAL / 2) >> layer_of(tick).saturating_sub(1);
            self.has(tick - gap) && self.has(tick + gap)
        } else {
            let anew = keys && tick % TICKS_PER_SECOND == 0;
            let held = if self.newest == tick - SLOWEST_INTERVAL && !anew { self.held } else { 0 };
            self.lost |= depth > held;
            depth <= held
        };
        if !readable {
            return false;
        }
        match layer_of(tick) {
            0 => {
                // Who holds more than the frame needs may need it for the next.
                let follows = self.newest == tick - SLOWEST_INTERVAL && !(keys && tick % TICKS_PER_SECOND == 0);
                self.held = if follows { (self.held + 1).min(MAX_DEPTH) } else { 1 };
                (self.before, self.newest, self.lost) = (self.newest, tick, false);
            }
            1 => self.middle = tick,
            _ => {}
        }
        self.sending = (tick, depth);
        true
    }

    /// Whether key frames are needed; true once for each that was missed.
    pub fn is_lost(&mut self) -> bool {
        std::mem::take(&mut self.lost)
    }

    /// Begins anew: the client has lost what it had.
    pub fn forget(&mut self) {
        *self = Self::new(self.unit, self.interval, self.first);
        self.lost = self.unit.codec.predicts();
    }

    fn has(&self, tick: i64) -> bool {
        tick == self.newest || tick == self.before || tick == self.middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{Codec, ErrorClass, Group};

    const UNIT: UnitName =
        UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group: Group::Foam, codec: Codec::Rans };

    fn taken(flow: &mut Flow, frames: &[(i64, u8)]) -> Vec<(i64, u8)> {
        let frame = |(tick, depth)| SentFrame { unit: UNIT, tick, depth, bytes: bytes::Bytes::new() };
        frames.iter().copied().filter(|f| flow.takes(&frame(*f), false)).collect()
    }

    #[test]
    fn who_joins_takes_frames_as_deep_as_what_it_has() {
        let mut flow = Flow::new(UNIT, 480, 480);
        let ring = [(0, 3), (0, 0), (480, 3), (480, 0), (960, 3), (960, 1), (1440, 3), (1440, 2), (1920, 3)];
        assert_eq!(taken(&mut flow, &ring), [(480, 0), (960, 1), (1440, 2), (1920, 3)]);
        assert!(!flow.is_lost());
    }

    #[test]
    fn who_missed_a_frame_asks_once_and_takes_nothing_until_a_key_frame() {
        let mut flow = Flow::new(UNIT, 240, 0);
        assert_eq!(taken(&mut flow, &[(0, 0), (480, 1), (240, 4)]), [(0, 0), (480, 1), (240, 4)]);
        assert_eq!(taken(&mut flow, &[(1440, 3), (1200, 4)]), []);
        assert!(flow.is_lost());
        assert!(!flow.is_lost());
        assert_eq!(taken(&mut flow, &[(1920, 3), (1920, 0), (1680, 4), (2400, 1)]), [(1920, 0), (2400, 1)]);
    }

    #[test]
    fn a_frame_between_is_taken_only_with_both_neighbours() {
        let mut flow = Flow::new(UNIT, 120, 480);
        let frames = [(480, 0), (240, 4), (960, 1), (720, 4), (600, 4), (840, 4)];
        assert_eq!(taken(&mut flow, &frames), [(480, 0), (960, 1), (720, 4), (600, 4), (840, 4)]);
        let mut without_middle = Flow::new(UNIT, 120, 480);
        assert_eq!(taken(&mut without_middle, &[(480, 0), (960, 1), (600, 4), (840, 4)]), [(480, 0), (960, 1)]);
    }

    #[test]
    fn who_asks_for_keys_gets_one_each_second_and_misses_nothing() {
        let mut flow = Flow::new(UNIT, 240, 6240);
        let frame = |(tick, depth)| SentFrame { unit: UNIT, tick, depth, bytes: bytes::Bytes::new() };
        let ring = [(6240, 0), (6720, 1), (6480, 4), (7200, 2), (7200, 0), (6960, 4), (7680, 3), (7680, 1), (7440, 4)];
        let taken: Vec<(i64, u8)> = ring.into_iter().filter(|f| flow.takes(&frame(*f), true)).collect();
        assert_eq!(taken, [(6240, 0), (6720, 1), (6480, 4), (7200, 0), (6960, 4), (7680, 1), (7440, 4)]);
        assert!(!flow.is_lost());
    }

    #[test]
    fn all_tiles_of_a_tick_are_taken_at_one_depth() {
        let mut flow = Flow::new(UNIT, 480, 0);
        assert_eq!(taken(&mut flow, &[(0, 0), (0, 0), (480, 1), (480, 1), (480, 0), (480, 0)]).len(), 4);
    }
}
