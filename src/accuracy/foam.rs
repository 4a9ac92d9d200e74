//! How often foam is advanced: its recursion at several steps, beside one of 120 Hz, on the same Jacobians.

use super::axis::{Draft, axis};
use super::errors::{Errors, mean, rms};
use super::ground::{Ground, spots};
use super::report::{Axis, Cost, Measure};
use crate::backend::{Backend, Cpu};
use crate::plan::{CascadePlan, Field, FieldSet, FoamWork, Plan};
use crate::reference;
use crate::scene::Foam;
use crate::sea::{HeldFoam, Sea};
use crate::wire::TICKS_PER_SECOND;

/// Steps a second that are compared.
pub const STEPS_HZ: [i64; 5] = [10, 15, 20, 30, 60];
/// What they are compared with.
const FINEST_HZ: i64 = 120;

/// Steps a second of foam. Nothing where the scene has none, or its water never breaks.
pub fn foam(ground: &Ground, left_out: &mut Vec<String>) -> Option<Axis> {
    let settings = ground.scene.effects.foam;
    let breaking = ground.sea.cascades.iter().position(|modes| modes.breaks());
    let (Some(foam), Some(cascade)) = (settings, breaking) else {
        left_out.push("foam step: the scene has no foam, or no water that breaks".to_owned());
        return None;
    };
    let side = if ground.quick { 16 } else { 32 };
    let made = by_step(&ground.sea, cascade, &foam, ground.tick, side);
    let one = Sea { cascades: vec![ground.sea.cascades[cascade].clone()], ..ground.sea.clone() };
    let work = FoamWork { restart: false, decay: 0.9, growth: 0.5, advance: true, breaks: true };
    let fields = FieldSet::of(&[Field::Foam]);
    let plan = Plan { cascades: vec![CascadePlan::new([(0, fields)], Some(work), &ground.scene.effects)] };
    let mut cpu = Cpu::new(None);
    cpu.load(&one).expect("the CPU takes every sea");
    let step = |round: i64| {
        cpu.step(ground.tick + round * 720, &plan).expect("the plan is of this sea");
    };
    let step = super::timing::interleaved(ground.clock, ground.rounds, &mut [Box::new(step)])[0];
    let draft =
        |(hz, errors): (i64, Errors)| Draft::new(format!("{hz} Hz"), errors).timed(step.times(hz as f64 / 30.0));
    let about = format!(
        "Steps of foam a second, beside {FINEST_HZ}, of cascade {cascade}. What is shown between steps is worked out from \
         the last one. The time is that of its steps in one thirtieth of a second."
    );
    Some(axis(ground, "foam step", about, (Measure::Foam, Cost::Time), made.into_iter().map(draft).collect()))
}

/// What foam at each of [`STEPS_HZ`] errs at a tick, at `side` x `side` places of a cascade.
pub fn by_step(sea: &Sea, cascade: usize, foam: &Foam, tick: i64, side: usize) -> Vec<(i64, Errors)> {
    let modes = &sea.cascades[cascade];
    let [xs, zs] = spots(modes.cascade.patch_m, side);
    let interval = |hz: i64| TICKS_PER_SECOND / hz;
    let finest = interval(FINEST_HZ);
    // All grids of steps meet here, and everything before it is forgotten by the tick.
    let slowest = interval(STEPS_HZ[0]);
    let begin = (tick - foam.memory_ticks()).div_euclid(slowest) * slowest;
    let mut held: Vec<(i64, Vec<HeldFoam>)> = STEPS_HZ
        .into_iter()
        .chain([FINEST_HZ])
        .map(|hz| (interval(hz), vec![HeldFoam::default(); side * side]))
        .collect();
    let mut shown: Vec<Vec<f64>> = vec![Vec::new(); held.len()];
    for now in (begin..tick).step_by(finest as usize).chain([tick]) {
        if now != tick && held.iter().all(|(interval, _)| now % interval != 0) {
            continue;
        }
        let jacobians = jacobians(sea, cascade, now, &xs, &zs);
        for ((interval, held), shown) in held.iter_mut().zip(&mut shown) {
            let last = now == tick;
            if !last && now % *interval != 0 {
                continue;
            }
            let since = if last { now - (now - 1).div_euclid(*interval) * *interval } else { *interval };
            let (decay, growth) = (foam.decay_over(since) as f32, foam.growth_over(since) as f32);
            for (held, jacobian) in held.iter_mut().zip(&jacobians) {
                *held = held.step(*jacobian, modes.foam_threshold as f32, decay, growth);
            }
            if last {
                *shown = held.iter().map(|held| f64::from(held.foam)).collect();
            }
        }
    }
    let truth = shown.pop().unwrap_or_default();
    let covered = |foam: &[f64]| mean(foam.iter().map(|foam| f64::from(u8::from(*foam > Foam::COVERS))));
    let errors = |made: &Vec<f64>| Errors {
        foam: Some(rms(made.iter().zip(&truth).map(|(made, truth)| made - truth))),
        foam_coverage: Some((covered(made) - covered(&truth)).abs()),
        ..Errors::default()
    };
    STEPS_HZ.into_iter().zip(shown.iter().map(errors)).collect()
}

fn jacobians(sea: &Sea, cascade: usize, tick: i64, xs: &[f64], zs: &[f64]) -> Vec<f32> {
    let of = |fields: &[f64; 11]| {
        let at = |field: Field| fields[field as usize];
        ((1.0 + at(Field::Dxx)) * (1.0 + at(Field::Dzz)) - at(Field::Dxz).powi(2)) as f32
    };
    reference::lattice(sea, cascade, tick, xs, zs).iter().map(of).collect()
}
