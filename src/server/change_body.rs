//! The JSON body of a change, read into what it asks for; whether the sea can is decided elsewhere.

use super::fields::Fields;
use super::problem::Problem;
use super::proposal::When;
use crate::scene::ChangeKind;

/// How long the sea takes to follow a change that does not say.
const TRANSITION_S: f64 = 5.0;

/// What a body asks for. Its numbers are finite and not checked further.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        Self::rest(kind, fields)
    }

    /// The body of `PATCH /v1/scenes/{name}/sea`.
    ///
    /// # Errors
    /// [`Problem`] naming the first field that is wrong.
    pub fn sea(body: &[u8]) -> Result<Self, Problem> {
        let mut fields = Fields::parse(body)?;
        let kind = ChangeKind::Water { depth_m: fields.nullable("depth_m")? };
        Self::rest(kind, fields)
    }

    /// Reads what all changes have in common.
    fn rest(kind: ChangeKind, mut fields: Fields) -> Result<Self, Problem> {
        let when = match (fields.tick("effective_tick")?, fields.number("in_seconds")?) {
            (None, None) => When::Soon,
            (Some(tick), None) => When::Tick(tick),
            (None, Some(seconds)) => When::In(seconds),
            (Some(_), Some(seconds)) => {
                return Err(Problem::value("in_seconds", seconds.into(), "absent where effective_tick is given"));
            }
        };
        let transition_s = fields.number("transition_s")?.unwrap_or(TRANSITION_S);
        fields.finish()?;
        Ok(Self { kind, when, transition_s })
    }
}
