//! The JSON body of a change, read into what it asks for; whether the sea can is decided elsewhere.

use serde_json::json;

use super::fields::{Fields, missing};
use super::problem::Problem;
use super::when::When;
use crate::scene::{CascadesFile, ChangeKind};

/// How long the sea takes to follow a change that does not say.
const TRANSITION_S: f64 = 5.0;
/// The same of a change of layout.
const CROSS_FADE_S: f64 = 10.0;

/// What a body asks for. Its numbers are finite and not checked further.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangeBody {
    /// What is to change.
    pub kind: ChangeKind,
    /// When.
    pub when: When,
    /// How long the sea takes to follow.
    pub transition_s: f64,
}

impl ChangeBody {
    /// The body of `PUT /v1/scenes/{name}/wind`.
    ///
    /// # Errors
    /// [`Problem`] naming the first field that is wrong.
    pub fn wind(body: &[u8]) -> Result<Self, Problem> {
        let mut fields = Fields::parse(body)?;
        let speed_mps = fields.required("speed_mps")?;
        let kind = ChangeKind::Wind { speed_mps, direction_from_deg: fields.required("direction_from_deg")? };
        Self::rest(kind, fields, TRANSITION_S)
    }

    /// The body of `PATCH /v1/scenes/{name}/sea`.
    ///
    /// # Errors
    /// [`Problem`] naming the first field that is wrong.
    pub fn sea(body: &[u8]) -> Result<Self, Problem> {
        let mut fields = Fields::parse(body)?;
        let (depth_m, gravity) = (fields.or_infinite("depth_m")?, fields.number("gravity")?);
        if depth_m.is_none() && gravity.is_none() {
            return Err(missing("depth_m or gravity").at("depth_m"));
        }
        Self::rest(ChangeKind::Water { depth_m, gravity }, fields, TRANSITION_S)
    }

    /// The body of `PUT /v1/scenes/{name}/layout`.
    ///
    /// # Errors
    /// [`Problem`] naming the first field that is wrong.
    pub fn layout(body: &[u8]) -> Result<Self, Problem> {
        let mut fields = Fields::parse(body)?;
        let standard = CascadesFile::default();
        let cascades = CascadesFile {
            n: fields.whole("n")?,
            band_limit: fields.number("band_limit")?.unwrap_or(standard.band_limit),
            finest_wavelength_m: fields.number("finest_wavelength_m")?.unwrap_or(standard.finest_wavelength_m),
            patches_m: fields.numbers("patches_m")?.unwrap_or(standard.patches_m),
        };
        let range = fields.numbers("wind_range_mps")?.map(|range| {
            let two = <[f64; 2]>::try_from(range);
            two.map_err(|range| Problem::value("wind_range_mps", json!(range), "two numbers, the least and the most"))
        });
        let kind = ChangeKind::Layout { cascades, wind_range_mps: range.transpose()? };
        Self::rest(kind, fields, CROSS_FADE_S)
    }

    /// Reads what all changes have in common.
    fn rest(kind: ChangeKind, mut fields: Fields, usual_s: f64) -> Result<Self, Problem> {
        let when = match (fields.tick("effective_tick")?, fields.number("in_seconds")?) {
            (None, None) => When::Soon,
            (Some(tick), None) => When::Tick(tick),
            (None, Some(seconds)) => When::In(seconds),
            (Some(_), Some(seconds)) => {
                return Err(Problem::value("in_seconds", seconds.into(), "absent where effective_tick is given"));
            }
        };
        let transition_s = fields.number("transition_s")?.unwrap_or(usual_s);
        fields.finish()?;
        Ok(Self { kind, when, transition_s })
    }
}
