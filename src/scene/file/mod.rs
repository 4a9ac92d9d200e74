//! The form of a scene that people write (TOML) and send (JSON), and the check that makes it a [`Scene`].

mod cascades;
mod effects;
mod measured;
mod write;

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};
use super::{
    Amplitudes, DepthCorrection, Detail, DispersionLaw, Promise, Repeat, Scene, SeaState, Spreading, SpreadingForm,
    Swell, Water, WindModel, WindSea,
};
use effects::ModelName;

pub use cascades::CascadesFile;
pub use effects::{EffectsFile, TrochoidFile};
pub use measured::{MeasuredFile, ReplayFile};

/// Most systems given by height and period.
const MAX_SWELLS: usize = 16;
/// Largest scene file.
const MAX_BYTES: usize = 1 << 20;

/// A scene as written. Every field has its default in `Default`; unknown fields are errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)] // Each field means what the field of the same name in `Scene` means.
pub struct SceneFile {
    pub name: String,
    pub title: String,
    pub seed: u64,
    pub model: ModelName,
    /// Length in seconds of a loop that closes exactly; absent: the sea repeats after 6.9 days.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub promise: Option<Promise>,
    pub amplitudes: Amplitudes,
    pub water: WaterFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind: Option<WindFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub swell: Vec<Swell>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<MeasuredFile>,
    pub cascades: CascadesFile,
    pub trochoid: TrochoidFile,
    pub effects: EffectsFile,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub detail: Vec<Detail>,
}

/// `[water]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct WaterFile {
    /// Absent: infinitely deep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_m: Option<f64>,
    pub gravity: f64,
    pub surface_tension: f64,
    pub density: f64,
    pub dispersion: DispersionLaw,
}

/// `[wind]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct WindFile {
    pub model: WindModel,
    pub speed_mps: f64,
    pub direction_from_deg: f64,
    pub fetch_m: f64,
    pub gamma: f64,
    pub alpha: f64,
    pub small_wave_m: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hs_m: Option<f64>,
    pub depth_correction: DepthCorrection,
    /// Absent: Hasselmann's, and cos^2 for Phillips' spectrum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spreading: Option<Spreading>,
    pub swell: f64,
    /// Speeds the layout must serve, and within which the wind can be set while the scene runs.
    pub range_mps: [f64; 2],
}

impl Default for SceneFile {
    fn default() -> Self {
        Self {
            name: "sea".to_owned(),
            title: String::new(),
            seed: 1,
            loop_s: None,
            promise: None,
            amplitudes: Amplitudes::default(),
            water: WaterFile::default(),
            wind: None,
            swell: Vec::new(),
            measured: None,
            cascades: CascadesFile::default(),
            model: ModelName::default(),
            trochoid: TrochoidFile::default(),
            effects: EffectsFile::default(),
            detail: Vec::new(),
        }
    }
}

impl Default for WaterFile {
    fn default() -> Self {
        let water = Water::default();
        Self {
            depth_m: None,
            gravity: water.gravity,
            surface_tension: water.surface_tension,
            density: water.density,
            dispersion: water.dispersion,
        }
    }
}

impl Default for WindFile {
    fn default() -> Self {
        let wind = WindSea::jonswap(9.3, 270.0, 300e3);
        Self {
            model: wind.model,
            speed_mps: wind.speed_mps,
            direction_from_deg: wind.direction_from_deg,
            fetch_m: wind.fetch_m,
            gamma: wind.gamma,
            alpha: wind.alpha,
            small_wave_m: wind.small_wave_m,
            hs_m: wind.hs_m,
            depth_correction: wind.depth_correction,
            spreading: None,
            swell: wind.swell,
            range_mps: [2.0, 20.0],
        }
    }
}

