//! What is asked for: a scene, checked once, so that everything behind it can trust its numbers.
//!
//! A [`SceneFile`] is what people write (TOML) or send (JSON); [`Scene`] is what it means. Every error names the
//! field, the value and its bound. Invariant: this room computes no spectrum and knows no transform.

mod amplitudes;
mod bound;
mod change;
mod effects;
mod fade;
mod file;
mod foam;
mod measured;
mod model;
mod ndbc;
mod preset;
mod promise;
mod replay;
mod sea_state;
mod spreading;
mod surface;
mod swell;
mod water;
mod wind;

pub use amplitudes::{Amplitudes, Distribution};
pub use bound::SceneError;
pub use change::{Change, ChangeKind, MAX_TRANSITION_TICKS};
pub use effects::{Detail, Effects, Normals};
pub use fade::{CrossFade, KEEP_TICKS};
pub use file::{CascadesFile, EffectsFile, MeasuredFile, ReplayFile, SceneFile, TrochoidFile, WaterFile, WindFile};
pub use foam::Foam;
pub use measured::{DirectionMethod, MeasuredBin, MeasuredSpectrum, Spread};
pub use model::{Model, Trochoid};
pub use ndbc::{NdbcError, NdbcStation};
pub use preset::{PRESETS, preset};
pub use promise::{Promise, WMO_UPPER_HS_M, wmo_sea_state};
pub use replay::Replay;
pub use sea_state::SeaState;
pub use spreading::{Spreading, SpreadingForm};
pub use surface::{CascadeRequest, Patch, Repeat};
pub use swell::{Swell, SwellModel};
pub use water::{DispersionLaw, Water};
pub use wind::{DepthCorrection, WindModel, WindSea};

use crate::wire::Group;

/// Everything that, with a seed and a tick, decides the sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Short name, `a-z 0-9 -`, used in URLs.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// Decides the random draw of every wave.
    pub seed: u64,
    /// What it promises of its sea.
    pub promise: Option<Promise>,
    /// How the amplitudes of single waves scatter.
    pub amplitudes: Amplitudes,
    /// The spectra to begin with.
    pub sea: SeaState,
    /// Measured records that follow the first.
    pub replay: Option<Replay>,
    /// Wind speeds (m/s) the layout of cascades must serve; `None` where no wind drives the sea.
    pub wind_range_mps: Option<[f64; 2]>,
    /// How the sea is cut into cascades.
    pub cascades: CascadeRequest,
    /// What its modes are summed by.
    pub model: Model,
    /// What is computed.
    pub effects: Effects,
    /// How fine and how often it can be had, where not as fine and often as any.
    pub detail: Vec<Detail>,
    /// After how long the sea repeats exactly.
    pub repeat: Repeat,
}

impl Scene {
    /// The limit on a group of the cascade with this number, which has so many levels, where there is one.
    pub fn detail_of(&self, number: u8, levels: u8, group: Group) -> Option<Detail> {
        let place = number % CascadeRequest::MAX_PATCHES as u8;
        let detail = self.detail.iter().find(|detail| (detail.cascade, detail.group) == (place, group))?;
        // A cascade of few levels can be had at its coarsest.
        Some(Detail { finest_level: detail.finest_level.min(levels.saturating_sub(1)), ..*detail })
    }
}
