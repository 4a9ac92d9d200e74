//! Reading text messages: a client's strictly, naming the field at fault; a server's leniently, as PROTOCOL.md 2 asks.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use thiserror::Error;

use super::message::{ClientError, ErrorCode, ServerMessage};
use super::points::{FARTHEST_M, Points};
use super::request::{ClientMessage, MAX_MESSAGE_BYTES, Report, Subscribe, Time, UnitName, UnitRate};
use super::vocabulary::{Codec, ErrorClass, Group, MAX_TICK};

/// Why a text from a server is not a message.
#[derive(Debug, Error)]
#[error("not a message of swellcast.v1: {0}")]
pub struct ServerTextError(#[from] serde_json::Error);

impl ServerMessage {
    /// Reads a server's text message. Fields that it doesn't know are ignored; `None` for a `type` it doesn't know.
    ///
    /// # Errors
    /// [`ServerTextError`] when the text is not JSON or a known message lacks a field.
    pub fn parse(text: &str) -> Result<Option<Self>, ServerTextError> {
        #[derive(serde::Deserialize)]
        struct Kind {
            #[serde(rename = "type")]
            kind: String,
        }
        let Kind { kind } = serde_json::from_str(text)?;
        match kind.as_str() {
            "hello" | "subscribed" | "points_subscribed" | "time" | "quality" | "status" | "change" | "error" => {
                Ok(Some(serde_json::from_str(text)?))
            }
            _ => Ok(None),
        }
    }
}

impl ClientMessage {
    /// Reads a client's text message, refusing fields that it doesn't know and fields that stand twice.
    ///
    /// # Errors
    /// [`ClientError`] with the code and, where one is at fault, the field: [`ErrorCode::Malformed`] when the text is
    /// not JSON or a field is missing, unknown, doubled or of another JSON type; [`ErrorCode::Invalid`] when a value is
    /// out of its bounds; [`ErrorCode::UnknownType`] for a `type` that is no message.
    pub fn parse(text: &str) -> Result<Self, ClientError> {
        if text.len() > MAX_MESSAGE_BYTES {
            let detail = format!("message is {} bytes, must be at most {MAX_MESSAGE_BYTES}", text.len());
            return Err(ClientError { code: ErrorCode::Malformed, field: None, detail });
        }
        let message: Json = serde_json::from_str(text).map_err(|e| ClientError {
            code: ErrorCode::Malformed,
            field: None,
            detail: format!("not JSON: {e}"),
        })?;
        match kind(&message)? {
            "subscribe" => {
                let ([_, id, rate_hz, units], [keys]) =
                    fields_and(&message, "", ["type", "id", "rate_hz", "units"], ["keys"])?;
                Ok(Self::Subscribe(Subscribe {
                    id: whole(id, "id", MAX_TICK as u64)?,
                    rate_hz: whole(rate_hz, "rate_hz", u64::from(u32::MAX))? as u32,
                    units: self::units(units)?,
                    keys: keys.map(|keys| boolean(keys, "keys")).transpose()?.unwrap_or_default(),
                }))
            }
            "points" => {
                let [_, id, rate_hz, points] = fields(&message, "", ["type", "id", "rate_hz", "points"])?;
                Ok(Self::Points(Points {
                    id: whole(id, "id", MAX_TICK as u64)?,
                    rate_hz: whole(rate_hz, "rate_hz", u64::from(u32::MAX))? as u32,
                    points: self::points(points)?,
                }))
            }
            "time" => {
                let [_, t0] = fields(&message, "", ["type", "t0"])?;
                Ok(Self::Time(Time { t0: number(t0, "t0")? }))
            }
            "report" => {
                let ([_, tick, decode_ms, buffer_ms], [lost]) =
                    fields_and(&message, "", ["type", "tick", "decode_ms", "buffer_ms"], ["lost"])?;
                Ok(Self::Report(Report {
                    tick: whole(tick, "tick", MAX_TICK as u64)?,
                    decode_ms: number(decode_ms, "decode_ms")?,
                    buffer_ms: number(buffer_ms, "buffer_ms")?,
                    lost: lost.map(|lost| boolean(lost, "lost")).transpose()?.unwrap_or_default(),
                }))
            }
            other => Err(ClientError {
                code: ErrorCode::UnknownType,
                field: Some("type".to_owned()),
                detail: format!(
                    "type is {:?}, must be \"subscribe\", \"points\", \"time\" or \"report\"",
                    beginning(other)
                ),
            }),
        }
    }
}

fn number(value: &Json, field: &str) -> Result<f64, ClientError> {
    match value {
        Json::Number(number) => Ok(number.as_f64().unwrap_or_default()),
        other => Err(malformed(field, format!("is {other}, must be a number"))),
    }
}

fn boolean(value: &Json, field: &str) -> Result<bool, ClientError> {
    match value {
        Json::Bool(value) => Ok(*value),
        other => Err(malformed(field, format!("is {other}, must be a boolean"))),
    }
}

fn units(value: &Json) -> Result<Vec<UnitRate>, ClientError> {
    let Json::List(items) = value else {
        return Err(malformed("units", format!("is {value}, must be an array")));
    };
    let unit = |(index, item): (usize, &Json)| {
        let path = format!("units[{index}]");
        let ([cascade, level, class, group], [rate_hz, codec]) =
            fields_and(item, &path, ["cascade", "level", "class", "group"], ["rate_hz", "codec"])?;
        let codec = codec.map(|codec| named(codec, &format!("{path}.codec"), Codec::ALL.map(|c| (c.name(), c))));
        let unit = UnitName {
            cascade: whole(cascade, &format!("{path}.cascade"), 255)? as u8,
            level: whole(level, &format!("{path}.level"), 255)? as u8,
            class: named(class, &format!("{path}.class"), ErrorClass::ALL.map(|c| (c.name(), c)))?,
            group: named(group, &format!("{path}.group"), Group::ALL.map(|g| (g.name(), g)))?,
            codec: codec.transpose()?.unwrap_or_default(),
        };
        let rate = |rate| whole(rate, &format!("{path}.rate_hz"), u64::from(u32::MAX)).map(|rate| rate as u32);
        Ok(UnitRate { unit, rate_hz: rate_hz.map(rate).transpose()? })
    };
    items.iter().enumerate().map(unit).collect()
}

fn points(value: &Json) -> Result<Vec<[f64; 2]>, ClientError> {
    let Json::List(items) = value else {
        return Err(malformed("points", format!("is {value}, must be an array")));
    };
    let point = |(index, item): (usize, &Json)| {
        let pair = if let Json::List(pair) = item { pair.as_slice() } else { &[] };
        let [x, z] = pair else {
            return Err(malformed(&format!("points[{index}]"), "must be an array of two numbers".to_owned()));
        };
        let metres = |axis: usize, value: &Json| match value {
            Json::Number(number) => {
                let within = number.as_f64().filter(|metres| metres.abs() <= FARTHEST_M);
                let field = format!("points[{index}][{axis}]");
                within.ok_or_else(|| invalid(&field, format!("is {number}, must be within {FARTHEST_M} metres")))
            }
            other => Err(malformed(&format!("points[{index}][{axis}]"), format!("is {other}, must be a number"))),
        };
        Ok([metres(0, x)?, metres(1, z)?])
    };
    items.iter().enumerate().map(point).collect()
}

/// The `type` of a message, wherever it stands in the object.
fn kind(message: &Json) -> Result<&str, ClientError> {
    let Json::Object(entries) = message else {
        return Err(malformed("", format!("message is {message}, must be an object")));
    };
    match entries.iter().find(|(key, _)| key == "type") {
        Some((_, Json::Text(kind))) => Ok(kind),
        Some((_, other)) => Err(malformed("type", format!("is {other}, must be a string"))),
        None => Err(malformed("type", "is missing".to_owned())),
    }
}

/// The values of exactly these fields of an object, each of which must stand once and beside no other.
fn fields<'a, const N: usize>(value: &'a Json, path: &str, names: [&str; N]) -> Result<[&'a Json; N], ClientError> {
    fields_and(value, path, names, []).map(|(found, [])| found)
}

