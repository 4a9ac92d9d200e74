//! What each effect and each demand costs on this machine: measured, on a backend of its own.

use serde::Serialize;

use super::channels::counted;
use super::clock::Clock;
use super::timing::Times;

use crate::backend::{Backend, BackendError};
use crate::plan::{CascadePlan, Demand, Field, FieldSet, FoamWork, Plan, Wanted, levels_of};
use crate::scene::{Effects, Normals};
use crate::sea::{CascadeModes, Timeline};
use crate::wire::Group;

/// Steps that are not counted, and those that are.
const WARM_UP: usize = 2;
const ROUNDS: usize = 12;
/// Ticks between the steps.
const INTERVAL: i64 = 240;

/// What one effect takes when it is wanted alone, of every cascade, on the full grid unless it says otherwise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectCost {
    /// Name of the effect.
    pub effect: &'static str,
    /// Whether the scene has it.
    pub on: bool,
    /// Real fields that it transforms.
    pub transforms: usize,
    /// Samples of those.
    pub samples: usize,
    /// Time of a step.
    pub step: Times,
}

/// Every effect, with the fields that it is, its way of normals, and its level of detail.
fn effects() -> Vec<(&'static str, Vec<Field>, Option<Normals>, u8)> {
    use Field::{
        Dx, Dxx, Dxz, Dz, Dzz, Eigenvalue, Foam, Height, Jacobian, NormalX, NormalZ, SlopeX, SlopeZ, VelocityX,
        VelocityY, VelocityZ,
    };
    let plain = |name, fields| (name, fields, None, 0);
    let normals = |name, way| (name, vec![NormalX, NormalZ], Some(way), 0);
    let waves: Vec<Field> = Field::ALL.into_iter().filter(|field| *field != Foam).collect();
    vec![
        plain("height", vec![Height]),
        plain("chop", vec![Dx, Dz]),
        plain("slopes", vec![SlopeX, SlopeZ]),
        ("normals exact", vec![SlopeX, SlopeZ, Dxx, Dzz, Dxz], Some(Normals::Exact), 0),
        ("normals diagonal", vec![SlopeX, SlopeZ, Dxx, Dzz], Some(Normals::Diagonal), 0),
        normals("normals displaced-slopes", Normals::DisplacedSlopes),
        normals("normals central-difference", Normals::CentralDifference),
        normals("normals sobel", Normals::Sobel),
        plain("jacobian and eigenvalue", vec![Jacobian, Eigenvalue]),
        plain("velocity", vec![VelocityX, VelocityY, VelocityZ]),
        plain("foam", vec![Foam]),
        plain("all waves", waves.clone()),
        ("all waves, level 1", waves.clone(), None, 1),
        ("all waves, level 2", waves, None, 2),
    ]
}

/// Measures every effect alone, in interleaved rounds.
///
/// # Errors
/// [`BackendError`] of the backend.
pub fn effect_costs(
    backend: &mut dyn Backend,
    timeline: &Timeline,
    tick: i64,
    clock: &Clock,
) -> Result<Vec<EffectCost>, BackendError> {
    let (layout, scene, sea) = (timeline.layout(), timeline.scene(), timeline.at(tick));
    let work = FoamWork { restart: false, decay: 0.9, growth: 0.5, advance: true, breaks: true };
    let mut costs = Vec::new();
    let mut plans = Vec::new();
    for (effect, fields, normals, level) in effects() {
        let foam = fields.contains(&Field::Foam);
        let way = Effects { normals: normals.unwrap_or_default(), ..scene.effects };
        let cascade = |modes: &CascadeModes| {
            let work = FoamWork { breaks: modes.breaks(), ..work };
            let level = level.min(modes.cascade.levels() - 1);
            CascadePlan::new([(level, FieldSet::of(&fields))], foam.then_some(work), &way).by(scene.model)
        };
        let plan = Plan { cascades: sea.cascades.iter().map(cascade).collect() };
        let on = match (effect, normals) {
            ("chop", _) => scene.effects.choppiness > 0.0,
            ("slopes", _) => scene.effects.slopes,
            ("jacobian and eigenvalue", _) => scene.effects.jacobian,
            ("velocity", _) => scene.effects.velocity,
            ("foam", _) => scene.effects.foam.is_some(),
            (_, Some(way)) => scene.effects.normals == way,
            _ => true,
        };
        let (transforms, samples) = plan.work(layout);
        costs.push(EffectCost { effect, on, transforms, samples, step: Times::default() });
        plans.push(plan);
    }
    backend.load(&sea)?;
    for (cost, step) in costs.iter_mut().zip(step_times(backend, &plans, tick, clock)?) {
        cost.step = step;
    }
    Ok(costs)
}

/// Measures a frame in which every unit of a demand is due; encoding is not in it.
///
/// # Errors
/// [`BackendError`] of the backend.
pub fn demand_cost(
    backend: &mut dyn Backend,
    timeline: &Timeline,
    demand: &Demand,
    tick: i64,
    clock: &Clock,
) -> Result<Times, BackendError> {
    // Counts are looked at, as they are of frames that are sent.
    let work = FoamWork { restart: false, decay: 0.9, growth: 0.5, advance: true, breaks: true };
    let (scene, sea) = (timeline.scene(), timeline.at(tick));
    let cascade = |modes: &CascadeModes| {
        let (number, work) = (modes.cascade.index, FoamWork { breaks: modes.breaks(), ..work });
        let units = demand.keys().filter(move |unit| unit.cascade == number);
        let foamy = scene.effects.foam.is_some() && units.clone().any(|unit| unit.group == Group::Foam);
        let counts = units.clone().flat_map(|unit| counted(*unit, 1.0)).collect();
        let wanted = Wanted { counts, samples: FieldSet::NONE };
        CascadePlan::new(levels_of(units), foamy.then_some(work), &scene.effects).by(scene.model).leaving(wanted)
    };
    let plan = Plan { cascades: sea.cascades.iter().map(cascade).collect() };
    backend.load(&sea)?;
    Ok(step_times(backend, &[plan], tick, clock)?[0])
}

fn step_times(backend: &mut dyn Backend, plans: &[Plan], tick: i64, clock: &Clock) -> Result<Vec<Times>, BackendError> {
    let mut times = vec![Vec::with_capacity(ROUNDS); plans.len()];
    for round in 0..WARM_UP + ROUNDS {
        for (plan, times) in plans.iter().zip(&mut times) {
            let started = clock.now_us();
            backend.step(tick.saturating_add(round as i64 * INTERVAL), plan)?;
            if round >= WARM_UP {
                times.push((clock.now_us() - started) as f64 / 1e3);
            }
        }
    }
    Ok(times.into_iter().map(Times::of).collect())
}
