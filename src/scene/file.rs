//! The form of a scene that people write (TOML) and send (JSON), and the check that makes it a [`Scene`].

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};
use super::{
    CascadeRequest, Effects, Foam, MeasuredBin, MeasuredSpectrum, NdbcStation, Patch, Repeat, Scene, SeaState, Spread,
    Swell, Water, WindSea,
};

/// Most patches of a layout.
const MAX_PATCHES: usize = 8;
/// Most modes of a layout: about half a gigabyte of tables.
const MAX_MODES: f64 = 5e6;
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
    /// Length in seconds of a loop that closes exactly; absent: the sea repeats after 6.9 days.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_s: Option<f64>,
    pub water: WaterFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind: Option<WindFile>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub swell: Vec<SwellFile>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<MeasuredFile>,
    pub cascades: CascadesFile,
    pub effects: EffectsFile,
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
    pub tension: f64,
}

/// `[wind]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct WindFile {
    pub speed_mps: f64,
    pub direction_from_deg: f64,
    pub fetch_m: f64,
    pub gamma: f64,
    pub swell: f64,
    /// Speeds the layout must serve, and within which the wind can be set while the scene runs.
    pub range_mps: [f64; 2],
}

/// `[[swell]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct SwellFile {
    pub hs_m: f64,
    pub tp_s: f64,
    pub direction_from_deg: f64,
    pub gamma: f64,
    pub spread_s: f64,
}

/// `[measured]`: a record of an NDBC station, or its numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct MeasuredFile {
    /// Station whose files to read; `41010` without a directory is built in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<String>,
    /// Folder of the files, relative to the scene file. Only scene files may name one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<String>,
    /// `YYYY-MM-DDThh:mm` (UTC); absent: the newest record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// In place of a station: rows of frequency (Hz), density (m^2/Hz), and alpha1, alpha2 (degrees), r1, r2, or
    /// the first two numbers alone where the direction is missing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bins: Vec<Vec<f64>>,
}

/// `[cascades]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct CascadesFile {
    /// Samples a side.
    pub n: usize,
    /// End of each band, as a share of its patch's Nyquist wavenumber.
    pub band_limit: f64,
    /// Shortest wave an automatic layout must hold.
    pub finest_wavelength_m: f64,
    /// Patch sides in metres, longest first; empty: automatic.
    pub patches_m: Vec<f64>,
}

/// `[effects]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct EffectsFile {
    pub choppiness: f64,
    pub foam: bool,
    pub foam_decay_s: f64,
    pub foam_gain: f64,
}

impl Default for SceneFile {
    fn default() -> Self {
        Self {
            name: "sea".to_owned(),
            title: String::new(),
            seed: 1,
            loop_s: None,
            water: WaterFile::default(),
            wind: None,
            swell: Vec::new(),
            measured: None,
            cascades: CascadesFile::default(),
            effects: EffectsFile::default(),
        }
    }
}

impl Default for WaterFile {
    fn default() -> Self {
        let water = Water::default();
        Self { depth_m: None, gravity: water.gravity, tension: water.tension }
    }
}

impl Default for WindFile {
    fn default() -> Self {
        Self {
            speed_mps: 9.3,
            direction_from_deg: 270.0,
            fetch_m: 300e3,
            gamma: 3.3,
            swell: 0.0,
            range_mps: [2.0, 20.0],
        }
    }
}

impl Default for SwellFile {
    fn default() -> Self {
        Self { hs_m: 1.0, tp_s: 10.0, direction_from_deg: 270.0, gamma: 5.0, spread_s: 25.0 }
    }
}

impl Default for CascadesFile {
    fn default() -> Self {
        Self { n: 256, band_limit: 1.0 / 3.0, finest_wavelength_m: 0.3, patches_m: Vec::new() }
    }
}

