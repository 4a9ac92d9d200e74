//! What accuracy costs in time: every choice that trades truth for time or bytes, measured beside the f64 reference on
//! the same sea.
//!
//! Invariant: errors and bytes are functions of (scene, seed, tick) alone; only times belong to the machine.

mod errors;
mod image;
mod page;
mod picture;
mod plot;
mod report;
mod sweep;
mod table;
mod text;
mod timing;

pub use errors::{Errors, Particle};
pub use image::Image;
pub use page::page;
pub use picture::{Picture, Pictures, pictures};
pub use report::{Axis, Machine, Measure, Point, Report, STAGES, StageRow};
pub use sweep::{Progress, Sweep, sweep};
pub use table::table;
pub use text::significant;
pub use timing::{Times, interleaved};
