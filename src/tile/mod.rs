//! From fields to frames and back: tiles, quantising, prediction, entropy coding, and the payload of a frame.
//!
//! Invariant: a frame's bytes depend on (fields of its tick and of the ticks it is predicted from, unit, epoch, log) and
//! on nothing else, so all clients share them.

mod counts;
mod decode;
mod deflate;
mod encode;
mod fit;
mod floats;
mod history;
mod lagrange;
mod level;
mod predict;
mod rans;
mod residual;
mod sent;

pub use counts::{EncodeError, Plane};
pub use decode::{DecodeError, DecodedFrame, Decoder, decode};
pub use encode::{Stamp, UnitEncoder};
pub use lagrange::lagrange;
pub use level::tiles_per_side;
pub use sent::SentFrame;
