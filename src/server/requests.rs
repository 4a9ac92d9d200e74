//! What clients ask for, checked against the sea that is served.

use crate::engine::RATES_HZ;
use crate::sea::{Layout, Timeline};
use crate::tile::levels;
use crate::wire::{ClientError, ErrorCode, Group, MAX_TICK, ServerMessage, Subscribe, UnitName};

use super::settings::MAX_UNITS;

/// Checks that every unit of a subscription exists. Gives those that can still come at `tick`: without units of
/// cascades that have ended, which a client may ask for until it has read of it.
///
/// # Errors
/// [`ClientError`] naming the first field that is wrong, its value and its bound.
pub fn check(subscribe: &Subscribe, timeline: &Timeline, tick: i64) -> Result<Vec<UnitName>, ClientError> {
    if !RATES_HZ.contains(&subscribe.rate_hz) {
        return Err(invalid("rate_hz".to_owned(), subscribe.rate_hz, &format!("one of {RATES_HZ:?}")));
    }
    if subscribe.units.len() > MAX_UNITS {
        return Err(invalid("units".to_owned(), subscribe.units.len(), &format!("at most {MAX_UNITS}")));
    }
    let mut units = Vec::with_capacity(subscribe.units.len());
    let before = timeline.layout().generation.checked_sub(1);
    for (index, unit) in subscribe.units.iter().enumerate() {
        let life = match timeline.life_of(unit.cascade) {
            Some((_, life)) => life,
            None if before.is_some_and(|before| Layout::numbers(before, unit.cascade)) => continue,
            None => {
                let known: Vec<u8> = timeline.lives().map(|life| life.cascade.index).collect();
                return Err(invalid(format!("units[{index}].cascade"), unit.cascade, &format!("one of {known:?}")));
            }
        };
        if unit.level >= levels(&life.cascade) {
            let below = format!("below {}", levels(&life.cascade));
            return Err(invalid(format!("units[{index}].level"), unit.level, &below));
        }
        if !timeline.scene().effects.has(unit.group) {
            let all = Group::ALL.into_iter().filter(|group| timeline.scene().effects.has(*group));
            let had: Vec<&str> = all.map(Group::name).collect();
            let bound = format!("one that this scene has: {}", had.join(", "));
            return Err(invalid(format!("units[{index}].group"), unit.group.name(), &bound));
        }
        if !life.is_over(tick) {
            units.push(*unit);
        }
    }
    Ok(units)
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
