//! What a server says in text, as types; reading it is `parse`'s.

use serde::{Deserialize, Deserializer, Serialize, de};
use thiserror::Error;

use super::points::PointsSubscribed;
use super::request::UnitRate;
use super::vocabulary::{ErrorClass, Group};

/// Why a client's message is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{detail}")]
pub struct ClientError {
    /// Kind of refusal, for programs.
    pub code: ErrorCode,
    /// The field at fault, where there is one.
    pub field: Option<String>,
    /// For people: what was found and what is allowed.
    pub detail: String,
}

/// Kinds of refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorCode {
    /// Not JSON, or not of the message's form.
    Malformed,
    /// No such message.
    UnknownType,
    /// A value out of bounds.
    Invalid,
    /// Well formed, but the server can't.
    Unavailable,
}

/// A cascade as `hello` describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HelloCascade {
    /// Its number in units and frames.
    pub index: u8,
    /// Side of the square patch, metres.
    pub patch_m: f64,
    /// Samples a side at level 0.
    pub n: u32,
    /// Levels that can be asked for.
    pub levels: u8,
    /// Shortest wave it holds, metres.
    pub wavelength_min_m: f64,
    /// Longest wave it holds, metres.
    pub wavelength_max_m: f64,
    /// It is part of the sea from this tick on ...
    pub from_tick: i64,
    /// ... and no more from this one on; `None` while no change of layout ends it.
    pub until_tick: Option<i64>,
    /// Groups that can't be had as fine or as often as any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub detail: Vec<HelloDetail>,
}

/// How fine and how often a group of a cascade can be had.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HelloDetail {
    /// The group.
    pub group: Group,
    /// The finest level.
    pub finest_level: u8,
    /// The highest rate, frames a second, 0 for none at all; absent: as high as any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<u32>,
}

impl HelloCascade {
    /// Whether it is part of the sea of a tick.
    pub fn contains(&self, tick: i64) -> bool {
        tick >= self.from_tick && self.until_tick.is_none_or(|until| tick < until)
    }
}

/// The cascades of a sea.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HelloLayout {
    /// Counts the changes of layout that were accepted.
    pub generation: u32,
    /// Of one layout, or of two while it changes: the old one's first.
    pub cascades: Vec<HelloCascade>,
}

/// An error class as `hello` describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClassInfo {
    /// The class.
    pub name: ErrorClass,
    /// Largest error of displacement, metres.
    #[serde(deserialize_with = "finite")]
    pub displacement_m: f32,
    /// Largest error of slopes and derivatives.
    #[serde(deserialize_with = "finite")]
    pub slope: f32,
    /// Largest error of foam.
    #[serde(deserialize_with = "finite")]
    pub foam: f32,
    /// Largest error of velocity, m/s.
    #[serde(deserialize_with = "finite")]
    pub velocity_mps: f32,
}

/// Reads an f32, which makes an infinity of a number beyond it.
fn finite<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    let value = f32::deserialize(deserializer)?;
    if value.is_finite() { Ok(value) } else { Err(de::Error::custom("a number is beyond 32 bits")) }
}

/// A group as `hello` describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupInfo {
    /// The group.
    pub name: Group,
    /// Its channels, in order.
    pub channels: Vec<String>,
}

/// What a client must keep within.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Largest message from a client.
    pub message_bytes: u32,
    /// Most units of one subscription.
    pub units: u32,
    /// Most units encoded for all clients together.
    pub live_units: u32,
    /// Most points of one client; none where a server has no points.
    #[serde(default)]
    pub points: u32,
}

/// The server's first message.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // The table of PROTOCOL.md section 3 is their documentation.
pub struct Hello {
    pub protocol: u32,
    pub server: String,
    pub scene: String,
    pub epoch: String,
    pub seed: String,
    pub ticks_per_second: i64,
    pub tick: i64,
    pub lead_ticks: i64,
    pub sequence: u64,
    pub layout: HelloLayout,
    pub choppiness: f64,
    pub rates_hz: Vec<u32>,
    pub classes: Vec<ClassInfo>,
    pub groups: Vec<GroupInfo>,
    pub foam_step_ticks: i64,
    pub limits: Limits,
}

impl Hello {
    /// The table of error classes, for `classes`.
    pub fn all_classes() -> Vec<ClassInfo> {
        let of = |name: ErrorClass| ClassInfo {
            name,
            displacement_m: name.max_error(Group::Displacement),
            slope: name.max_error(Group::Slopes),
            foam: name.max_error(Group::Foam),
            velocity_mps: name.max_error(Group::Velocity),
        };
        ErrorClass::ALL.map(of).to_vec()
    }

