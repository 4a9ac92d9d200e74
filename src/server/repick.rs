//! Which setting a budget of milliseconds picks, and by which rules step times that are seen make it another.

use crate::accuracy::{Axis, Point};

/// Seconds in a row above the budget before a cheaper setting is picked ...
const OVER: u32 = 5;
/// ... and seconds in a row in which a better one would stay below this share of it before that one is.
const UNDER: u32 = 60;
const LOW: f64 = 0.7;
/// Share of the budget that a pick may take, as in [`Axis::best_within`].
const PICKED: f64 = 0.8;
/// Frames before anything is decided.
const ENOUGH: usize = 50;

/// A setting that is picked.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// The setting, with what it errs and what it took when it was measured.
    pub point: Point,
    /// Whether it fits the budget; else it is the cheapest there is.
    pub fits: bool,
    /// How many times as slow as it was the machine is taken to be; below 1 only where it was busy then.
    pub slower: f64,
}

/// What one second was like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Second {
    /// 95 of 100 frames took no longer, milliseconds.
    pub p95_ms: f64,
    /// Frames since the second before.
    pub frames: usize,
    /// Whether another setting could be taken.
    pub settled: bool,
}

/// Seconds in a row, of one pick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    /// Frames so far.
    frames: usize,
    over: u32,
    under: u32,
    /// The highest 95th percentile of the seconds in which there was room.
    highest_ms: f64,
}

/// What a budget picks on a machine that is so many times as slow as it was; `None` where nothing was measured.
pub fn pick(axis: &Axis, budget_ms: f64, slower: f64) -> Option<Picked> {
    if let Some(point) = axis.best_within(budget_ms / slower) {
        return Some(Picked { point: point.clone(), fits: true, slower });
    }
    let cheapest = axis.points.iter().min_by(|a, b| p95(a).total_cmp(&p95(b)))?;
    Some(Picked { point: cheapest.clone(), fits: false, slower })
}

/// What a point took when it was measured; no frame is made in no time.
fn p95(point: &Point) -> f64 {
    point.time.map_or(f64::INFINITY, |time| time.p95_ms.max(1e-3))
}

impl Watch {
    /// Takes note of a second; what is to be picked from now on, where that is another setting.
    pub fn second(&mut self, axis: &Axis, picked: &Picked, budget_ms: f64, second: Second) -> Option<Picked> {
        if second.frames == 0 {
            // Nothing is made, so nothing is known.
            (self.over, self.under) = (0, 0);
            return None;
        }
        self.frames = self.frames.saturating_add(second.frames);
        if self.frames < ENOUGH {
            return None;
        }
        let slower = second.p95_ms / p95(&picked.point);
        self.over = if second.p95_ms > budget_ms { self.over.saturating_add(1) } else { 0 };
        if better(axis, picked, budget_ms, slower).is_some() {
            self.highest_ms = if self.under == 0 { second.p95_ms } else { self.highest_ms.max(second.p95_ms) };
            self.under = self.under.saturating_add(1);
        } else {
            self.under = 0;
        }
        let next = match () {
            () if !second.settled => None,
            () if self.over >= OVER => pick(axis, budget_ms, slower.max(1.0)),
            () if self.under >= UNDER => better(axis, picked, budget_ms, self.highest_ms / p95(&picked.point)),
            () => None,
        };
        let next = next.filter(|next| (&next.point.setting, next.fits) != (&picked.point.setting, picked.fits));
        if next.is_some() {
            *self = Self::default();
        }
        next
    }
}

