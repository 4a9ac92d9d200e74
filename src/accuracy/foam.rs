//! How often foam is advanced: its recursion at several steps, beside one of 120 Hz, on the same Jacobians.

use super::axis::{Draft, axis};
use super::errors::Errors;
use super::ground::{Ground, spots};
use super::report::{Axis, Cost, Measure};
use crate::backend::{Backend, Cpu};
use crate::engine::interleaved;
use crate::plan::{CascadePlan, Field, FieldSet, FoamWork, Plan};
use crate::reference;
use crate::scene::Foam;
use crate::sea::{HeldFoam, Sea};
use crate::wire::TICKS_PER_SECOND;

/// Steps a second that are compared.
pub const STEPS_HZ: [i64; 5] = [10, 15, 20, 30, 60];
/// What they are compared with.
const FINEST_HZ: i64 = 120;

/// Seconds before the tick over which what is shown is compared.
const COMPARED_S: i64 = 4;

/// Steps a second of foam. Nothing where the scene has none, or its water never breaks.
pub fn foam(ground: &Ground, left_out: &mut Vec<String>) -> Option<Axis> {
    let side = if ground.quick { 10 } else { 48 };
    let settings = ground.scene.effects.foam;
    let (Some(foam), Some(cascade)) = (settings, most_breaking(&ground.sea, ground.tick, side)) else {
        left_out.push("foam step: the scene has no foam, or no water that breaks".to_owned());
        return None;
    };
    let made = by_step(&ground.sea, cascade, &foam, ground.tick, side);
    let one = Sea { cascades: vec![ground.sea.cascades[cascade].clone()], ..ground.sea.clone() };
    let work = FoamWork { restart: false, decay: 0.9, growth: 0.5, advance: true, breaks: true };
    let fields = FieldSet::of(&[Field::Foam]);
    let plan = Plan { cascades: vec![CascadePlan::new([(0, fields)], Some(work), &ground.scene.effects)] };
    let mut cpu = Cpu::new(None);
    cpu.load(&one).expect("the CPU takes every sea");
    let step = |round: i64| {
        cpu.step(ground.tick + round * Foam::STEP_TICKS, &plan).expect("the plan is of this sea");
    };
    let step = interleaved(ground.clock, ground.rounds, &mut [Box::new(step)])[0];
    let draft =
        |(hz, errors): (i64, Errors)| Draft::new(format!("{hz} Hz"), errors).timed(step.times(hz as f64 / 30.0));
    let about = format!(
        "Steps of foam a second, beside {FINEST_HZ}, of cascade {cascade}, over {COMPARED_S} s. What is shown between steps \
         is worked out from the last one. The time is that of its steps in one thirtieth of a second."
    );
    Some(axis(ground, "foam step", about, (Measure::Foam, Cost::Time), made.into_iter().map(draft).collect()))
}

/// The cascade with the most water that breaks at a tick, of those that can.
fn most_breaking(sea: &Sea, tick: i64, side: usize) -> Option<usize> {
    let breaking = |cascade: &usize| {
        let modes = &sea.cascades[*cascade];
        let [xs, zs] = spots(modes.cascade.patch_m, side);
        let threshold = modes.foam_threshold as f32;
        jacobians(sea, *cascade, tick, &xs, &zs).into_iter().filter(|jacobian| *jacobian < threshold).count()
    };
    (0..sea.cascades.len()).filter(|cascade| sea.cascades[*cascade].breaks()).max_by_key(breaking)
}

/// What foam at each of [`STEPS_HZ`] errs in the seconds before a tick, at `side` x `side` places of a cascade.
pub fn by_step(sea: &Sea, cascade: usize, foam: &Foam, tick: i64, side: usize) -> Vec<(i64, Errors)> {
    let modes = &sea.cascades[cascade];
    let [xs, zs] = spots(modes.cascade.patch_m, side);
    let threshold = modes.foam_threshold as f32;
    let interval = |hz: i64| TICKS_PER_SECOND / hz;
    let finest = interval(FINEST_HZ);
    // All grids of steps meet here, and everything before it is forgotten by the time that is compared.
    let slowest = interval(STEPS_HZ[0]);
    let compared = tick - COMPARED_S * TICKS_PER_SECOND;
    let begin = (compared - foam.memory_ticks()).div_euclid(slowest) * slowest;
    let none = vec![HeldFoam::default(); side * side];
    let mut held: Vec<(i64, Vec<HeldFoam>)> = STEPS_HZ.map(|hz| (interval(hz), none.clone())).into();
    let mut truth = none;
    let mut sums = vec![Sums::default(); held.len()];
    for now in (begin..tick).step_by(finest as usize) {
        let due = |interval: i64| now % interval == 0;
        let jacobians = jacobians(sea, cascade, now, &xs, &zs);
        let step = |held: &HeldFoam, jacobian: &f32, since: i64| {
            held.step(*jacobian, threshold, foam.decay_over(since) as f32, foam.growth_over(since) as f32)
        };
        truth.iter_mut().zip(&jacobians).for_each(|(held, jacobian)| *held = step(held, jacobian, finest));
        for ((interval, held), sums) in held.iter_mut().zip(&mut sums) {
            // Of the last step, and not of this one where it is one.
            let since = (now - 1).rem_euclid(*interval) + 1;
            if !due(*interval) && now < compared {
                continue;
            }
            for ((held, jacobian), truth) in held.iter_mut().zip(&jacobians).zip(&truth) {
                let shown = step(held, jacobian, since);
                if due(*interval) {
                    *held = shown;
                }
                if now >= compared {
                    sums.add(shown.foam.into(), truth.foam.into());
                }
            }
        }
    }
    STEPS_HZ.into_iter().zip(sums.iter().map(Sums::errors)).collect()
}

/// Foam beside what it should be.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    square: f64,
    /// Samples that are covered, less those that should be.
    covered: f64,
}

impl Sums {
    fn add(&mut self, shown: f64, truth: f64) {
        let covers = |foam: f64| f64::from(u8::from(foam > Foam::COVERS));
        self.count += 1.0;
        self.square += (shown - truth).powi(2);
        self.covered += covers(shown) - covers(truth);
    }

    fn errors(&self) -> Errors {
        let count = self.count.max(1.0);
        Errors {
            foam: Some((self.square / count).sqrt()),
            foam_coverage: Some((self.covered / count).abs()),
            ..Errors::default()
        }
    }
}

fn jacobians(sea: &Sea, cascade: usize, tick: i64, xs: &[f64], zs: &[f64]) -> Vec<f32> {
    let of = |fields: &[f64; 11]| {
        let at = |field: Field| fields[field as usize];
        ((1.0 + at(Field::Dxx)) * (1.0 + at(Field::Dzz)) - at(Field::Dxz).powi(2)) as f32
    };
    reference::lattice(sea, cascade, tick, xs, zs).iter().map(of).collect()
}