impl Default for EffectsFile {
    fn default() -> Self {
        let foam = Foam::default();
        Self { choppiness: 1.0, foam: true, foam_decay_s: foam.decay_s, foam_gain: foam.gain }
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
        if self.swell.len() > 8 {
            return Err(SceneError::bound("swell", format!("{} systems", self.swell.len()), "at most 8"));
        }
        let wind_range_mps = self.wind.as_ref().map(WindFile::range).transpose()?;
        let sea = SeaState {
            water: self.water.check()?,
            wind: self.wind.as_ref().map(WindFile::check).transpose()?,
            swells: self.swell.iter().enumerate().map(|(i, swell)| swell.check(i)).collect::<Result<_, _>>()?,
            measured: self.measured.as_ref().map(|m| m.check(base)).transpose()?,
        };
        Ok(Scene {
            name: self.name,
            title: self.title,
            seed: self.seed,
            sea,
            wind_range_mps,
            cascades: self.cascades.check()?,
            effects: self.effects.check()?,
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
        Ok(Water {
            depth_m: Water::check_depth("water.depth_m", self.depth_m.unwrap_or(f64::INFINITY))?,
            gravity: within("water.gravity", self.gravity, 0.1, 100.0)?,
            tension: within("water.tension", self.tension, 0.0, 1e-3)?,
        })
    }
}

impl WindFile {
    fn range(&self) -> Result<[f64; 2], SceneError> {
        let low = within("wind.range_mps", self.range_mps[0], 0.0, 100.0)?;
        Ok([low, within("wind.range_mps", self.range_mps[1], low.max(0.1), 100.0)?])
    }

    fn check(&self) -> Result<WindSea, SceneError> {
        let [low, high] = self.range()?;
        WindSea::check_speed("wind.speed_mps", self.speed_mps)?;
        Ok(WindSea {
            speed_mps: within("wind.speed_mps", self.speed_mps, low, high)?,
            direction_from_deg: WindSea::check_direction("wind.direction_from_deg", self.direction_from_deg)?,
            fetch_m: within("wind.fetch_m", self.fetch_m, 0.0, 1e7)?,
            gamma: within("wind.gamma", self.gamma, 1.0, 20.0)?,
            swell: within("wind.swell", self.swell, 0.0, 1.0)?,
        })
    }
}

impl SwellFile {
    fn check(&self, index: usize) -> Result<Swell, SceneError> {
        let field = |name: &str| format!("swell[{index}].{name}");
        Ok(Swell {
            hs_m: within(&field("hs_m"), self.hs_m, 0.0, 30.0)?,
            tp_s: within(&field("tp_s"), self.tp_s, 0.5, 30.0)?,
            direction_from_deg: WindSea::check_direction(&field("direction_from_deg"), self.direction_from_deg)?,
            gamma: within(&field("gamma"), self.gamma, 1.0, 20.0)?,
            spread_s: within(&field("spread_s"), self.spread_s, 0.0, 1000.0)?,
        })
    }
}

impl MeasuredFile {
    fn check(&self, base: Option<&Path>) -> Result<MeasuredSpectrum, SceneError> {
        match (&self.station, &self.directory, self.bins.is_empty()) {
            (None, None, false) => {
                self.bins.iter().map(|row| bin(row)).collect::<Result<Vec<_>, _>>().and_then(MeasuredSpectrum::new)
            }
            (Some(station), Some(directory), true) => {
                let Some(base) = base else {
                    return Err(SceneError::bound(
                        "measured.directory",
                        directory,
                        "absent here: only a scene file may name one",
                    ));
                };
                let plain = station.bytes().all(|b| b.is_ascii_alphanumeric()) && !station.is_empty();
                if !plain {
                    return Err(SceneError::bound("measured.station", format!("{station:?}"), "letters and digits"));
                }
                NdbcStation::read(&base.join(directory), station)?.spectrum(self.time.as_deref())
            }
            (Some(station), None, true) if station == "41010" => NdbcStation::built_in().spectrum(self.time.as_deref()),
            (Some(station), None, true) => {
                Err(SceneError::bound("measured.station", station, "41010, or name a directory"))
            }
            _ => Err(SceneError::bound("measured", "neither or both", "either a station or bins")),
        }
    }
}

fn bin(row: &[f64]) -> Result<MeasuredBin, SceneError> {
    match *row {
        [frequency_hz, density] => Ok(MeasuredBin { frequency_hz, density, direction: None }),
        [frequency_hz, density, alpha1_deg, alpha2_deg, r1, r2] => {
            Ok(MeasuredBin { frequency_hz, density, direction: Some(Spread { alpha1_deg, alpha2_deg, r1, r2 }) })
        }
        _ => Err(SceneError::bound("measured.bins", format!("a row of {}", row.len()), "rows of 2 or 6 numbers")),
    }
}

impl CascadesFile {
    pub(super) fn check(&self) -> Result<CascadeRequest, SceneError> {
        if !(16..=2048).contains(&self.n) || !self.n.is_power_of_two() {
            return Err(SceneError::bound("cascades.n", self.n, "a power of two from 16 to 2048"));
        }
        let band_limit = within("cascades.band_limit", self.band_limit, 0.1, 1.0)?;
        // An automatic layout may need as many patches as one chosen by hand may have.
        let patches = if self.patches_m.is_empty() { MAX_PATCHES } else { self.patches_m.len() };
        let modes = patches as f64 * libm::pow(band_limit * self.n as f64 + 1.0, 2.0);
        if modes > MAX_MODES {
            let value =
                format!("{} with band_limit {band_limit} and up to {patches} patches, {modes:.0} modes", self.n);
            return Err(SceneError::bound("cascades.n", value, format!("small enough for {MAX_MODES:.0} modes")));
        }
        if self.patches_m.is_empty() {
            let finest_wavelength_m = within("cascades.finest_wavelength_m", self.finest_wavelength_m, 1e-3, 1e4)?;
            return Ok(CascadeRequest::Automatic { n: self.n, band_limit, finest_wavelength_m });
        }
        if self.patches_m.len() > MAX_PATCHES {
            return Err(SceneError::bound(
                "cascades.patches_m",
                format!("{} patches", self.patches_m.len()),
                format!("at most {MAX_PATCHES}"),
            ));
        }
        let mut patches = Vec::new();
        let (mut shortest, mut longest) = (0.1, 1e5);
        for &length in &self.patches_m {
            let length_m = within("cascades.patches_m", length, shortest, longest)?;
            // A shorter patch must hold shorter waves than the one before, and begin where that one ends: its first
            // mode must not lie beyond the other's band.
            longest = length_m * 0.75;
            shortest = (length_m * 2.0 / (band_limit * self.n as f64)).max(0.1);
            patches.push(Patch { length_m, n: self.n });
        }
        Ok(CascadeRequest::Chosen { patches, band_limit })
    }
}

impl EffectsFile {
    fn check(&self) -> Result<Effects, SceneError> {
        let foam = Foam { decay_s: self.foam_decay_s, gain: self.foam_gain }.check()?;
        Ok(Effects {
            choppiness: within("effects.choppiness", self.choppiness, 0.0, 5.0)?,
            foam: self.foam.then_some(foam),
        })
    }
}
