//! From fields to frames and back: tiles, quantising, and the payload of a frame.
//!
//! Invariant: a frame's bytes depend on (field, unit, tick, epoch, log) and on nothing else, so all clients share them.

mod decode;
mod encode;
mod level;

pub use decode::{DecodedFrame, decode};
pub use encode::{EncodeError, Plane, Stamp, encode};
pub use level::tiles_per_side;
