//! What is served now errs, told to whoever asks; worked out once however many ask.

use std::sync::Arc;

use serde_json::{Value, json};
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;

use super::ocean::Ocean;
use crate::accuracy::claims;
use crate::accuracy::serving::{errors_at, settings};
use crate::body::Problem;
use crate::sea::Timeline;
use crate::wire::{Codec, ErrorClass, Group, TICKS_PER_SECOND, UnitName};

/// How far from now a tick may lie that is asked for, ticks: 10 s.
const REACH: i64 = 10 * TICKS_PER_SECOND;

/// The claims that were worked out last.
#[derive(Debug, Default)]
pub struct Claims(Arc<Mutex<Option<Known>>>);

/// Newest entry of the log, tick, units, and what was told of them.
type Known = (u64, i64, Vec<UnitName>, Value);

/// The body of `GET /v1/scenes/{name}/accuracy`, and the newest entry of the log: what the layout leaves out of the sea and
/// what is lost between its samples (`sea`), and what each channel errs at the samples (`channels`). Of the units that somebody wants, or of
/// every group of the scene where nobody wants any; at the tick asked for, or at one of the last ten seconds.
///
/// # Errors
/// `Problem` for a tick out of reach.
pub async fn accuracy(ocean: &Arc<Ocean>, tick: Option<i64>) -> Result<(u64, Value), Problem> {
    let now = ocean.tick();
    let reach = now.saturating_sub(REACH).max(0)..=now.saturating_add(REACH);
    if let Some(tick) = tick.filter(|tick| !reach.contains(tick)) {
        let bound = format!("from {} to {}: within ten seconds of now", reach.start(), reach.end());
        return Err(Problem::value("tick", tick.into(), bound));
    }
    // The lock goes with the work: whoever hangs up leaves it to be finished, and no second one begins meanwhile.
    let mut known = Arc::clone(&ocean.claims.0).lock_owned().await;
    let current = ocean.current();
    let (sequence, timeline) = (current.sequence, current.timeline);
    let mut units: Vec<UnitName> = ocean.demand().into_keys().collect();
    if units.is_empty() {
        units = every_group(&timeline);
    }
    if let Some((of, at, same, told)) = &*known
        && (*of, same) == (sequence, &units)
        && tick.map_or(reach.contains(at), |tick| tick == *at)
    {
        return Ok((sequence, told.clone()));
    }
    let tick = tick.unwrap_or(now / TICKS_PER_SECOND * TICKS_PER_SECOND);
    let work = move || {
        let claims = claims(&timeline, tick, &units).ok()?;
        let finest_m = settings(timeline.scene()).first().map_or(0.0, |setting| setting.finest_m);
        let sea = errors_at(&timeline, finest_m, tick);
        let told = json!({ "tick": tick, "hs_m": timeline.hs_at(tick), "sea": sea, "channels": claims });
        *known = Some((sequence, tick, units, told.clone()));
        Some(told)
    };
    let told = spawn_blocking(work).await.ok().flatten();
    told.map(|told| (sequence, told)).ok_or_else(|| Problem::internal("the errors can't be worked out"))
}

/// Every group that the scene has, of every cascade, as clients take it by default.
fn every_group(timeline: &Timeline) -> Vec<UnitName> {
    let effects = &timeline.scene().effects;
    let groups = || Group::ALL.into_iter().filter(|group| effects.has(*group));
    let unit = |cascade, group| {
        let (class, codec) = (ErrorClass::Millimetre, Codec::Rans);
        UnitName { cascade, level: 0, class, group, codec }
    };
    let cascades = timeline.layout().cascades.iter().map(|cascade| cascade.index);
    cascades.flat_map(|cascade| groups().map(move |group| unit(cascade, group))).collect()
}
