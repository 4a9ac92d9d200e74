//! How much a client is given when it can't take all that it was granted: first fewer frames, then coarser ones. Pure.

use crate::engine::interval_of_rate;
use crate::wire::{Quality, RATES_HZ, Report, TICKS_PER_SECOND};

/// What is held must last this long, milliseconds, or the client is falling behind ...
const TOO_SHORT_MS: f64 = 20.0;
/// ... and this long, for it to be given more.
const LONG_MS: f64 = 60.0;
/// Decoding may take this share of the time between two frames ...
const TOO_SLOW: f64 = 0.7;
/// ... and at most this one of what it would be, for it to be given more.
const QUICK: f64 = 0.3;
/// Levels given up at most.
const COARSEST: u8 = 2;
/// Seconds before a change is judged: what is reported until then is still of before.
const SETTLE: u64 = 2;
/// Good seconds before more is tried, at first and at most; doubled each time that was too much.
const PATIENCE: u64 = 8;
const MOST_PATIENCE: u64 = 120;

/// Where a client stands between all and little.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// All that was granted first.
    rungs: Vec<Quality>,
    at: usize,
    /// Rungs that nobody gets.
    squeeze: usize,
    /// Seconds of the server: of the last change, and since when all was well.
    changed: u64,
    well_since: u64,
    patience: u64,
}

impl Ladder {
    /// The ladder of a client whose fastest unit comes at `rate_hz`.
    pub fn new(rate_hz: u32, now: u64) -> Self {
        let fewer = RATES_HZ.into_iter().rev().filter(|rate| *rate <= rate_hz);
        let coarser = (1..=COARSEST).map(|coarser| Quality { rate_hz: RATES_HZ[0], coarser });
        let rungs = fewer.map(|rate_hz| Quality { rate_hz, coarser: 0 }).chain(coarser).collect();
        Self { rungs, at: 0, squeeze: 0, changed: now, well_since: now, patience: PATIENCE }
    }

    /// What is sent.
    pub fn quality(&self) -> Quality {
        self.rungs[self.at.max(self.squeeze).min(self.rungs.len() - 1)]
    }

    /// Takes so many rungs from everybody; true when something else is to be sent from now on.
    pub fn squeeze(&mut self, squeeze: usize) -> bool {
        let before = self.quality();
        self.squeeze = squeeze;
        self.quality() != before
    }

    /// Takes a report at a second of the server; true when something else is to be sent from now on.
    pub fn heard(&mut self, report: &Report, now: u64) -> bool {
        let between = |quality: &Quality| interval_of_rate(quality.rate_hz) as f64 * 1e3 / TICKS_PER_SECOND as f64;
        let slow = report.decode_ms > TOO_SLOW * between(&self.quality());
        if report.buffer_ms < TOO_SHORT_MS || slow {
            self.well_since = now;
            return self.give_less(now);
        }
        let Some(more) = self.at.checked_sub(1).filter(|more| *more >= self.squeeze) else { return false };
        // A level finer has four times the samples.
        let finer = self.rungs[self.at].coarser > self.rungs[more].coarser;
        let expected_ms = report.decode_ms * if finer { 4.0 } else { 1.0 };
        if report.buffer_ms < LONG_MS || expected_ms > QUICK * between(&self.rungs[more]) {
            self.well_since = now;
            return false;
        }
        if now - self.well_since < self.patience {
            return false;
        }
        self.at = more;
        (self.changed, self.well_since) = (now, now);
        true
    }

    /// The client did not take its frames in time; true when something else is to be sent from now on.
    pub fn fell_behind(&mut self, now: u64) -> bool {
        self.well_since = now;
        self.give_less(now)
    }

    fn give_less(&mut self, now: u64) -> bool {
        let at = self.at.max(self.squeeze);
        if now - self.changed < SETTLE || at + 1 >= self.rungs.len() {
            return false;
        }
        self.at = at + 1;
        self.patience = (self.patience * 2).min(MOST_PATIENCE);
        self.changed = now;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(decode_ms: f64, buffer_ms: f64) -> Report {
        Report { tick: 0, decode_ms, buffer_ms, lost: false }
    }

    #[test]
    fn who_can_not_keep_up_is_given_fewer_frames_and_then_coarser_ones() {
        let mut ladder = Ladder::new(60, 0);
        let mut seen = vec![ladder.quality()];
        for now in 0..20 {
            if ladder.heard(&report(1.0, -50.0), now) {
                seen.push(ladder.quality());
            }
        }
        let seen: Vec<(u32, u8)> = seen.iter().map(|quality| (quality.rate_hz, quality.coarser)).collect();
        assert_eq!(seen, [(60, 0), (30, 0), (15, 0), (15, 1), (15, 2)]);
    }

    #[test]
    fn a_decoder_that_is_too_slow_counts_whatever_is_held() {
        let mut ladder = Ladder::new(60, 0);
        assert!(!ladder.heard(&report(11.0, 200.0), 5));
        assert!(ladder.heard(&report(12.0, 200.0), 5));
        assert_eq!(ladder.quality().rate_hz, 30);
    }

    #[test]
    fn more_is_tried_after_a_while_and_each_time_later() {
        let mut ladder = Ladder::new(30, 0);
        let mut waits = Vec::new();
        let mut since = 0;
        for now in 0..2000 {
            let bad = ladder.quality().rate_hz == 30;
            if ladder.heard(&report(1.0, if bad { 0.0 } else { 200.0 }), now) {
                if ladder.quality().rate_hz == 30 {
                    waits.push(now - since);
                }
                since = now;
            }
        }
        assert_eq!(waits[..5], [16, 32, 64, 120, 120]);
    }

    #[test]
    fn what_nobody_gets_is_not_tried() {
        let mut ladder = Ladder::new(60, 0);
        assert!(!ladder.squeeze(0) && ladder.squeeze(1) && !ladder.squeeze(1));
        assert_eq!(ladder.quality().rate_hz, 30);
        assert!((0..500).all(|now| !ladder.heard(&report(1.0, 200.0), now)), "it is well, and gets no more");
        assert!(ladder.squeeze(9) && ladder.quality().coarser == COARSEST);
        assert!(ladder.squeeze(0) && ladder.quality().rate_hz == 60);
    }

    #[test]
    fn one_report_of_before_a_change_does_not_count_twice() {
        let mut ladder = Ladder::new(30, 0);
        assert!(!ladder.heard(&report(1.0, 0.0), 1), "it has only just begun");
        assert!(ladder.heard(&report(1.0, 0.0), 2));
        assert!(!ladder.heard(&report(1.0, 0.0), 3) && !ladder.fell_behind(3));
        assert!(ladder.fell_behind(4));
    }
}
