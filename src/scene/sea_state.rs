//! The wave systems and the water that carry them.

use super::bound::{SceneError, within};
use super::measured::MeasuredSpectrum;

/// The water body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Depth in metres; infinity for the open ocean.
    pub depth_m: f64,
    /// Gravity, m/s^2.
    pub gravity: f64,
    /// Surface tension over density, m^3/s^2.
    pub tension: f64,
}

impl Default for Water {
    fn default() -> Self {
        Self { depth_m: f64::INFINITY, gravity: 9.81, tension: 7.3e-5 }
    }
}

impl Water {
    /// Checks a depth: 1 mm to infinity.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for anything else.
    pub fn check_depth(field: &str, depth_m: f64) -> Result<f64, SceneError> {
        within(field, depth_m, 1e-3, f64::INFINITY)
    }
}

/// A sea raised by local wind: JONSWAP with TMA depth correction, Hasselmann's spreading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindSea {
    /// Wind 10 m above the water, m/s.
    pub speed_mps: f64,
    /// Where the wind comes from, degrees clockwise from north, in [0, 360).
    pub direction_from_deg: f64,
    /// Distance over which the wind has blown, metres. Growth ends when the sea is fully developed.
    pub fetch_m: f64,
    /// Peak enhancement.
    pub gamma: f64,
    /// Horvath's elongation: 0 a wind sea, 1 long-crested.
    pub swell: f64,
}

impl WindSea {
    /// Checks a wind speed against the widest bounds of any scene.
    ///
    /// # Errors
    /// [`SceneError::Bound`] outside 0 to 100 m/s.
    pub fn check_speed(field: &str, speed_mps: f64) -> Result<f64, SceneError> {
        within(field, speed_mps, 0.0, 100.0)
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

/// Waves from far away: JONSWAP by height and period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swell {
    /// Significant wave height, metres; kept exactly.
    pub hs_m: f64,
    /// Peak period, seconds.
    pub tp_s: f64,
    /// Where it comes from, degrees clockwise from north, in [0, 360).
    pub direction_from_deg: f64,
    /// Peak enhancement.
    pub gamma: f64,
    /// Exponent s of the cos^2s spreading.
    pub spread_s: f64,
}

/// Every system of a sea; they add in energy.
#[derive(Clone, Debug, PartialEq)]
pub struct SeaState {
    /// The water body.
    pub water: Water,
    /// The local wind sea.
    pub wind: Option<WindSea>,
    /// Swells.
    pub swells: Vec<Swell>,
    /// A measured directional spectrum.
    pub measured: Option<MeasuredSpectrum>,
}
