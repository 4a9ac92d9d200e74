//! `[cascades]` of a scene file: how the sea is cut into patches, or what an automatic cut must hold.

use serde::{Deserialize, Serialize};

use crate::scene::bound::{SceneError, within};
use crate::scene::{CascadeRequest, Patch};

/// `[cascades]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct CascadesFile {
    /// Samples a side; absent: 256, and another where an automatic layout is better served.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub n: Option<usize>,
    /// End of each band, as a share of its patch's Nyquist wavenumber.
    pub band_limit: f64,
    /// Shortest wave an automatic layout must hold.
    pub finest_wavelength_m: f64,
    /// Patch sides in metres, longest first; empty: automatic.
    pub patches_m: Vec<f64>,
}

impl Default for CascadesFile {
    fn default() -> Self {
        Self { n: None, band_limit: 1.0 / 3.0, finest_wavelength_m: 0.3, patches_m: Vec::new() }
    }
}

impl CascadesFile {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for the first out of bounds.
    pub fn check(&self) -> Result<CascadeRequest, SceneError> {
        if let Some(n) = self.n.filter(|n| !(16..=2048).contains(n) || !n.is_power_of_two()) {
            return Err(SceneError::bound("cascades.n", n, "a power of two from 16 to 2048"));
        }
        if self.patches_m.len() > CascadeRequest::MAX_PATCHES {
            let value = format!("{} patches", self.patches_m.len());
            let bound = format!("at most {}", CascadeRequest::MAX_PATCHES);
            return Err(SceneError::bound("cascades.patches_m", value, bound));
        }
        let n = self.n.unwrap_or(CascadeRequest::USUAL_N);
        let band_limit = within("cascades.band_limit", self.band_limit, 0.1, 1.0)?;
        // An automatic layout may need as many patches as one chosen by hand may have.
        let patches = if self.patches_m.is_empty() { CascadeRequest::MAX_PATCHES } else { self.patches_m.len() };
        let modes = patches as f64 * CascadeRequest::modes(n, band_limit);
        if modes > CascadeRequest::MAX_MODES {
            let value = format!("{n} with band_limit {band_limit} and up to {patches} patches, {modes:.0} modes");
            let bound = format!("small enough for {:.0} modes", CascadeRequest::MAX_MODES);
            return Err(SceneError::bound("cascades.n", value, bound));
        }
        let samples = patches.saturating_mul(n * n);
        if samples > CascadeRequest::MAX_SAMPLES {
            let value = format!("{n} with up to {patches} patches, {samples} samples");
            let bound = format!("small enough for {} samples", CascadeRequest::MAX_SAMPLES);
            return Err(SceneError::bound("cascades.n", value, bound));
        }
        if self.patches_m.is_empty() {
            let finest_wavelength_m = within("cascades.finest_wavelength_m", self.finest_wavelength_m, 1e-3, 1e4)?;
            return Ok(CascadeRequest::Automatic { n: self.n, band_limit, finest_wavelength_m });
        }
        let mut patches = Vec::new();
        let (mut shortest, mut longest) = (0.1, 1e5);
        for &length in &self.patches_m {
            let length_m = within("cascades.patches_m", length, shortest, longest)?;
            // A shorter patch must hold shorter waves than the one before, and begin where that one ends: its first
            // mode must not lie beyond the other's band.
            longest = length_m * 0.75;
            shortest = (length_m * 2.0 / (band_limit * n as f64)).max(0.1);
            patches.push(Patch { length_m, n });
        }
        Ok(CascadeRequest::Chosen { patches, band_limit })
    }
}