    /// The table of those groups that `has` names, for `groups`.
    pub fn groups(has: impl Fn(Group) -> bool) -> Vec<GroupInfo> {
        let of = |name: Group| GroupInfo { name, channels: name.channels().iter().map(|c| (*c).to_owned()).collect() };
        Group::ALL.into_iter().filter(|group| has(*group)).map(of).collect()
    }
}

/// Answer to `subscribe`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Subscribed {
    /// As sent.
    pub id: u64,
    /// Frames a second.
    pub rate_hz: u32,
    /// What will be sent, in the order asked.
    pub units: Vec<UnitRate>,
    /// The first tick whose frames will come.
    pub from_tick: i64,
}

/// What is sent from now on where that is not what was granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Quality {
    /// No unit comes more often, frames a second.
    pub rate_hz: u32,
    /// Levels by which each unit is coarser, where its cascade has so many.
    pub coarser: u8,
}

/// Answer to `time`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeAnswer {
    /// As sent.
    pub t0: f64,
    /// Microseconds since tick 0 when the request was read.
    pub t1_us: i64,
    /// Microseconds since tick 0 when the answer was written.
    pub t2_us: i64,
}

/// The wind of a wind-driven sea.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindStatus {
    /// Speed 10 m above the water, m/s.
    pub speed_mps: f64,
    /// Where it comes from, degrees clockwise from north.
    pub direction_from_deg: f64,
}

/// How the sea and the server are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // PROTOCOL.md section 3, `status`, is their documentation.
pub struct Status {
    pub tick: i64,
    pub sequence: u64,
    pub hs_m: f64,
    pub wind: Option<WindStatus>,
    pub wind_range_mps: Option<[f64; 2]>,
    pub depth_m: Option<f64>,
    pub clients: u32,
    pub backend: String,
    pub step_ms: f64,
    pub skipped_frames: u64,
}

/// What an entry of the control log changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum WireChangeKind {
    /// The wind.
    Wind {
        /// Speed 10 m above the water, m/s.
        speed_mps: f64,
        /// Where it comes from, degrees clockwise from north.
        direction_from_deg: f64,
    },
    /// The water body; what is absent stays as it is.
    Water {
        /// Depth in metres; infinity, which JSON writes as null, for infinitely deep.
        #[serde(default, deserialize_with = "depth", skip_serializing_if = "Option::is_none")]
        depth_m: Option<f64>,
        /// Gravity, m/s^2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        gravity: Option<f64>,
    },
    /// The cascades, as they were asked for; what they are stands in the `hello` that follows.
    Layout {
        /// Samples a side; absent: as the waves need it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        n: Option<u32>,
        /// End of each band, as a share of its patch's Nyquist wavenumber.
        band_limit: f64,
        /// Shortest wave an automatic layout must hold, metres.
        finest_wavelength_m: f64,
        /// Patch sides in metres; empty: automatic.
        patches_m: Vec<f64>,
        /// Wind speeds from now on, m/s; absent: as they were.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        wind_range_mps: Option<[f64; 2]>,
    },
}

/// Null is a depth, too.
fn depth<'de, D: Deserializer<'de>>(value: D) -> Result<Option<f64>, D::Error> {
    Ok(Some(Option::<f64>::deserialize(value)?.unwrap_or(f64::INFINITY)))
}

/// An entry of the control log, as clients are told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireChange {
    /// Its place in the log, from 1.
    pub sequence: u64,
    /// The tick at which it begins to act.
    pub effective_tick: i64,
    /// How long it takes.
    pub transition_ticks: i64,
    /// What changes.
    pub change: WireChangeKind,
}

/// What the server says in text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ServerMessage {
    /// First message.
    Hello(Box<Hello>),
    /// Answer to `subscribe`.
    Subscribed(Subscribed),
    /// Answer to `points`.
    PointsSubscribed(PointsSubscribed),
    /// Answer to `time`.
    Time(TimeAnswer),
    /// What is sent from now on.
    Quality(Quality),
    /// Once a second.
    Status(Status),
    /// An accepted change.
    Change(WireChange),
    /// A refusal.
    Error {
        /// Kind of refusal.
        code: ErrorCode,
        /// For people.
        detail: String,
        /// The field at fault.
        #[serde(skip_serializing_if = "Option::is_none")]
        field: Option<String>,
        /// The request's id.
        #[serde(skip_serializing_if = "Option::is_none")]
        id: Option<u64>,
    },
}

impl ServerMessage {
    /// The message as JSON text.
    ///
    /// # Panics
    /// Never: every field is a plain number, string or list; floats are finite by construction, but for a depth, whose
    /// infinity JSON writes as null.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("plain data serialises")
    }
}
