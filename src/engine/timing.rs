//! Times of several pieces of work in interleaved rounds, so that a noisy machine troubles all alike.

use serde::{Deserialize, Serialize};

use super::clock::Clock;

/// Milliseconds: the median, the quartiles around it, and what 95 of 100 rounds took no longer than.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Median.
    pub median_ms: f64,
    /// A quarter of the rounds took no longer.
    pub lower_ms: f64,
    /// Three quarters did.
    pub upper_ms: f64,
    /// The 95th percentile.
    pub p95_ms: f64,
}

impl Times {
    /// Of single times, milliseconds; all zero where there are none.
    pub fn of(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        let at = |hundredths: usize| times.get((times.len() * hundredths / 100).min(times.len().saturating_sub(1)));
        let [median_ms, lower_ms, upper_ms, p95_ms] = [50, 25, 75, 95].map(|share| at(share).copied().unwrap_or(0.0));
        Self { median_ms, lower_ms, upper_ms, p95_ms }
    }

    /// So many milliseconds more.
    pub fn plus(self, more_ms: f64) -> Self {
        let Self { median_ms, lower_ms, upper_ms, p95_ms } = self;
        let [median_ms, lower_ms, upper_ms, p95_ms] = [median_ms, lower_ms, upper_ms, p95_ms].map(|ms| ms + more_ms);
        Self { median_ms, lower_ms, upper_ms, p95_ms }
    }

    /// So many times as long.
    pub fn times(self, factor: f64) -> Self {
        let Self { median_ms, lower_ms, upper_ms, p95_ms } = self;
        let [median_ms, lower_ms, upper_ms, p95_ms] = [median_ms, lower_ms, upper_ms, p95_ms].map(|ms| ms * factor);
        Self { median_ms, lower_ms, upper_ms, p95_ms }
    }
}

/// Work that is measured; told which round it is.
pub type Timed<'a> = Box<dyn FnMut(i64) + 'a>;

/// Runs every work once without counting, then so many rounds of all in turn.
pub fn interleaved(clock: &Clock, rounds: usize, works: &mut [Timed]) -> Vec<Times> {
    let mut times = vec![Vec::with_capacity(rounds); works.len()];
    for round in 0..=rounds {
        for (work, times) in works.iter_mut().zip(&mut times) {
            let started = clock.now_us();
            work(round as i64);
            if round > 0 {
                times.push((clock.now_us() - started) as f64 / 1e3);
            }
        }
    }
    times.into_iter().map(Times::of).collect()
}
