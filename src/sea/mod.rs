//! The initial spectra, in f64: how much energy each mode of each cascade has, and how it turns with the tick.
//!
//! [`Timeline`] folds the log of changes over a scene; [`Timeline::at`] gives the [`Sea`] of a tick, which is all a
//! backend needs. Invariant: everything here is a function of (scene, changes, seed, tick), in portable arithmetic.

mod cell;
mod dispersion;
mod draw;
mod drift;
mod energy;
mod era;
mod foam_step;
mod foam_threshold;
mod layout;
mod measured;
mod modes;
mod noise;
mod octave;
mod phase;
mod rest_position;
mod shoaling;
mod spectrum;
mod spreading;
mod stages;
mod statistics;
mod strain;
mod system;
mod table;
mod timeline;
mod trochoid;
mod turbulence;
mod warnings;
mod wavenumber;

pub use dispersion::Dispersion;
pub use drift::Drift;
pub use energy::{Jonswap, OchiHubble};
pub use era::Life;
pub use foam_step::HeldFoam;
pub use foam_threshold::FoamThresholds;
pub use layout::{Cascade, Layout};
pub use measured::{Clipping, MeasuredSea};
pub use modes::{CascadeModes, Mode, Sea};
pub use noise::{gaussian_pair, log_normal_pair};
pub use octave::{OCTAVE_CENTRE, OCTAVE_VARIANCE, Octave, kernel_energies, lattice_direction};
pub use phase::{cos_sin, cos_sin_q24, cycles_per_repeat, turn_of_tick};
pub use rest_position::{Displacement, RestPosition, rest_position, rest_position_within};
pub use shoaling::{kitaigorodskii, thompson_vincent};
pub use spectrum::Spectrum;
pub use spreading::{Spreader, cos2s, donelan_banner_beta, hasselmann_s, horvath_swell_s, mitsuyasu_s};
pub use statistics::{FREQUENCY_BIN, Statistics};
pub use strain::Strain;
pub use table::EnergyTable;
pub use timeline::{MAX_OVERLAPPING, Timeline};
pub use trochoid::{TrochoidWave, kept_waves, orbit, trochoid_settings};
pub use turbulence::turbulence;
pub use wavenumber::{Elfouhaily, Phillips};
