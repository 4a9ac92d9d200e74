//! What clients ask for, checked against the sea that is served.

use crate::engine::interval_of_rate;
use crate::sea::{Layout, Timeline};
use crate::wire::{
    ClientError, ErrorCode, Group, MAX_POINTS, MAX_TICK, Points, RATES_HZ, ServerMessage, Subscribe, UnitName, UnitRate,
};

use super::settings::MAX_UNITS;

/// Checks that every unit of a subscription exists. Gives those that can still come at `tick`, each with its interval:
/// without units of cascades that have ended, which a client may ask for until it has read of it.
///
/// # Errors
/// [`ClientError`] naming the first field that is wrong, its value and its bound.
pub fn check(subscribe: &Subscribe, timeline: &Timeline, tick: i64) -> Result<Vec<(UnitName, i64)>, ClientError> {
    check_rate("rate_hz", subscribe.rate_hz)?;
    if subscribe.units.len() > MAX_UNITS {
        return Err(invalid("units".to_owned(), subscribe.units.len(), &format!("at most {MAX_UNITS}")));
    }
    let mut units = Vec::with_capacity(subscribe.units.len());
    let before = timeline.layout().generation.checked_sub(1);
    for (index, UnitRate { unit, rate_hz }) in subscribe.units.iter().enumerate() {
        let field = |name: &str| format!("units[{index}].{name}");
        let life = match timeline.life_of(unit.cascade) {
            Some((_, life)) => life,
            None if before.is_some_and(|before| Layout::numbers(before, unit.cascade)) => continue,
            None => {
                let known: Vec<u8> = timeline.lives().map(|life| life.cascade.index).collect();
                return Err(invalid(field("cascade"), unit.cascade, &format!("one of {known:?}")));
            }
        };
        if unit.level >= life.cascade.levels() {
            return Err(invalid(field("level"), unit.level, &format!("below {}", life.cascade.levels())));
        }
        let scene = timeline.scene();
        if !scene.effects.has(unit.group) {
            let all = Group::ALL.into_iter().filter(|group| scene.effects.has(*group));
            let had: Vec<&str> = all.map(Group::name).collect();
            let bound = format!("one that this scene has: {}", had.join(", "));
            return Err(invalid(field("group"), unit.group.name(), &bound));
        }
        if let Some(rate) = rate_hz {
            check_rate(&field("rate_hz"), *rate)?;
        }
        let mut rate = rate_hz.unwrap_or(subscribe.rate_hz);
        if let Some(detail) = scene.detail_of(unit.cascade, life.cascade.levels(), unit.group) {
            if unit.level < detail.finest_level {
                let bound = format!("at least {}: the scene has no finer {}", detail.finest_level, unit.group.name());
                return Err(invalid(field("level"), unit.level, &bound));
            }
            match (detail.rate_hz, rate_hz) {
                (Some(0), _) => {
                    let bound = format!("another: the scene has none of cascade {}", unit.cascade);
                    return Err(invalid(field("group"), unit.group.name(), &bound));
                }
                (Some(most), Some(asked)) if *asked > most => {
                    return Err(invalid(field("rate_hz"), asked, &format!("at most {most}: the scene has no more")));
                }
                // Who names no rate of its own gets as much as there is.
                (Some(most), _) => rate = rate.min(most),
                (None, _) => {}
            }
        }
        if !life.is_over(tick) {
            units.push((*unit, interval_of_rate(rate)));
        }
    }
    Ok(units)
}

fn check_rate(field: &str, rate_hz: u32) -> Result<(), ClientError> {
    if RATES_HZ.contains(&rate_hz) {
        return Ok(());
    }
    Err(invalid(field.to_owned(), rate_hz, &format!("one of {RATES_HZ:?}")))
}

/// Checks a wish for points; gives its interval in ticks.
///
/// # Errors
/// [`ClientError`] naming the field that is wrong, its value and its bound.
pub fn check_points(points: &Points) -> Result<i64, ClientError> {
    check_rate("rate_hz", points.rate_hz)?;
    if points.points.len() > MAX_POINTS {
        return Err(invalid("points".to_owned(), points.points.len(), &format!("at most {MAX_POINTS}")));
    }
    Ok(interval_of_rate(points.rate_hz))
}

/// The refusal of points beyond what all clients together may follow.
pub fn no_room_for_points(asked: usize, left: usize) -> ClientError {
    let detail = format!("{asked} points are asked for, and {left} more can be followed, all clients taken together");
    ClientError { code: ErrorCode::Unavailable, field: Some("points".to_owned()), detail }
}

/// The refusal of points where there are none.
pub fn no_points() -> ClientError {
    let detail = "a recording has no points to follow; ask for those of one moment by POST .../probe".to_owned();
    ClientError { code: ErrorCode::Unavailable, field: Some("points".to_owned()), detail }
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

/// The refusal of a unit that was not recorded.
pub fn not_recorded(index: usize, had: &[UnitName]) -> ClientError {
    let name = |unit: &UnitName| {
        let UnitName { cascade, level, class, group, codec } = unit;
        format!("{cascade}/{level}/{}/{}/{}", group.name(), class.name(), codec.name())
    };
    let had: Vec<String> = had.iter().map(name).collect();
    let detail = format!("units[{index}] was not recorded; cascade, level, group, class, codec: {}", had.join(" "));
    ClientError { code: ErrorCode::Unavailable, field: Some(format!("units[{index}]")), detail }
}

fn invalid(field: String, value: impl std::fmt::Display, bound: &str) -> ClientError {
    let detail = format!("{field} is {value}, must be {bound}");
    ClientError { code: ErrorCode::Invalid, field: Some(field), detail }
}
