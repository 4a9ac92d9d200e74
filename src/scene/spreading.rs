//! How a system's waves are spread over directions, as a scene says it.

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};

/// Forms of the spreading function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpreadingForm {
    /// The same in every direction.
    Uniform,
    /// cos^2 of the angle, and a share of it against the wind.
    Cos2,
    /// cos^2s of half the angle, s fixed.
    Cos2s,
    /// cos^2s with s by Mitsuyasu et al. (1975).
    Mitsuyasu,
    /// cos^2s with s by Hasselmann et al. (1980).
    Hasselmann,
    /// sech^2 by Donelan et al. (1985) and Banner (1990).
    DonelanBanner,
}

impl SpreadingForm {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Uniform, Self::Cos2, Self::Cos2s, Self::Mitsuyasu, Self::Hasselmann, Self::DonelanBanner];
}

/// A form and its settings; the default is Hasselmann's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spreading {
    /// The form; without one the other settings would belong to none.
    pub form: SpreadingForm,
    /// Exponent s where it is fixed.
    #[serde(default = "usual_s")]
    pub s: f64,
    /// Energy of a wave that runs against the wind over that of one that runs with it: 0 to 1, for `Cos2`.
    #[serde(default)]
    pub against_wind: f64,
    /// Share of the second form in the whole, 0 to 1.
    #[serde(default)]
    pub blend: f64,
    /// The second form, with the same settings.
    #[serde(default = "usual_with")]
    pub with: SpreadingForm,
}

fn usual_s() -> f64 {
    10.0
}

fn usual_with() -> SpreadingForm {
    SpreadingForm::Uniform
}

impl Default for Spreading {
    fn default() -> Self {
        Self { form: SpreadingForm::Hasselmann, s: 10.0, against_wind: 0.0, blend: 0.0, with: SpreadingForm::Uniform }
    }
}

impl Spreading {
    /// cos^2s with a fixed exponent.
    pub fn cos2s(s: f64) -> Self {
        Self { form: SpreadingForm::Cos2s, s, ..Self::default() }
    }

    /// Checks the settings; `field` is where they stand in the scene file.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for the first out of bounds.
    pub fn check(self, field: &str) -> Result<Self, SceneError> {
        Ok(Self {
            s: within(&format!("{field}.s"), self.s, 0.0, 1000.0)?,
            against_wind: within(&format!("{field}.against_wind"), self.against_wind, 0.0, 1.0)?,
            blend: within(&format!("{field}.blend"), self.blend, 0.0, 1.0)?,
            ..self
        })
    }
}