type Found<'a, const N: usize, const M: usize> = ([&'a Json; N], [Option<&'a Json>; M]);

/// The same, and of fields that may be left out.
fn fields_and<'a, const N: usize, const M: usize>(
    value: &'a Json,
    path: &str,
    names: [&str; N],
    optional: [&str; M],
) -> Result<Found<'a, N, M>, ClientError> {
    let Json::Object(entries) = value else {
        return Err(malformed(path, format!("is {value}, must be an object")));
    };
    let at = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    let (mut found, mut also) = ([None; N], [None; M]);
    for (key, value) in entries {
        let slot = names.iter().position(|name| name == key).map(|slot| &mut found[slot]);
        let Some(slot) = slot.or(optional.iter().position(|name| name == key).map(|slot| &mut also[slot])) else {
            let key = beginning(key);
            let known = names.into_iter().chain(optional).collect::<Vec<_>>().join(", ");
            return Err(malformed(&at(&key), format!("is unknown, must be one of {known}")));
        };
        if slot.replace(value).is_some() {
            return Err(malformed(&at(key), "stands twice".to_owned()));
        }
    }
    if let Some(slot) = found.iter().position(Option::is_none) {
        return Err(malformed(&at(names[slot]), "is missing".to_owned()));
    }
    Ok((found.map(|value| value.expect("no slot is empty")), also))
}

