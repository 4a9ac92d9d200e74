//! What a scene promises of its sea, so that a reader of the file knows and a test can hold it to that.

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};

/// Upper bounds of the significant wave height, metres, for the sea states 0 to 8 of WMO code 3700.
pub const WMO_UPPER_HS_M: [f64; 9] = [0.0, 0.1, 0.5, 1.25, 2.5, 4.0, 6.0, 9.0, 14.0];

/// A promise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Promise {
    /// Significant wave height, metres, within 2 %.
    pub hs_m: f64,
    /// Sea state by WMO code 3700, 0 to 9.
    pub sea_state: u8,
}

impl Promise {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`SceneError::Bound`] when one is out of bounds.
    pub fn check(self) -> Result<Self, SceneError> {
        if self.sea_state > 9 {
            return Err(SceneError::bound("promise.sea_state", self.sea_state, "a whole number from 0 to 9"));
        }
        Ok(Self { hs_m: within("promise.hs_m", self.hs_m, 0.0, 100.0)?, ..self })
    }
}

/// Sea state by WMO code 3700 of a significant wave height in metres.
pub fn wmo_sea_state(hs_m: f64) -> u8 {
    WMO_UPPER_HS_M.iter().position(|upper| hs_m <= *upper).unwrap_or(9) as u8
}
