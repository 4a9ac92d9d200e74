//! What clients ask for, checked against the sea that is served.

use crate::engine::RATES_HZ;
use crate::sea::Timeline;
use crate::tile::levels;
use crate::wire::{ClientError, ErrorCode, Group, MAX_TICK, ServerMessage, Subscribe};

use super::settings::MAX_UNITS;

/// Checks that every unit of a subscription exists.
///
/// # Errors
/// [`ClientError`] naming the first field that is wrong, its value and its bound.
pub fn check(subscribe: &Subscribe, timeline: &Timeline) -> Result<(), ClientError> {
    if !RATES_HZ.contains(&subscribe.rate_hz) {
        return Err(invalid("rate_hz".to_owned(), subscribe.rate_hz, &format!("one of {RATES_HZ:?}")));
    }
    if subscribe.units.len() > MAX_UNITS {
        return Err(invalid("units".to_owned(), subscribe.units.len(), &format!("at most {MAX_UNITS}")));
    }
    let cascades = &timeline.layout().cascades;
    for (index, unit) in subscribe.units.iter().enumerate() {
        let Some(cascade) = cascades.get(usize::from(unit.cascade)) else {
            return Err(invalid(format!("units[{index}].cascade"), unit.cascade, &below(cascades.len())));
        };
        if unit.level >= levels(cascade) {
            return Err(invalid(format!("units[{index}].level"), unit.level, &below(usize::from(levels(cascade)))));
        }
        if unit.group == Group::Foam && timeline.scene().effects.foam.is_none() {
            return Err(invalid(format!("units[{index}].group"), "foam", "another group: this scene has no foam"));
        }
    }
    Ok(())
}

/// A refusal as it is sent.
pub fn refusal(error: ClientError, id: Option<u64>) -> ServerMessage {
    ServerMessage::Error { code: error.code, detail: error.detail, field: error.field, id }
}

/// The id of a request that is refused as a whole, where it has one.
pub fn id_of(text: &str) -> Option<u64> {
    let request: serde_json::Value = serde_json::from_str(text).ok()?;
    request.get("id")?.as_u64().filter(|id| *id <= MAX_TICK as u64)
}

/// The refusal of a unit that is beyond the limit of live units.
pub fn unavailable(index: usize, most: usize) -> ClientError {
    let detail = format!("units[{index}] is not live, and {most} units are, the most this server encodes at a time");
    ClientError { code: ErrorCode::Unavailable, field: Some(format!("units[{index}]")), detail }
}

fn invalid(field: String, value: impl std::fmt::Display, bound: &str) -> ClientError {
    let detail = format!("{field} is {value}, must be {bound}");
    ClientError { code: ErrorCode::Invalid, field: Some(field), detail }
}

fn below(n: usize) -> String {
    format!("below {n}")
}