fn whole(value: &Json, field: &str, most: u64) -> Result<u64, ClientError> {
    let Json::Number(number) = value else {
        return Err(malformed(field, format!("is {value}, must be a number")));
    };
    number
        .as_u64()
        .filter(|whole| *whole <= most)
        .ok_or_else(|| invalid(field, format!("is {number}, must be a whole number from 0 to {most}")))
}

fn named<T: Copy, const N: usize>(value: &Json, field: &str, words: [(&str, T); N]) -> Result<T, ClientError> {
    let Json::Text(text) = value else {
        return Err(malformed(field, format!("is {value}, must be a string")));
    };
    words.iter().find(|(name, _)| name == text).map(|(_, value)| *value).ok_or_else(|| {
        let text = beginning(text);
        invalid(field, format!("is {text:?}, must be one of {}", words.map(|(name, _)| name).join(", ")))
    })
}

/// As much of a text as a refusal echoes.
fn beginning(text: &str) -> String {
    text.chars().take(64).collect()
}

fn malformed(field: &str, what: String) -> ClientError {
    refuse(ErrorCode::Malformed, field, what)
}

fn invalid(field: &str, what: String) -> ClientError {
    refuse(ErrorCode::Invalid, field, what)
}

fn refuse(code: ErrorCode, field: &str, what: String) -> ClientError {
    if field.is_empty() {
        return ClientError { code, field: None, detail: what };
    }
    ClientError { code, field: Some(field.to_owned()), detail: format!("{field} {what}") }
}

/// JSON with the keys of an object as they stand: `serde_json::Value` keeps the last of two equal keys, and derived
/// readers take an array for an object, so neither can refuse them.
enum Json {
    Null,
    Bool(bool),
    Number(serde_json::Number),
    Text(String),
    List(Vec<Json>),
    Object(Vec<(String, Json)>),
}

impl fmt::Display for Json {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Null => "null",
            Self::Bool(_) => "a boolean",
            Self::Number(_) => "a number",
            Self::Text(_) => "a string",
            Self::List(_) => "an array",
            Self::Object(_) => "an object",
        })
    }
}

impl<'de> Deserialize<'de> for Json {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Json;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("JSON")
            }
            fn visit_unit<E>(self) -> Result<Json, E> {
                Ok(Json::Null)
            }
            fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
                Ok(Json::Bool(value))
            }
            fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
                Ok(Json::Number(value.into()))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
                Ok(Json::Number(value.into()))
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Json, E> {
                serde_json::Number::from_f64(value).map(Json::Number).ok_or_else(|| E::custom("number is not finite"))
            }
            fn visit_str<E>(self, value: &str) -> Result<Json, E> {
                Ok(Json::Text(value.to_owned()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Json, A::Error> {
                let mut list = Vec::new();
                while let Some(item) = items.next_element()? {
                    list.push(item);
                }
                Ok(Json::List(list))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Json, A::Error> {
                let mut object = Vec::new();
                while let Some(entry) = entries.next_entry()? {
                    object.push(entry);
                }
                Ok(Json::Object(object))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}
