//! The protocol `swellcast.v1` as types: frames in bytes, messages in JSON. Knows nothing of seas.
//!
//! `proto/PROTOCOL.md` is normative; this room follows it and the vectors in `proto/vectors` bind both.
//! Invariant: imports no other room, does no input or output, and no input makes it panic.

mod frame;
mod message;
mod parse;
mod points;
mod request;
mod vocabulary;

pub use frame::{FLAG_KEY, FLAG_SATURATED, FrameError, FrameHeader, HEADER_BYTES, MAGIC, split};
pub use message::{
    ClassInfo, ClientError, ErrorCode, GroupInfo, Hello, HelloCascade, HelloDetail, HelloLayout, Limits, Quality,
    ServerMessage, Status, Subscribed, TimeAnswer, WindStatus, WireChange, WireChangeKind,
};
pub use parse::ServerTextError;
pub use points::{
    FARTHEST_M, FLAG_JACOBIAN, FLAG_NORMAL, FLAG_VELOCITY, MAX_POINTS, POINT_BYTES, POINTS_HEADER_BYTES, POINTS_MAGIC,
    PointRecord, Points, PointsHeader, PointsSubscribed, read_points, write_points,
};
pub use request::{ClientMessage, MAX_MESSAGE_BYTES, Report, Subscribe, Time, UnitName, UnitRate};
pub use vocabulary::{
    BETWEEN, Codec, ErrorClass, Group, MAX_DEPTH, MAX_TICK, RATES_HZ, REST_TICKS, SLOWEST_INTERVAL, SUBPROTOCOL,
    TICKS_PER_SECOND, TILE, layer_of, lead_of,
};