impl SceneFile {
    /// Reads TOML.
    ///
    /// # Errors
    /// [`SceneError::Form`] with the place and the reason.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        if text.len() > MAX_BYTES {
            return Err(SceneError::Form(format!("{} bytes, must be at most {MAX_BYTES}", text.len())));
        }
        toml::from_str(text).map_err(|e| SceneError::Form(e.to_string()))
    }

    /// Checks every number. `base` is the folder that `measured.directory` is relative to; without it no file of
    /// the system is read.
    ///
    /// # Errors
    /// [`SceneError`] for the first field out of bounds.
    pub fn check(self, base: Option<&Path>) -> Result<Scene, SceneError> {
        let name_ok = !self.name.is_empty()
            && self.name.len() <= 64
            && self.name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-');
        if !name_ok {
            return Err(SceneError::bound("name", format!("{:?}", self.name), "1 to 64 of a-z, 0-9 and -"));
        }
        if self.title.len() > 256 {
            return Err(SceneError::bound("title", format!("{} bytes", self.title.len()), "at most 256 bytes"));
        }
        if self.swell.len() > MAX_SWELLS {
            let bound = format!("at most {MAX_SWELLS}");
            return Err(SceneError::bound("swell", format!("{} systems", self.swell.len()), bound));
        }
        let wind_range_mps = self.wind.as_ref().map(WindFile::range).transpose()?;
        let (measured, replay) = self.measured.map(|m| m.check(base)).transpose()?.unzip();
        let sea = SeaState {
            water: self.water.check()?,
            wind: self.wind.as_ref().map(WindFile::check).transpose()?,
            swells: self.swell.into_iter().enumerate().map(|(i, swell)| swell.check(i)).collect::<Result<_, _>>()?,
            measured,
        };
        let cascades = self.cascades.check()?;
        if let Some(replay) = replay.as_ref().and_then(Option::as_ref) {
            replay.check_size(&cascades)?;
        }
        Ok(Scene {
            name: self.name,
            title: self.title,
            seed: self.seed,
            promise: self.promise.map(Promise::check).transpose()?,
            amplitudes: self.amplitudes.check()?,
            sea,
            replay: replay.flatten(),
            wind_range_mps,
            cascades,
            model: self.model.check(&self.trochoid)?,
            effects: self.effects.check()?,
            detail: Detail::check(self.detail)?,
            repeat: repeat(self.loop_s)?,
        })
    }
}

fn repeat(loop_s: Option<f64>) -> Result<Repeat, SceneError> {
    let Some(seconds) = loop_s else { return Ok(Repeat::default()) };
    let ticks = within("loop_s", seconds, 1.0, 21600.0)? * 7200.0;
    // 1e-6 of a tick is what rounding a decimal fraction of seconds may lose.
    if (ticks - ticks.round()).abs() > 1e-6 {
        return Err(SceneError::bound("loop_s", seconds, "a whole number of 1/7200 s"));
    }
    Ok(Repeat { ticks: ticks.round() as u64 })
}

impl WaterFile {
    fn check(&self) -> Result<Water, SceneError> {
        let depth_m = self.depth_m.unwrap_or(f64::INFINITY);
        let Self { gravity, surface_tension, density, dispersion, .. } = *self;
        Water { depth_m, gravity, surface_tension, density, dispersion }.check()
    }
}

impl WindFile {
    fn range(&self) -> Result<[f64; 2], SceneError> {
        WindSea::check_range("wind.range_mps", self.range_mps)
    }

    fn check(&self) -> Result<WindSea, SceneError> {
        let [low, high] = self.range()?;
        let own = match self.model {
            WindModel::Phillips => Spreading { form: SpreadingForm::Cos2, ..Spreading::default() },
            _ => Spreading::default(),
        };
        WindSea::check_speed("wind.speed_mps", self.speed_mps)?;
        WindSea {
            model: self.model,
            speed_mps: within("wind.speed_mps", self.speed_mps, low, high)?,
            direction_from_deg: self.direction_from_deg,
            fetch_m: self.fetch_m,
            gamma: self.gamma,
            alpha: self.alpha,
            small_wave_m: self.small_wave_m,
            hs_m: self.hs_m,
            depth_correction: self.depth_correction,
            spreading: self.spreading.unwrap_or(own),
            swell: self.swell,
        }
        .check()
    }
}
