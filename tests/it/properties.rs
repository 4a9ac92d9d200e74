//! Laws over the whole space of scenes and over random sequences of changes; the draws are the same every time.

mod space;

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestCaseResult, TestRng, TestRunner};
use swellcast::backend::{Backend, Cpu, Surface};
use swellcast::engine::{ProbeFields, ProbeMethod, Prober};
use swellcast::plan::{CascadePlan, Field, FieldSet, FoamWork, Plan};
use swellcast::scene::{Change, ChangeKind, Foam, SceneError, SceneFile, SeaState};
use swellcast::sea::{CascadeModes, EnergyTable, Sea, Timeline};
use swellcast::wire::MAX_TICK;

use crate::support::{DAY, TEN_YEARS, scene};

const SECOND: i64 = 7200;
/// How much more Hs than what is wanted the cells' quadrature may find.
const QUADRATURE: f64 = 2e-3;

/// A runner that draws the same cases on every machine; `PROPTEST_CASES` can only make them more.
fn runner(cases: u32) -> TestRunner {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    let config =
        Config { cases: cases.max(asked), failure_persistence: None, max_shrink_iters: 2000, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

/// All fields, and foam that grows from nothing where the scene has foam.
fn everything(timeline: &Timeline) -> Plan {
    let effects = &timeline.scene().effects;
    let work = effects.foam.map(|foam| FoamWork {
        restart: true,
        decay: foam.decay_over(Foam::STEP_TICKS) as f32,
        growth: foam.growth_over(Foam::STEP_TICKS) as f32,
        advance: true,
        breaks: true,
    });
    let fields = FieldSet::of(&Field::ALL).difference(FieldSet::of(&[Field::Foam]));
    let cascade = CascadePlan::new([(0, fields)], work, effects);
    Plan { cascades: vec![cascade; timeline.layout().cascades.len()] }
}

/// The highest that a cascade's modes can add up to. Those with n = 0 stand for themselves, all others for two.
fn highest(modes: &CascadeModes) -> f64 {
    let of = |(i, mode): (usize, &swellcast::sea::Mode)| {
        let times = if i < modes.rows() { 1.0 } else { 2.0 };
        times * (mode.forward.norm() + mode.backward.norm())
    };
    modes.modes.iter().enumerate().map(of).sum()
}

/// Every number of a surface is finite, no height is beyond what its modes add up to, foam is a share.
fn holds(sea: &Sea, surface: &Surface, tick: i64) -> TestCaseResult {
    prop_assert_eq!(surface.tick, tick);
    for (index, (cascade, modes)) in surface.cascades.iter().zip(&sea.cascades).enumerate() {
        let most = highest(modes) * (1.0 + 1e-4) + 1e-30;
        prop_assert!(most.is_finite(), "cascade {}: the modes add up to {}", index, most);
        for field in Field::ALL {
            let Some(plane) = cascade.plane(field) else { continue };
            prop_assert_eq!(plane.len(), cascade.n * cascade.n);
            let fits = |value: f32| match field {
                Field::Height => f64::from(value).abs() <= most,
                Field::Foam => (0.0..=1.0).contains(&value),
                _ => value.is_finite(),
            };
            let wrong = plane.iter().position(|value| !fits(*value));
            let wrong = wrong.map(|at| format!("{} of cascade {index} at tick {tick} is {}", field.name(), plane[at]));
            prop_assert!(wrong.is_none(), "{} (modes add up to {})", wrong.unwrap_or_default(), most);
        }
    }
    Ok(())
}

fn step(cpu: &RefCell<Cpu>, timeline: &Timeline, ticks: &[i64]) -> TestCaseResult {
    let mut cpu = cpu.borrow_mut();
    let plan = everything(timeline);
    let fail = |error| TestCaseError::fail(format!("{error}"));
    for &tick in ticks {
        let sea = timeline.at(tick);
        cpu.load(&sea).map_err(fail)?;
        holds(&sea, cpu.step(tick, &plan).map_err(fail)?, tick)?;
    }
    Ok(())
}

/// A refusal names what it is about.
fn named(error: &SceneError) -> TestCaseResult {
    let text = error.to_string();
    match error {
        SceneError::Bound { field, bound, .. } => {
            prop_assert!(!field.is_empty() && !bound.is_empty() && text.contains(field.as_str()), "{}", text);
        }
        SceneError::Form(_) | SceneError::Measured(_) => prop_assert!(text.len() > 10, "{}", text),
    }
    Ok(())
}

#[test]
fn a_scene_is_refused_by_name_or_gives_a_finite_sea_for_ever() {
    let (cpu, built, refused) = (RefCell::new(Cpu::new(Some(2))), Cell::new(0), Cell::new(0));
    let law = |file: SceneFile| {
        let checked = match file.clone().check(None) {
            Ok(scene) => scene,
            Err(error) => {
                refused.set(refused.get() + 1);
                return named(&error);
            }
        };
        built.set(built.get() + 1);
        let again = SceneFile::from(&checked);
        let read = toml::to_string(&again).map(|text| SceneFile::from_toml(&text));
        prop_assert_eq!(read, Ok(Ok(again.clone())), "written as text and read");
        prop_assert_eq!(again.check(None), Ok(checked.clone()), "written back");
        let timeline = Timeline::new(&checked);
        let (hs, wanted) = (timeline.hs_at(0), timeline.wanted_hs_at(0));
        prop_assert!(hs.is_finite() && wanted.is_finite(), "Hs {} of {}", hs, wanted);
        let most = wanted * (1.0 + QUADRATURE);
        prop_assert!(hs <= most, "Hs {} of {} wanted: {}", hs, wanted, hs / wanted);
        step(&cpu, &timeline, &[0, DAY, TEN_YEARS, MAX_TICK])
    };
    let outcome = runner(2000).run(&space::scene_files(), law);
    let (built, refused) = (built.get(), refused.get());
    println!("{built} scenes were built, {refused} refused");
    if let Err(error) = outcome {
        panic!("{error}");
    }
    assert!(built > refused, "{built} scenes were built: the space has become all refusals");
}

#[test]
fn any_point_of_any_scene_has_finite_water_or_is_told_to_fold() {
    let metres = prop_oneof![Just(0.0), Just(-0.0), Just(1e9), Just(5e-324), -1e9..1e9, -100.0..100.0];
    let law = |(file, points): (SceneFile, Vec<[f64; 2]>)| {
        let Ok(scene) = file.check(None) else { return Ok(()) };
        let mut prober = Prober::new(Box::new(Cpu::new(Some(2))), Arc::new(Timeline::new(&scene)));
        for (tick, method) in [(0, ProbeMethod::Grid), (TEN_YEARS, ProbeMethod::Direct { share: 0.9 })] {
            let probed = prober.probe(tick, &points, ProbeFields::ALL, method);
            let probed = probed.map_err(|error| TestCaseError::fail(error.to_string()))?;
            for answer in probed.answers {
                let numbers = [answer.height, answer.residual, answer.jacobian.unwrap_or(f64::NAN)];
                let vectors = [answer.normal.unwrap_or_default(), answer.velocity.unwrap_or_default()];
                let all = numbers.iter().chain(vectors.iter().flatten()).chain(&answer.rest);
                prop_assert!(all.into_iter().all(|v| v.is_finite()), "{:?}", answer);
                prop_assert!(answer.folded || answer.residual < 1e-3, "{:?}", answer);
                let [x, y, z] = answer.normal.unwrap_or_default();
                prop_assert!(((x * x + y * y + z * z) - 1.0).abs() < 1e-9, "{:?}", answer);
                prop_assert!(answer.iterations <= 100, "{:?}", answer);
            }
        }
        Ok(())
    };
    let points = vec([metres.clone(), metres], 1..8);
    if let Err(error) = runner(150).run(&(space::scene_files(), points), law) {
        panic!("{error}");
    }
}

/// A change of the wind or of the depth somewhere in twenty seconds, at once or over up to twelve.
fn change() -> impl Strategy<Value = Change> {
    let speed = prop_oneof![Just(0.0), Just(100.0), 0.0..=100.0];
    let wind = (speed, 0.0..360.0)
        .prop_map(|(speed_mps, direction_from_deg)| ChangeKind::Wind { speed_mps, direction_from_deg });
    let depth = prop_oneof![Just(None), Just(Some(1e-3)), (-3.0..4.0).prop_map(|tens: f64| Some(10_f64.powf(tens)))];
    let gravity = prop_oneof![2 => Just(None), 1 => (0.1..=100.0).prop_map(Some)];
    let depth = depth.prop_map(|depth_m| Some(depth_m.unwrap_or(f64::INFINITY)));
    let water = (depth, gravity).prop_map(|(depth_m, gravity)| ChangeKind::Water { depth_m, gravity });
    let kind = prop_oneof![2 => wind, 1 => water];
    // Whole seconds, so that some begin at the same tick.
    let time = (0..20_i64, prop_oneof![Just(0), 1..=12 * SECOND]);
    (time, kind).prop_map(|((at, transition_ticks), kind)| {
        let effective_tick = (1 + at) * SECOND;
        Change { sequence: 0, effective_tick, transition_ticks, kind }
    })
}

#[test]
fn no_changes_in_any_order_make_a_sea_higher_than_the_highest_it_is_between() {
    // Chosen patches: what stands at the ends of a change must be cut as it is.
    let base = scene(
        "name = \"changing\"\n[wind]\nspeed_mps = 8.0\nrange_mps = [0.0, 100.0]\n[[swell]]\nhs_m = 0.5\n\
         [cascades]\nn = 16\npatches_m = [900.0, 400.0, 170.0]\n[effects]\nfoam = false",
    );
    let cpu = RefCell::new(Cpu::new(Some(2)));
    let law = |(mut changes, order): (Vec<Change>, Vec<prop::sample::Index>)| {
        (1..).zip(&mut changes).for_each(|(sequence, change)| change.sequence = sequence);
        let mut accepted = changes.clone();
        for (i, other) in order.iter().enumerate().take(changes.len()) {
            accepted.swap(i, other.index(changes.len()));
        }
        let timeline = accepted.iter().fold(Timeline::new(&base), |timeline, change| timeline.with(change.clone(), 0));

        changes.sort_by_key(|change| (change.effective_tick, change.sequence));
        let (mut scene, mut ends) = (base.clone(), Vec::new());
        let hs_of = |state: &SeaState| 4.0 * EnergyTable::build(state, timeline.layout()).resolved_m0().sqrt();
        ends.push(hs_of(&scene.sea));
        let mut ticks = vec![0, SECOND - 1, 60 * SECOND, MAX_TICK];
        for change in &changes {
            change.kind.apply(&mut scene);
            ends.push(hs_of(&scene.sea));
            let (at, long) = (change.effective_tick, change.transition_ticks);
            ticks.extend([at, at + 1, at + long / 3, at + long - 1, at + long]);
        }
        prop_assert_eq!(timeline.state_at(MAX_TICK), &scene.sea);
        let highest = ends.iter().copied().fold(0.0, f64::max);
        for &tick in &ticks {
            let hs = timeline.hs_at(tick);
            prop_assert!(hs.is_finite() && hs <= highest * (1.0 + 1e-9), "{} m at {} of {:?}", hs, tick, ends);
        }
        let last = (timeline.hs_at(60 * SECOND), ends[ends.len() - 1]);
        prop_assert!((last.0 - last.1).abs() <= 1e-9 * highest, "{} m at last, not {}", last.0, last.1);
        // A step costs more than a sum of energies: in the middle of every change, and after all of them.
        let middles = changes.iter().map(|change| change.effective_tick + change.transition_ticks / 3);
        step(&cpu, &timeline, &middles.chain([MAX_TICK]).collect::<Vec<_>>())
    };
    let changes = (vec(change(), 1..=6), vec(any::<prop::sample::Index>(), 6));
    if let Err(error) = runner(128).run(&changes, law) {
        panic!("{error}");
    }
}
