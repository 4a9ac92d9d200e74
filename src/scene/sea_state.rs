//! Everything that raises the sea: the water and the wave systems that it carries.

use super::measured::MeasuredSpectrum;
use super::swell::Swell;
use super::water::Water;
use super::wind::WindSea;

/// Every system of a sea; they add in energy.
#[derive(Clone, Debug, PartialEq)]
pub struct SeaState {
    /// The water body.
    pub water: Water,
    /// The local wind sea.
    pub wind: Option<WindSea>,
    /// Swells, and other systems given by height and period.
    pub swells: Vec<Swell>,
    /// A measured directional spectrum.
    pub measured: Option<MeasuredSpectrum>,
}
