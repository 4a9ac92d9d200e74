//! What accuracy costs in time: every choice that trades truth for time or bytes, measured beside the f64 reference on
//! the same sea.
//!
//! Invariant: errors and bytes are functions of (scene, seed, tick) alone; only times belong to the machine.

mod errors;
mod report;
pub mod serving;
mod timing;

pub use errors::{Errors, Particle};
pub use report::{Axis, Machine, Measure, Point, Report, STAGES, StageRow};
pub use timing::{Times, interleaved};
