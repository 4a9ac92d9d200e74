//! The only place that asks the machine for the time.
#![allow(clippy::disallowed_methods, reason = "everywhere else time is an argument")]

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::wire::TICKS_PER_SECOND;

/// Server time since tick 0: set by the calendar once, at start, and monotonic from there on.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    started: Instant,
    started_us: i64,
}

impl Clock {
    /// A clock whose tick 0 was at `epoch_unix_ns` (nanoseconds since 1970). One in the future reads tick 0 now.
    pub fn start(epoch_unix_ns: i64) -> Self {
        let started_us = (Self::unix_now_ns().saturating_sub(epoch_unix_ns) / 1000).max(0);
        Self { started: Instant::now(), started_us }
    }

    /// The same clock, at `tick` now if it would read less.
    pub fn not_before(self, tick: i64) -> Self {
        let us = i64::try_from(i128::from(tick) * 1_000_000 / i128::from(TICKS_PER_SECOND)).unwrap_or(i64::MAX);
        Self { started_us: self.started_us.max(us), ..self }
    }

    /// Nanoseconds since 1970.
    pub fn unix_now_ns() -> i64 {
        SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| i64::try_from(d.as_nanos()).unwrap_or(i64::MAX))
    }

    /// Microseconds since tick 0.
    pub fn now_us(&self) -> i64 {
        let elapsed = i64::try_from(self.started.elapsed().as_micros()).unwrap_or(i64::MAX);
        self.started_us.saturating_add(elapsed)
    }

    /// The tick.
    pub fn now_tick(&self) -> i64 {
        tick_of_us(self.now_us())
    }

    /// Time from now until a tick; zero when it has passed.
    pub fn until(&self, tick: i64) -> Duration {
        let us = (i128::from(tick) * 1_000_000).div_euclid(i128::from(TICKS_PER_SECOND)) + 1;
        Duration::from_micros((us - i128::from(self.now_us())).clamp(0, 60_000_000) as u64)
    }
}

fn tick_of_us(us: i64) -> i64 {
    (i128::from(us) * i128::from(TICKS_PER_SECOND)).div_euclid(1_000_000) as i64
}
