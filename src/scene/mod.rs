//! What is asked for: a scene, checked once, so that everything behind it can trust its numbers.
//!
//! A [`SceneFile`] is what people write (TOML) or send (JSON); [`Scene`] is what it means. Every error names the
//! field, the value and its bound. Invariant: this room computes no spectrum and knows no transform.

mod bound;
mod change;
mod fade;
mod file;
mod foam;
mod measured;
mod ndbc;
mod preset;
mod sea_state;
mod surface;
mod write;

pub use bound::SceneError;
pub use change::{Change, ChangeKind, MAX_TRANSITION_TICKS};
pub use fade::{CrossFade, KEEP_TICKS};
pub use file::{CascadesFile, SceneFile};
pub use foam::Foam;
pub use measured::{MeasuredBin, MeasuredSpectrum, Spread};
pub use ndbc::{NdbcError, NdbcStation};
pub use preset::{PRESETS, preset};
pub use sea_state::{SeaState, Swell, Water, WindSea};
pub use surface::{CascadeRequest, Effects, Patch, Repeat};

/// Everything that, with a seed and a tick, decides the sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Short name, `a-z 0-9 -`, used in URLs.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// Decides the random draw of every wave.
    pub seed: u64,
    /// The spectra to begin with.
    pub sea: SeaState,
    /// Wind speeds (m/s) the layout of cascades must serve; `None` where no wind drives the sea.
    pub wind_range_mps: Option<[f64; 2]>,
    /// How the sea is cut into cascades.
    pub cascades: CascadeRequest,
    /// What is computed.
    pub effects: Effects,
    /// After how long the sea repeats exactly.
    pub repeat: Repeat,
}
