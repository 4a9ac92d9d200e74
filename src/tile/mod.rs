//! From fields to frames and back: tiles, quantising, and the payload of a frame.
//!
//! Invariant: a frame's bytes depend on (field, unit, tick, epoch, log) and on nothing else, so all clients share them.

mod decode;
mod encode;
mod level;
mod quantise;

pub use decode::{DecodedFrame, decode};
pub use encode::{EncodeError, Stamp, encode};
pub use level::tiles_per_side;
pub use quantise::quantiser_step;
