//! The body of a probe, read as it stands: which points, when, what of them and how. Nothing is kept of a wrong one.

use serde::de::{DeserializeSeed, MapAccess, SeqAccess};
use serde_json::{Deserializer, Value};

use super::fields::{missing, no_object, not_json, tick_of, unknown};
use super::problem::Problem;
use super::told::{As, Brief, Shape, array_of, rest};
use crate::engine::{ProbeFields, ProbeMethod};
use crate::scene::{Model, Scene};
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
        let has = ProbeFields::of(&scene.effects);
        let mut json = Deserializer::from_slice(body);
        let asked = As(Body { has }).deserialize(&mut json).and_then(|asked| json.end().map(|()| asked));
        let Asked { points, tick, fields, method, share, twice, strange } = asked.map_err(|e| not_json(&e))??;
        if let Some(name) = twice {
            return Err(Problem::value(name, "twice".into(), "given once"));
        }
        let points = points.ok_or_else(|| missing("points"))??;
        let tick = tick.map(|tick| tick_of("tick", tick)).transpose()?;
        let fields = fields.unwrap_or(Ok(has))?;
        let number = |share: Value| share.as_f64().ok_or_else(|| Problem::value("share", share, "a number"));
        let method = how(method, share.map(number).transpose()?, scene)?;
        match strange {
            Some((name, value)) => Err(unknown(name, value)),
            None => Ok(Self { points, tick, fields, method }),
        }
    }
}

/// The fields of a body, each read or refused.
#[derive(Default)]
struct Asked {
    points: Option<Result<Vec<[f64; 2]>, Problem>>,
    tick: Option<Value>,
    fields: Option<Result<ProbeFields, Problem>>,
    method: Option<Value>,
    share: Option<Value>,
    /// A field that stands twice.
    twice: Option<&'static str>,
    /// The first field that is none of these, and its value.
    strange: Option<(String, Value)>,
}

struct Body {
    has: ProbeFields,
}

impl Shape for Body {
    type Out = Result<Asked, Problem>;

    fn other(self, _: Value) -> Self::Out {
        Err(no_object())
    }

    fn object<'de, A: MapAccess<'de>>(self, mut object: A) -> Result<Self::Out, A::Error> {
        let mut asked = Asked::default();
        while let Some(name) = object.next_key_seed(As(Brief))? {
            let name = name.as_str().unwrap_or_default();
            let known = match name {
                "points" => asked.points.replace(object.next_value_seed(As(Points))?).map(|_| "points"),
                "tick" => asked.tick.replace(object.next_value_seed(As(Brief))?).map(|_| "tick"),
                "fields" => asked.fields.replace(object.next_value_seed(As(Names(self.has)))?).map(|_| "fields"),
                "method" => asked.method.replace(object.next_value_seed(As(Brief))?).map(|_| "method"),
                "share" => asked.share.replace(object.next_value_seed(As(Brief))?).map(|_| "share"),
                strange => {
                    let value = object.next_value_seed(As(Brief))?;
                    asked.strange.get_or_insert((strange.to_owned(), value));
                    None
                }
            };
            asked.twice = asked.twice.or(known);
        }
        Ok(Ok(asked))
    }
}

/// An array of points.
struct Points;

impl Shape for Points {
    type Out = Result<Vec<[f64; 2]>, Problem>;

    fn other(self, value: Value) -> Self::Out {
        Err(Problem::value("points", value, format!("1 to {MAX_POINTS} points [x, z]")))
    }

    fn list<'de, A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Out, A::Error> {
        let (mut points, mut wrong) = (Vec::new(), None);
        while points.len() < MAX_POINTS {
            match list.next_element_seed(As(Pair { index: points.len() }))? {
                Some(Ok(point)) => points.push(point),
                Some(Err(problem)) => {
                    wrong = Some(problem);
                    break;
                }
                None => break,
            }
        }
        let count = points.len() + usize::from(wrong.is_some()) + rest(&mut list)?;
        Ok(match wrong {
            _ if !(1..=MAX_POINTS).contains(&count) => self.other(array_of(count)),
            Some(problem) => Err(problem),
            None => Ok(points),
        })
    }
}

/// One of the points.
struct Pair {
    index: usize,
}

impl Shape for Pair {
    type Out = Result<[f64; 2], Problem>;

    fn other(self, value: Value) -> Self::Out {
        Err(Problem::value(format!("points[{}]", self.index), value, "two numbers [x, z]"))
    }

    fn list<'de, A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Out, A::Error> {
        let (x, z) = (list.next_element_seed(As(Brief))?, list.next_element_seed(As(Brief))?);
        let count = usize::from(x.is_some()) + usize::from(z.is_some()) + rest(&mut list)?;
        let (Some(x), Some(z), 2) = (x, z, count) else { return Ok(self.other(array_of(count))) };
        let metres = |axis: usize, value: Value| match value.as_f64().filter(|metres| metres.abs() <= FARTHEST_M) {
            Some(metres) => Ok(metres),
            None => {
                let bound = format!("a number of metres within {FARTHEST_M}");
                Err(Problem::value(format!("points[{}][{axis}]", self.index), value, bound))
            }
        };
        Ok(metres(0, x).and_then(|x| Ok([x, metres(1, z)?])))
    }
}

/// Names of what is wanted of the points, of what the scene has.
struct Names(ProbeFields);

impl Shape for Names {
    type Out = Result<ProbeFields, Problem>;

    fn other(self, value: Value) -> Self::Out {
        Err(Problem::value("fields", value, "an array of names"))
    }

    fn list<'de, A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Out, A::Error> {
        let has = [true, self.0.normal, self.0.velocity, self.0.jacobian];
        let (mut wanted, mut index) = (ProbeFields::HEIGHT, 0);
        while let Some(name) = list.next_element_seed(As(Brief))? {
            match name.as_str().and_then(|name| FIELDS.iter().position(|known| *known == name)).filter(|at| has[*at]) {
                Some(1) => wanted.normal = true,
                Some(2) => wanted.velocity = true,
                Some(3) => wanted.jacobian = true,
                Some(_) => {}
                None => {
                    rest(&mut list)?;
                    let known = FIELDS.iter().zip(has).filter_map(|(name, has)| has.then_some(*name));
                    let bound = format!("one that this scene has: {}", known.collect::<Vec<_>>().join(", "));
                    return Ok(Err(Problem::value(format!("fields[{index}]"), name, bound)));
                }
            }
            index += 1;
        }
        Ok(Ok(wanted))
    }
}

fn how(method: Option<Value>, share: Option<f64>, scene: &Scene) -> Result<ProbeMethod, Problem> {
    let named = method.as_ref().map_or(Some("grid"), Value::as_str);
    match (named, share) {
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
        _ => Err(Problem::value("method", method.unwrap_or_default(), "grid or direct")),
    }
}
