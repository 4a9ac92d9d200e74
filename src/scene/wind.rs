//! A sea raised by local wind, as a scene says it.

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};
use super::spreading::Spreading;

/// Spectra of a wind sea.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WindModel {
    /// Hasselmann et al. (1973): grows with fetch until it is fully developed.
    #[default]
    Jonswap,
    /// Pierson & Moskowitz (1964), fully developed, fp = 0.13 g / U10 (Thon et al. 2000).
    PiersonMoskowitzU10,
    /// Pierson & Moskowitz (1964), fully developed, wp = 0.877 g / U19.5.
    PiersonMoskowitzU19,
    /// Elfouhaily et al. (1997): gravity to capillary waves in one.
    Elfouhaily,
    /// Phillips' equilibrium range as Tessendorf (2001) cuts it.
    Phillips,
}

impl WindModel {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Jonswap, Self::PiersonMoskowitzU10, Self::PiersonMoskowitzU19, Self::Elfouhaily, Self::Phillips];
}

/// What shallow water does to a wind sea.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DepthCorrection {
    /// Nothing: the spectrum of deep water at any depth.
    None,
    /// Kitaigorodskii et al. (1975), exact; with JONSWAP this is TMA (Bouws et al. 1985).
    #[default]
    Kitaigorodskii,
    /// The parabolas of Thompson & Vincent (1983), within 4 % of the exact form.
    ThompsonVincent,
}

/// A sea raised by local wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindSea {
    /// The spectrum.
    pub model: WindModel,
    /// Wind 10 m above the water, m/s.
    pub speed_mps: f64,
    /// Where the wind comes from, degrees clockwise from north, in [0, 360).
    pub direction_from_deg: f64,
    /// Distance over which the wind has blown, metres (JONSWAP, Elfouhaily). Growth ends when the sea is developed.
    pub fetch_m: f64,
    /// Peak enhancement (JONSWAP).
    pub gamma: f64,
    /// Phillips' constant (Phillips): Tessendorf's A is this over pi with `Cos2`.
    pub alpha: f64,
    /// Waves this short and shorter are damped by exp(-k^2 l^2) (Phillips), metres; 0 for none.
    pub small_wave_m: f64,
    /// Significant height that the sea is scaled to at any wind, metres; `None`: what the model says.
    pub hs_m: Option<f64>,
    /// What shallow water does.
    pub depth_correction: DepthCorrection,
    /// Spreading over directions.
    pub spreading: Spreading,
    /// Horvath's elongation: 0 a wind sea, 1 long-crested.
    pub swell: f64,
}

impl WindSea {
    /// A JONSWAP sea with Hasselmann's spreading.
    pub fn jonswap(speed_mps: f64, direction_from_deg: f64, fetch_m: f64) -> Self {
        Self {
            model: WindModel::Jonswap,
            speed_mps,
            direction_from_deg,
            fetch_m,
            gamma: 3.3,
            alpha: 8.1e-3,
            small_wave_m: 0.0,
            hs_m: None,
            depth_correction: DepthCorrection::Kitaigorodskii,
            spreading: Spreading::default(),
            swell: 0.0,
        }
    }

    /// Checks every number but the speed, which has its own range.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for the first out of bounds.
    pub fn check(self) -> Result<Self, SceneError> {
        Ok(Self {
            direction_from_deg: Self::check_direction("wind.direction_from_deg", self.direction_from_deg)?,
            fetch_m: within("wind.fetch_m", self.fetch_m, 0.0, 1e7)?,
            gamma: within("wind.gamma", self.gamma, 1.0, 20.0)?,
            alpha: within("wind.alpha", self.alpha, 0.0, 1.0)?,
            small_wave_m: within("wind.small_wave_m", self.small_wave_m, 0.0, 1e4)?,
            hs_m: self.hs_m.map(|hs| within("wind.hs_m", hs, 0.0, 30.0)).transpose()?,
            spreading: self.spreading.check("wind.spreading")?,
            swell: within("wind.swell", self.swell, 0.0, 1.0)?,
            ..self
        })
    }

    /// Checks a wind speed against the widest bounds of any scene.
    ///
    /// # Errors
    /// [`SceneError::Bound`] outside 0 to 100 m/s.
    pub fn check_speed(field: &str, speed_mps: f64) -> Result<f64, SceneError> {
        within(field, speed_mps, 0.0, 100.0)
    }

    /// Checks a range of wind speeds: from 0 to 100 m/s, the upper end not below the lower and at least 0.1.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for the end that is out of bounds.
    pub fn check_range(field: &str, [low, high]: [f64; 2]) -> Result<[f64; 2], SceneError> {
        let low = within(field, low, 0.0, 100.0)?;
        Ok([low, within(field, high, low.max(0.1), 100.0)?])
    }

    /// Checks a direction and brings it into [0, 360).
    ///
    /// # Errors
    /// [`SceneError::Bound`] unless the number is from -3600 to 3600.
    pub fn check_direction(field: &str, degrees: f64) -> Result<f64, SceneError> {
        let turned = within(field, degrees, -3600.0, 3600.0)?.rem_euclid(360.0);
        // A tiny negative angle rounds up to the full turn.
        Ok(if turned >= 360.0 { 0.0 } else { turned })
    }
}
