//! Reads the JSON object of a request field by field, so that every refusal names the field, its value and its bound.

use http::StatusCode;
use serde_json::{Map, Value};

use super::problem::Problem;
use crate::wire::MAX_TICK;

/// The refusal of a body that can't be read.
pub fn unreadable(detail: String) -> Problem {
    Problem::new(StatusCode::BAD_REQUEST, "not-json", "The body can't be read", detail)
}

/// The fields of an object that have not been read yet.
#[derive(Debug)]
pub struct Fields(Map<String, Value>);

impl Fields {
    /// Parses an object.
    ///
    /// # Errors
    /// 400 for what is not JSON, 422 for what is not an object.
    pub fn parse(body: &[u8]) -> Result<Self, Problem> {
        match serde_json::from_slice(body) {
            Ok(Value::Object(fields)) => Ok(Self(fields)),
            Ok(_) => Err(no_object()),
            Err(error) => Err(not_json(&error)),
        }
    }

    /// A number that may be left out.
    ///
    /// # Errors
    /// 422 for anything but a number.
    pub fn number(&mut self, name: &str) -> Result<Option<f64>, Problem> {
        let Some(value) = self.0.remove(name) else { return Ok(None) };
        value.as_f64().map(Some).ok_or_else(|| Problem::value(name, value, "a number"))
    }

    /// A number that must be there.
    ///
    /// # Errors
    /// 422 when it is not.
    pub fn required(&mut self, name: &str) -> Result<f64, Problem> {
        self.number(name)?.ok_or_else(|| missing(name))
    }

    /// A number that may be left out, or null, which stands for infinity.
    ///
    /// # Errors
    /// 422 for anything else.
    pub fn or_infinite(&mut self, name: &str) -> Result<Option<f64>, Problem> {
        if self.0.get(name) == Some(&Value::Null) {
            self.0.remove(name);
            return Ok(Some(f64::INFINITY));
        }
        self.number(name)
    }

    /// A whole number that may be left out; its bounds are somebody else's.
    ///
    /// # Errors
    /// 422 for anything but a whole number from 0 up.
    pub fn whole(&mut self, name: &str) -> Result<Option<usize>, Problem> {
        let Some(value) = self.0.remove(name) else { return Ok(None) };
        let whole = value.as_u64().and_then(|n| usize::try_from(n).ok());
        whole.map(Some).ok_or_else(|| Problem::value(name, value, "a whole number"))
    }

    /// A list of numbers that may be left out.
    ///
    /// # Errors
    /// 422 for anything but an array of numbers.
    pub fn numbers(&mut self, name: &str) -> Result<Option<Vec<f64>>, Problem> {
        let Some(value) = self.0.remove(name) else { return Ok(None) };
        let numbers: Option<Vec<f64>> = value.as_array().and_then(|all| all.iter().map(Value::as_f64).collect());
        numbers.map(Some).ok_or_else(|| Problem::value(name, value, "an array of numbers"))
    }

    /// A tick that may be left out.
    ///
    /// # Errors
    /// 422 for anything but a whole number from 0 to [`MAX_TICK`].
    pub fn tick(&mut self, name: &str) -> Result<Option<i64>, Problem> {
        self.0.remove(name).map(|value| tick_of(name, value)).transpose()
    }

    /// Ends the reading.
    ///
    /// # Errors
    /// 422 for a field that nobody read: a misspelt name must not be ignored.
    pub fn finish(self) -> Result<(), Problem> {
        match self.0.into_iter().next() {
            None => Ok(()),
            Some((name, value)) => Err(unknown(name, value)),
        }
    }
}

/// A tick.
///
/// # Errors
/// 422 for anything but a whole number from 0 to [`MAX_TICK`].
pub fn tick_of(name: &str, value: Value) -> Result<i64, Problem> {
    let tick = value.as_i64().filter(|tick| (0..=MAX_TICK).contains(tick));
    tick.ok_or_else(|| Problem::value(name, value, "a whole number from 0 to 2^53 - 1"))
}

/// The refusal of what is not JSON.
pub fn not_json(error: &serde_json::Error) -> Problem {
    unreadable(format!("not JSON: {error}"))
}

/// The refusal of JSON that is no object.
pub fn no_object() -> Problem {
    let detail = "the body must be a JSON object";
    Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-value", "The body is no object", detail)
}

/// The refusal of a field that nobody reads.
pub fn unknown(name: String, value: Value) -> Problem {
    let detail = format!("{name:?} is not a field of this request");
    let unknown = Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "unknown-field", "A field is not known", detail);
    unknown.at(name).found(value)
}

/// The refusal of an object without a field.
pub fn missing(name: &str) -> Problem {
    let detail = format!("{name} is missing");
    Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "missing-field", "A field is missing", detail).at(name)
}
