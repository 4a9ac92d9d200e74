//! How a connection fares: what it tells the server about once a second, so that it is given what it can take.

use crate::tile::{DecodeError, DecodedFrame};
use crate::wire::{Report, TICKS_PER_SECOND};

/// What decoding took of late, and how far what came reaches.
#[derive(Debug, Default)]
pub(super) struct Fares {
    /// The newest tick of all: units of one tick leave together, and of a cascade that has ended nothing comes.
    newest: Option<u64>,
    /// Since the last report: frames of how many ticks, and what they took.
    ticks: u64,
    us: i64,
    last: u64,
    lost: bool,
    /// A new beginning was asked for with the last report: frames that were under way then are no loss.
    asked: bool,
}

impl Fares {
    /// Counts a frame, and what decoding it took.
    pub(super) fn decoded(&mut self, decoded: &Result<DecodedFrame, DecodeError>, us: i64) {
        self.us += us;
        match decoded {
            Ok(frame) => {
                let h = &frame.header;
                self.newest = self.newest.max(Some(h.tick));
                // Frames of one tick stand together.
                self.ticks += u64::from(std::mem::replace(&mut self.last, h.tick) != h.tick);
            }
            Err(DecodeError::Missing) if self.asked => {}
            Err(DecodeError::Missing | DecodeError::Payload(_)) => self.lost = true,
            // Not of this protocol: a new beginning would change nothing.
            Err(DecodeError::Frame(_)) => {}
        }
    }

    /// A report at this server time, where there is something to tell.
    pub(super) fn report(&mut self, server_us: i64) -> Option<Report> {
        let tick = self.newest?;
        let us_of = |ticks: u64| ticks as f64 * 1e6 / TICKS_PER_SECOND as f64;
        let report = Report {
            tick,
            decode_ms: self.us as f64 / 1e3 / self.ticks.max(1) as f64,
            buffer_ms: (us_of(tick) - server_us as f64) / 1e3,
            lost: self.lost,
        };
        (self.ticks, self.us, self.asked, self.lost) = (0, 0, self.lost, false);
        Some(report)
    }
}
