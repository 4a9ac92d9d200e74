//! `[effects]`, `model` and `[trochoid]` of a scene file: what is computed, and by which model.

use serde::{Deserialize, Serialize};

use crate::scene::bound::{SceneError, within};
use crate::scene::{Effects, Foam, Model, Normals, Trochoid};

/// `[effects]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct EffectsFile {
    pub choppiness: f64,
    pub slopes: bool,
    pub normals: Normals,
    pub jacobian: bool,
    pub velocity: bool,
    pub foam: bool,
    pub foam_growth_s: f64,
    pub foam_decay_s: f64,
    pub foam_gain: f64,
}

/// `model`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModelName {
    /// [`Model::Fft`].
    #[default]
    Fft,
    /// [`Model::Trochoid`].
    Trochoid,
}

/// `[trochoid]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct TrochoidFile {
    pub grid: usize,
    pub components: usize,
    pub turbulence: bool,
}

impl Default for EffectsFile {
    fn default() -> Self {
        Self::from(&Effects::default())
    }
}

impl Default for TrochoidFile {
    fn default() -> Self {
        Self::from(Trochoid::default())
    }
}

impl From<Trochoid> for TrochoidFile {
    fn from(Trochoid { grid, components, turbulence }: Trochoid) -> Self {
        Self { grid, components, turbulence }
    }
}

impl EffectsFile {
    pub(super) fn check(&self) -> Result<Effects, SceneError> {
        let foam = Foam { growth_s: self.foam_growth_s, decay_s: self.foam_decay_s, gain: self.foam_gain }.check()?;
        Effects {
            choppiness: within("effects.choppiness", self.choppiness, 0.0, 5.0)?,
            slopes: self.slopes,
            normals: self.normals,
            jacobian: self.jacobian,
            velocity: self.velocity,
            foam: self.foam.then_some(foam),
        }
        .check()
    }
}

impl From<&Effects> for EffectsFile {
    fn from(effects: &Effects) -> Self {
        let foam = effects.foam.unwrap_or_default();
        Self {
            choppiness: effects.choppiness,
            slopes: effects.slopes,
            normals: effects.normals,
            jacobian: effects.jacobian,
            velocity: effects.velocity,
            foam: effects.foam.is_some(),
            foam_growth_s: foam.growth_s,
            foam_decay_s: foam.decay_s,
            foam_gain: foam.gain,
        }
    }
}

impl ModelName {
    /// The model of this name; `[trochoid]` is checked whichever it is.
    pub(super) fn check(self, trochoid: &TrochoidFile) -> Result<Model, SceneError> {
        let TrochoidFile { grid, components, turbulence } = *trochoid;
        let trochoid = Trochoid { grid, components, turbulence }.check()?;
        Ok(match self {
            Self::Fft => Model::Fft,
            Self::Trochoid => Model::Trochoid(trochoid),
        })
    }
}
