//! What is computed now and what it costs: the passes of the live demand, and each effect measured on this machine.

use std::sync::Arc;

use serde_json::{Value, json};
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;

use super::ocean::Ocean;
use crate::backend::{BackendError, Cpu};
use crate::body::Problem;
use crate::engine::{EffectCost, effect_costs, fields_of_points};
use crate::plan::Listing;
use crate::sea::Cascade;
use crate::wire::{TICKS_PER_SECOND, UnitName};

/// Costs of the effects, once they were measured.
#[derive(Debug, Default)]
pub struct Costs(Arc<Mutex<Option<Measured>>>);

/// Cascades, and what the effects cost on them.
type Measured = (Vec<Cascade>, Vec<EffectCost>);

/// The body of `GET /v1/scenes/{name}/plan`. The first answer of a layout measures for a second or two, on threads and
/// memory of its own; frames go on meanwhile.
pub async fn plan(ocean: &Arc<Ocean>) -> Result<(u64, Value), Problem> {
    let current = ocean.current();
    let (timeline, demand) = (current.timeline, ocean.demand());
    let effects = costs(ocean).await?;
    let counters = ocean.counters();
    let (tick, of) = (ocean.tick(), demand.clone());
    let points = ocean.points.interval().map(|interval| (fields_of_points(timeline.scene()), interval));
    let list = move || Listing::new(&of, points, timeline.layout(), timeline.scene(), &timeline.at(tick));
    let Ok(listing) = spawn_blocking(list).await else { return Err(Problem::internal("the plan can't be made")) };
    let Ok(mut body) = serde_json::to_value(listing) else { return Err(Problem::internal("the plan can't be told")) };
    let unit = |(unit, interval): (&UnitName, &i64)| {
        let mut told = json!(unit);
        told["rate_hz"] = json!(TICKS_PER_SECOND / interval);
        told
    };
    body["tick"] = json!(tick);
    body["points"] = json!(ocean.points.live());
    body["units"] = demand.iter().map(unit).collect();
    body["frame"] = json!({
        "last_ms": counters.step_ms,
        "mean_ms": if counters.steps > 0 { counters.step_seconds * 1e3 / counters.steps as f64 } else { 0.0 },
        "steps": counters.steps,
    });
    body["effects"] = json!(effects);
    body["backend"] = json!(counters.backend);
    Ok((current.sequence, body))
}

async fn costs(ocean: &Arc<Ocean>) -> Result<Vec<EffectCost>, Problem> {
    // The lock goes with the work: whoever hangs up leaves it to be finished, and no second one begins meanwhile.
    let mut known = Arc::clone(&ocean.costs.0).lock_owned().await;
    let timeline = ocean.current().timeline;
    let cascades = timeline.layout().cascades.clone();
    if let Some((_, costs)) = known.as_ref().filter(|(of, _)| *of == cascades) {
        return Ok(costs.clone());
    }
    let (threads, clock, tick) = (ocean.settings.engine.threads, ocean.clock, ocean.tick());
    let measure = move || {
        let costs = effect_costs(&mut Cpu::new(threads), &timeline, tick, &clock)?;
        *known = Some((cascades, costs.clone()));
        Ok::<_, BackendError>(costs)
    };
    match spawn_blocking(measure).await {
        Ok(Ok(costs)) => Ok(costs),
        _ => Err(Problem::internal("the effects can't be measured")),
    }
}
