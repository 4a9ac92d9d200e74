//! The water body: how deep it is and what pulls it flat.

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};

/// The water body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Depth in metres; infinity for the open ocean.
    pub depth_m: f64,
    /// Gravity, m/s^2.
    pub gravity: f64,
    /// Surface tension, N/m.
    pub surface_tension: f64,
    /// Density, kg/m^3.
    pub density: f64,
    /// Which of these the waves feel.
    pub dispersion: DispersionLaw,
}

/// How the frequency of a wave follows from its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DispersionLaw {
    /// w^2 = g k: neither bottom nor tension is felt.
    Deep,
    /// w^2 = g k tanh(k d).
    Finite,
    /// w^2 = (g k + (sigma / rho) k^3) tanh(k d).
    #[default]
    Capillary,
}

impl Default for Water {
    fn default() -> Self {
        Self {
            depth_m: f64::INFINITY,
            gravity: 9.81,
            surface_tension: 0.0748,
            density: 1025.0,
            dispersion: DispersionLaw::Capillary,
        }
    }
}

impl Water {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for the first out of bounds.
    pub fn check(self) -> Result<Self, SceneError> {
        Ok(Self {
            depth_m: Self::check_depth("water.depth_m", self.depth_m)?,
            gravity: Self::check_gravity("water.gravity", self.gravity)?,
            surface_tension: within("water.surface_tension", self.surface_tension, 0.0, 1.0)?,
            density: within("water.density", self.density, 100.0, 20_000.0)?,
            dispersion: self.dispersion,
        })
    }

    /// Checks a depth: 1 mm to infinity.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for anything else.
    pub fn check_depth(field: &str, depth_m: f64) -> Result<f64, SceneError> {
        within(field, depth_m, 1e-3, f64::INFINITY)
    }

    /// Checks gravity: 0.1 to 100 m/s^2.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for anything else.
    pub fn check_gravity(field: &str, gravity: f64) -> Result<f64, SceneError> {
        within(field, gravity, 0.1, 100.0)
    }
}
