//! When a change is to act, as it is asked.

use serde::Serialize;

use crate::wire::TICKS_PER_SECOND;

/// When a change is to act.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum When {
    /// As soon as it can.
    Soon,
    /// At a tick.
    Tick(i64),
    /// This many seconds after the request came.
    In(f64),
}

impl When {
    /// The tick that is meant, for a request that came at tick `arrived`. Saturates:
    /// [`Change::check_time`](crate::scene::Change::check_time) refuses what no tick can be.
    pub fn tick(self, arrived: i64, earliest: i64) -> i64 {
        match self {
            Self::Soon => earliest,
            Self::Tick(tick) => tick,
            Self::In(s) => arrived.saturating_add((s * TICKS_PER_SECOND as f64) as i64),
        }
    }
}
