//! How the amplitudes of single waves scatter around their energy.

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};

/// Laws of the scatter; all have the same mean energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// Both components normal: what a sum of many independent wave groups has.
    #[default]
    Gaussian,
    /// Logarithm of the amplitude normal: a few strong waves among many weak ones.
    LogNormal,
}

/// The law and its setting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Amplitudes {
    /// The law.
    pub distribution: Distribution,
    /// Standard deviation of the logarithm of the amplitude, for `LogNormal`.
    pub sigma: f64,
}

impl Default for Amplitudes {
    fn default() -> Self {
        Self { distribution: Distribution::Gaussian, sigma: 0.5 }
    }
}

impl Amplitudes {
    /// Checks the setting.
    ///
    /// # Errors
    /// [`SceneError::Bound`] when it is out of bounds.
    pub fn check(self) -> Result<Self, SceneError> {
        Ok(Self { sigma: within("amplitudes.sigma", self.sigma, 0.0, 1.5)?, ..self })
    }
}
