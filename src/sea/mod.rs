//! The initial spectra, in f64: how much energy each mode of each cascade has, and how it turns with the tick.
//!
//! [`Timeline`] folds the log of changes over a scene; [`Timeline::at`] gives the [`Sea`] of a tick, which is all a
//! backend needs. Invariant: everything here is a function of (scene, changes, seed, tick), in portable arithmetic.

mod cell;
mod dispersion;
mod draw;
mod energy;
mod era;
mod foam_threshold;
mod layout;
mod measured;
mod modes;
mod noise;
mod phase;
mod spectrum;
mod spreading;
mod stages;
mod table;
mod timeline;

pub use dispersion::Dispersion;
pub use energy::Jonswap;
pub use era::Life;
pub use layout::{Cascade, Layout};
pub use measured::MeasuredSea;
pub use modes::{CascadeModes, Mode, Sea};
pub use noise::gaussian_pair;
pub use phase::{cos_sin_q24, cycles_per_repeat, turn_of_tick};
pub use spectrum::Spectrum;
pub use spreading::{cos2s, hasselmann_s, horvath_swell_s};
pub use table::EnergyTable;
pub use timeline::{MAX_OVERLAPPING, Timeline};
