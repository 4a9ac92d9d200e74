//! Which tick is next, and when it is due.

use crate::wire::TICKS_PER_SECOND;

/// Ticks between frames of a rate.
pub const fn interval_of_rate(rate_hz: u32) -> i64 {
    TICKS_PER_SECOND / rate_hz as i64
}

/// A frame is begun so long before it is due to leave, ticks: making it takes time. 33 ms.
pub const HEADSTART: i64 = TICKS_PER_SECOND / 30;

/// How long before its tick a frame leaves: cubic playback needs two frames ahead, and 100 ms are for the network.
pub fn lead_ticks(interval: i64) -> i64 {
    2 * interval + TICKS_PER_SECOND / 10
}

/// The next tick to make: the first on the grid of `interval` after `last`, or, when the engine has fallen behind,
/// the newest on the grid that is due. Also how many were passed over.
pub fn next_tick(last: Option<i64>, due: i64, interval: i64) -> (i64, u64) {
    let newest = due.div_euclid(interval) * interval;
    let Some(last) = last else { return (newest, 0) };
    let next = (last.div_euclid(interval) + 1) * interval;
    // One frame late is made up for; more are skipped, since a late frame is worth nothing.
    if next + interval >= newest { (next, 0) } else { (newest, ((newest - next) / interval) as u64) }
}