/// The most accurate setting for which there is room, if that is more accurate than the one picked: what would fit the
/// machine as it was measured, and take less than [`LOW`] of the budget on one that is so many times as slow, or as quick.
/// Where nothing fits, it may have been busy when it was measured, and what is seen now counts alone.
fn better(axis: &Axis, picked: &Picked, budget_ms: f64, slower: f64) -> Option<Picked> {
    let error = |point: &Point| axis.measure.of(&point.errors).unwrap_or(f64::INFINITY);
    let room = LOW / PICKED * budget_ms / slower;
    let point = axis.best_within(if picked.fits { budget_ms.min(room) } else { room })?;
    let better = !picked.fits || error(point) < error(&picked.point);
    // What it will take is told by this: not what a busy machine took.
    let slower = if picked.fits { slower.max(1.0) } else { slower };
    better.then(|| Picked { point: point.clone(), fits: true, slower })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::{Cost, Errors, Measure};
    use crate::engine::Times;

    const BUDGET: f64 = 4.0;

    /// Settings that take so long, each a third as far off as the one before.
    fn axis(times_ms: &[f64]) -> Axis {
        let point = |(i, ms): (usize, &f64)| Point {
            setting: format!("{ms} ms"),
            errors: Errors { height_rms: Some(0.3_f64.powi(i as i32)), ..Errors::default() },
            time: Some(Times { median_ms: *ms, lower_ms: *ms, upper_ms: *ms, p95_ms: *ms }),
            bytes_per_s: None,
            memory_bytes: None,
            front: false,
        };
        let points = times_ms.iter().enumerate().map(point).collect();
        let (name, about) = (String::new(), String::new());
        let mut axis = Axis { name, about, measure: Measure::Height, cost: Cost::Time, points };
        axis.mark_front();
        axis
    }

    /// A server on a machine that is `slow(second)` times as slow as it was measured, for so many seconds: what is picked,
    /// and when. A change of layout takes 40 seconds to settle.
    fn run(seconds: u32, slow: impl Fn(u32) -> f64, frames: impl Fn(u32) -> usize) -> Vec<(u32, String)> {
        run_of(&[0.1, 0.5, 1.0, 2.0, 3.0, 6.0], seconds, slow, frames)
    }

    /// The same of settings that took so long when they were measured.
    fn run_of(
        times_ms: &[f64],
        seconds: u32,
        slow: impl Fn(u32) -> f64,
        frames: impl Fn(u32) -> usize,
    ) -> Vec<(u32, String)> {
        let axis = axis(times_ms);
        let (mut watch, mut picked) = (Watch::default(), pick(&axis, BUDGET, 1.0).unwrap());
        let (mut settled, mut picks) = (40, vec![(0, picked.point.setting.clone())]);
        for at in 1..=seconds {
            let second = Second { p95_ms: slow(at) * p95(&picked.point), frames: frames(at), settled: at >= settled };
            if let Some(next) = watch.second(&axis, &picked, BUDGET, second) {
                assert!(at >= settled, "picked at {at}, settled at {settled}");
                picks.push((at, next.point.setting.clone()));
                (picked, settled) = (next, at + 40);
            }
        }
        picks
    }

    fn named(picks: &[(u32, &str)]) -> Vec<(u32, String)> {
        picks.iter().map(|(at, name)| (*at, (*name).to_owned())).collect()
    }

    #[test]
    fn a_machine_as_fast_as_it_was_stays_with_its_pick() {
        assert_eq!(run(1000, |_| 1.0, |_| 30), named(&[(0, "3 ms")]));
        // Up to a third slower the budget holds, and hiccups of four seconds are none of a machine's speed.
        assert_eq!(run(1000, |_| 1.33, |_| 30), named(&[(0, "3 ms")]));
        assert_eq!(run(1000, |at| if at % 5 == 0 { 1.0 } else { 9.0 }, |_| 30), named(&[(0, "3 ms")]));
    }

    #[test]
    fn a_slower_machine_steps_down_once_and_recovers_late() {
        // Twice as slow for two minutes, from the 100th second on.
        let slow = |at: u32| if (100..220).contains(&at) { 2.0 } else { 1.0 };
        let picks = run(2000, slow, |_| 30);
        // Down after five seconds to what takes at most 3.2 of 4 ms; up after a minute, to what takes less than 2.8.
        assert_eq!(picks, named(&[(0, "3 ms"), (104, "1 ms"), (279, "2 ms")]));
    }

    #[test]
    fn a_slow_machine_waits_until_the_layout_has_settled() {
        let slow = |at: u32| if at < 60 { 2.0 } else { 5.0 };
        assert_eq!(run(1000, slow, |_| 30), named(&[(0, "3 ms"), (40, "1 ms"), (80, "0.5 ms")]));
        // Where nothing fits, the cheapest is taken, and that is told once.
        let picks = run(1000, |_| 1000.0, |_| 30);
        assert_eq!(picks, named(&[(0, "3 ms"), (40, "0.1 ms")]));
    }

    #[test]
    fn a_machine_that_was_busy_when_it_was_measured_is_not_held_to_that() {
        // All but the last fit, in truth: they take a tenth of what was measured.
        let picks = run_of(&[5.0, 10.0, 20.0, 50.0], 1000, |_| 0.1, |_| 30);
        assert_eq!(picks, named(&[(0, "5 ms"), (61, "20 ms")]));
        // Where it really is that slow, nothing is tried.
        assert_eq!(run_of(&[5.0, 10.0], 1000, |_| 1.0, |_| 30), named(&[(0, "5 ms")]));
    }

    #[test]
    fn a_machine_at_the_bound_does_not_flap() {
        // Each pick would be over the budget with the next better one, and is not without.
        for slower in [1.34, 1.4, 1.5, 1.7, 1.9, 2.2, 2.6, 3.0, 4.5, 6.0] {
            let picks = run(5000, |_| slower, |_| 30);
            assert!(picks.len() <= 2, "{slower}: {picks:?}");
        }
        // Nor where its speed comes and goes within a minute.
        let picks = run(5000, |at| if at % 40 < 20 { 1.0 } else { 1.9 }, |_| 30);
        assert!(picks.len() <= 2, "{picks:?}");
    }

    #[test]
    fn without_frames_nothing_is_decided() {
        assert_eq!(run(1000, |_| 9.0, |_| 0), named(&[(0, "3 ms")]));
        // Nor with a few of them.
        assert_eq!(run(49, |_| 9.0, |_| 1), named(&[(0, "3 ms")]));
        // Nor where they pause before they have been too slow for long.
        assert_eq!(run(1000, |_| 9.0, |at| if at % 5 == 0 { 0 } else { 30 }), named(&[(0, "3 ms")]));
    }

    #[test]
    fn a_larger_budget_picks_no_worse_and_none_takes_more_than_it_may() {
        let axis = axis(&[0.1, 0.3, 0.75, 0.9, 1.55, 1.9, 3.1, 6.3, 12.0]);
        let mut last = f64::INFINITY;
        for budget in [0.05, 0.5, 1.0, 2.0, 4.0, 8.0] {
            let picked = pick(&axis, budget, 1.0).unwrap();
            assert_eq!(picked.fits, budget >= 0.5, "{budget}");
            assert!(!picked.fits || p95(&picked.point) <= PICKED * budget, "{budget}: {picked:?}");
            let error = picked.point.errors.height_rms.unwrap();
            assert!(error < last || !picked.fits, "{budget}: {error} after {last}");
            last = error;
        }
        assert_eq!(pick(&self::axis(&[]), 1.0, 1.0), None);
    }
}
