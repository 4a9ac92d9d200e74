//! What accuracy costs in time: every choice that trades truth for time or bytes, measured beside the f64 reference on
//! the same sea.
//!
//! Invariant: errors and bytes are functions of (scene, seed, tick) alone; only times belong to the machine.

mod arithmetic;
mod axis;
mod claim;
mod errors;
mod foam;
mod ground;
mod image;
mod inverse;
mod model;
mod normals;
mod page;
mod picture;
mod playback;
mod plot;
mod received;
mod report;
mod resolution;
pub mod serving;
mod stages;
mod stream;
mod sweep;
mod table;
mod text;
mod waves;

pub use arithmetic::arithmetic;
pub use claim::{ChannelClaim, claims};
pub use errors::{Errors, Particle};
pub use foam::foam;
pub use ground::{Ground, hs_m, spots};
pub use image::Image;
pub use inverse::inverse;
pub use model::{left_out_by_trochoids, model, trochoid_sea};
pub use normals::normals;
pub use page::page;
pub use picture::{Picture, Pictures, pictures};
pub use playback::{Between, KERNELS, between_frames, playback};
pub use report::{Axis, Cost, Machine, Measure, Point, Report, SERVING, STAGES, StageRow};
pub use resolution::{band, cascades, grid};
pub use stages::stages;
pub use stream::stream;
pub use sweep::{Progress, Sweep, sweep};
pub use table::table;
pub use text::significant;
pub use waves::{ByCell, by_cell, dispersion, energy, narrow_swell, time};
