//! The body of a probe, read field by field: which points, when, what of them and how.

use serde_json::Value;

use super::fields::{Fields, missing};
use super::problem::Problem;
use crate::engine::{ProbeFields, ProbeMethod};
use crate::scene::{Effects, Model, Scene};
use crate::wire::FARTHEST_M;

/// Most points of a request.
const MAX_POINTS: usize = 10_000;
/// What can be asked for, height included, which always comes.
const FIELDS: [&str; 4] = ["height", "normal", "velocity", "jacobian"];

/// What a probe asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeBody {
    /// World positions (x, z), metres.
    pub points: Vec<[f64; 2]>,
    /// `None`: now.
    pub tick: Option<i64>,
    /// What of them.
    pub fields: ProbeFields,
    /// How it is summed.
    pub method: ProbeMethod,
}

impl ProbeBody {
    /// Reads a body for a scene.
    ///
    /// # Errors
    /// [`Problem`] naming the first field that is wrong, its value and its bound.
    pub fn read(body: &[u8], scene: &Scene) -> Result<Self, Problem> {
        let mut fields = Fields::parse(body)?;
        let points = points(fields.any("points"))?;
        let tick = fields.tick("tick")?;
        let wanted = wanted(fields.any("fields"), &scene.effects)?;
        let method = method(fields.any("method"), fields.number("share")?, scene)?;
        fields.finish()?;
        Ok(Self { points, tick, fields: wanted, method })
    }
}

fn points(value: Option<Value>) -> Result<Vec<[f64; 2]>, Problem> {
    let value = value.ok_or_else(|| missing("points"))?;
    let list = value.as_array().filter(|list| (1..=MAX_POINTS).contains(&list.len()));
    let list =
        list.ok_or_else(|| Problem::value("points", brief(&value), format!("1 to {MAX_POINTS} points [x, z]")))?;
    let mut points = Vec::with_capacity(list.len());
    for (i, point) in list.iter().enumerate() {
        let pair: Option<&[Value; 2]> = point.as_array().and_then(|pair| pair.as_slice().try_into().ok());
        let pair = pair.ok_or_else(|| Problem::value(format!("points[{i}]"), brief(point), "two numbers [x, z]"))?;
        let number = |axis: usize| {
            let number = pair[axis].as_f64().filter(|metres| metres.abs() <= FARTHEST_M);
            let refused = || {
                let bound = format!("a number of metres within {FARTHEST_M}");
                Problem::value(format!("points[{i}][{axis}]"), brief(&pair[axis]), bound)
            };
            number.ok_or_else(refused)
        };
        points.push([number(0)?, number(1)?]);
    }
    Ok(points)
}

fn wanted(value: Option<Value>, effects: &Effects) -> Result<ProbeFields, Problem> {
    let had = ProbeFields::of(effects);
    let Some(value) = value else { return Ok(had) };
    let names = value.as_array().ok_or_else(|| Problem::value("fields", brief(&value), "an array of names"))?;
    let (mut wanted, has) = (ProbeFields::HEIGHT, [true, had.normal, had.velocity, had.jacobian]);
    for (i, name) in names.iter().enumerate() {
        match name.as_str().and_then(|name| FIELDS.iter().position(|known| *known == name)).filter(|at| has[*at]) {
            Some(1) => wanted.normal = true,
            Some(2) => wanted.velocity = true,
            Some(3) => wanted.jacobian = true,
            Some(_) => {}
            None => {
                let known = FIELDS.iter().zip(has).filter_map(|(name, has)| has.then_some(*name));
                let bound = format!("one that this scene has: {}", known.collect::<Vec<_>>().join(", "));
                return Err(Problem::value(format!("fields[{i}]"), brief(name), bound));
            }
        }
    }
    Ok(wanted)
}

fn method(value: Option<Value>, share: Option<f64>, scene: &Scene) -> Result<ProbeMethod, Problem> {
    let method = value.as_ref().map_or(Some("grid"), Value::as_str);
    match (method, share) {
        (Some("grid"), None) => Ok(ProbeMethod::Grid),
        (Some("grid"), Some(share)) => Err(Problem::value("share", share.into(), "absent where method is grid")),
        // Trochoids are evaluated at the points, all of them.
        (Some("direct"), Some(share)) if scene.model != Model::Fft => {
            Err(Problem::value("share", share.into(), "absent where the scene's model is trochoid"))
        }
        (Some("direct"), share) => {
            let whole = share.unwrap_or(1.0);
            let share = Some(whole).filter(|share| *share > 0.0 && *share <= 1.0);
            let share = share.ok_or_else(|| Problem::value("share", whole.into(), "above 0, up to 1"))?;
            Ok(ProbeMethod::Direct { share })
        }
        _ => Err(Problem::value("method", brief(&value.unwrap_or_default()), "grid or direct")),
    }
}

/// A value as a refusal repeats it: what is long is only counted.
fn brief(value: &Value) -> Value {
    match value {
        Value::Array(list) if list.len() > 2 || list.iter().any(|v| v.is_array() || v.is_object() || v.is_string()) => {
            format!("an array of {}", list.len()).into()
        }
        Value::Object(object) => format!("an object of {} fields", object.len()).into(),
        Value::String(text) if text.len() > 64 => format!("a string of {} bytes", text.len()).into(),
        value => value.clone(),
    }
}
