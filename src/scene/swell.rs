//! Waves given by their height and period: swell, or the parts of a sea with several peaks.

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};
use super::spreading::Spreading;
use super::wind::WindSea;

/// Spectra by height and period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SwellModel {
    /// JONSWAP's form, normalised so that the height is exact.
    #[default]
    Jonswap,
    /// One of the peaks of Ochi & Hubble (1976); two of them make their six-parameter spectrum.
    OchiHubble,
}

/// A system of known height and period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Swell {
    /// The spectrum.
    pub model: SwellModel,
    /// Significant wave height, metres; kept exactly.
    pub hs_m: f64,
    /// Peak period, seconds.
    pub tp_s: f64,
    /// Where it comes from, degrees clockwise from north, in [0, 360).
    pub direction_from_deg: f64,
    /// Peak enhancement (JONSWAP).
    pub gamma: f64,
    /// Shape (Ochi-Hubble): 1 is Pierson-Moskowitz, more is narrower.
    pub lambda: f64,
    /// Spreading over directions. Forms that follow the age of the waves take them as fully developed.
    pub spreading: Spreading,
    /// Horvath's elongation: 0 none, 1 long-crested.
    pub swell: f64,
}

impl Default for Swell {
    fn default() -> Self {
        Self {
            model: SwellModel::Jonswap,
            hs_m: 1.0,
            tp_s: 10.0,
            direction_from_deg: 270.0,
            gamma: 5.0,
            lambda: 3.0,
            spreading: Spreading::cos2s(25.0),
            swell: 0.0,
        }
    }
}

impl Swell {
    /// Checks every number; `index` is its place in the scene file.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for the first out of bounds.
    pub fn check(self, index: usize) -> Result<Self, SceneError> {
        let field = |name: &str| format!("swell[{index}].{name}");
        Ok(Self {
            model: self.model,
            hs_m: within(&field("hs_m"), self.hs_m, 0.0, 30.0)?,
            tp_s: within(&field("tp_s"), self.tp_s, 0.5, 30.0)?,
            direction_from_deg: WindSea::check_direction(&field("direction_from_deg"), self.direction_from_deg)?,
            gamma: within(&field("gamma"), self.gamma, 1.0, 20.0)?,
            lambda: within(&field("lambda"), self.lambda, 0.5, 20.0)?,
            spreading: self.spreading.check(&field("spreading"))?,
            swell: within(&field("swell"), self.swell, 0.0, 1.0)?,
        })
    }
}
