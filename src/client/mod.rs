//! The Rust thin client: connects, keeps server time, decodes and interpolates; `swellcast watch` is built of it.
//!
//! Invariant: nothing a server sends makes it panic, hang, or hold more memory than its subscription needs. It knows
//! the protocol and nothing of how a sea is made; it reads no clock, time is passed in.

mod choice;
mod clock;
mod connection;
mod fares;
mod http;
mod metered;
mod playback;
mod record;
mod relief;
mod stats;
mod surface;
mod watch;

pub(crate) use connection::stream_uri;
pub(crate) use http::exchange;

pub use choice::{Choice, cascades, class, codec, group};
pub use clock::{Exchange, SharedClock};
pub use connection::{Closed, ConnectError, Connection, Event};
pub use playback::{Footing, MAX_SAMPLES, Playback, RING, StrayFrame, TileKey};
pub use record::{RecordArguments, Recorded, record};
pub use relief::{Rgb, relief};
pub use stats::{Report, Stats};
pub use surface::{Patch, Point};
pub use watch::{WatchArguments, watch};
