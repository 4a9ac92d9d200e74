//! What a client says, as types; reading it is `parse`'s.

use serde::{Deserialize, Serialize};

use super::points::Points;
use super::vocabulary::{Codec, ErrorClass, Group};

/// Largest text message a client may send.
pub const MAX_MESSAGE_BYTES: usize = 131_072;

/// A unit as messages name it: what is encoded once and shared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct UnitName {
    /// Number of the cascade, `index` in `hello`.
    pub cascade: u8,
    /// Level of detail, 0 the full grid.
    pub level: u8,
    /// Error class.
    pub class: ErrorClass,
    /// Group of channels.
    pub group: Group,
    /// How its samples are written.
    #[serde(default, skip_serializing_if = "is_default")]
    pub codec: Codec,
}

fn is_default(codec: &Codec) -> bool {
    *codec == Codec::default()
}

/// A unit and how often it comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnitRate {
    /// The unit.
    #[serde(flatten)]
    pub unit: UnitName,
    /// Frames a second; `None`: those of the subscription.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<u32>,
}

impl From<UnitName> for UnitRate {
    fn from(unit: UnitName) -> Self {
        Self { unit, rate_hz: None }
    }
}

/// A client asks for units at a rate; replaces what it asked before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Subscribe {
    /// Echoed in the answer.
    pub id: u64,
    /// Frames a second.
    pub rate_hz: u32,
    /// What to send.
    pub units: Vec<UnitRate>,
    /// Whether every second begins with key frames.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub keys: bool,
}

/// A client says how it fares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The newest tick of a frame that was decoded, 0 before the first.
    pub tick: u64,
    /// What decoding the frames of a tick takes, milliseconds.
    pub decode_ms: f64,
    /// How far that tick lies ahead of now, milliseconds.
    pub buffer_ms: f64,
    /// A frame could not be read: units begin again with key frames.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lost: bool,
}

/// A client asks for the server's time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Time {
    /// Any finite number, echoed.
    pub t0: f64,
}

/// What a client may say.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ClientMessage {
    /// Replace the subscription.
    Subscribe(Subscribe),
    /// Replace the points.
    Points(Points),
    /// Ask for the time.
    Time(Time),
    /// Say how it fares.
    Report(Report),
}
