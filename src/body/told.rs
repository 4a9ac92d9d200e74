//! Reads JSON of any size in little memory: into what is wanted, or into what a refusal repeats of it.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

/// Longest text that a refusal repeats, bytes.
const LONGEST: usize = 64;

/// What becomes of a value. A shape overrides what it expects; all else comes to [`Shape::other`], shortened.
pub trait Shape: Sized {
    /// What it becomes.
    type Out;

    /// Of anything that is not expected.
    fn other(self, value: Value) -> Self::Out;

    /// Of an array.
    ///
    /// # Errors
    /// What follows is not JSON.
    fn list<'de, A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Out, A::Error> {
        let count = rest(&mut list)?;
        Ok(self.other(array_of(count)))
    }

    /// Of an object.
    ///
    /// # Errors
    /// What follows is not JSON.
    fn object<'de, A: MapAccess<'de>>(self, mut object: A) -> Result<Self::Out, A::Error> {
        let mut count = 0;
        while object.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {
            count += 1;
        }
        Ok(self.other(format!("an object of {count} fields").into()))
    }
}

/// The value itself: numbers, short texts, and what is longer only counted.
pub struct Brief;

impl Shape for Brief {
    type Out = Value;

    fn other(self, value: Value) -> Value {
        value
    }
}

/// Reads a value as a shape.
pub struct As<S>(pub S);

impl<'de, S: Shape> DeserializeSeed<'de> for As<S> {
    type Value = S::Out;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<S::Out, D::Error> {
        from.deserialize_any(self)
    }
}

impl<'de, S: Shape> Visitor<'de> for As<S> {
    type Value = S::Out;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("any value")
    }

    fn visit_unit<E>(self) -> Result<S::Out, E> {
        Ok(self.0.other(Value::Null))
    }

    fn visit_bool<E>(self, value: bool) -> Result<S::Out, E> {
        Ok(self.0.other(value.into()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<S::Out, E> {
        Ok(self.0.other(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<S::Out, E> {
        Ok(self.0.other(value.into()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<S::Out, E> {
        Ok(self.0.other(value.into()))
    }

    fn visit_str<E>(self, value: &str) -> Result<S::Out, E> {
        let long = value.len() > LONGEST;
        Ok(self.0.other(if long { format!("a string of {} bytes", value.len()) } else { value.to_owned() }.into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<S::Out, A::Error> {
        self.0.list(list)
    }

    fn visit_map<A: MapAccess<'de>>(self, object: A) -> Result<S::Out, A::Error> {
        self.0.object(object)
    }
}

/// Passes over what is left of an array; how much that is.
///
/// # Errors
/// What follows is not JSON.
pub fn rest<'de, A: SeqAccess<'de>>(list: &mut A) -> Result<usize, A::Error> {
    let mut count = 0;
    while list.next_element::<IgnoredAny>()?.is_some() {
        count += 1;
    }
    Ok(count)
}

/// An array as a refusal repeats it.
pub fn array_of(count: usize) -> Value {
    format!("an array of {count}").into()
}
