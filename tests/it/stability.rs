//! The hard cases of the table, each on every backend; their pairs; and every number as anything at all.

mod anything;
mod page;
mod pairs;
mod table;

use swellcast::backend::{Backend, Cpu};
use swellcast::engine::Stepper;
use swellcast::plan::Demand;
use swellcast::plan::{Field, FieldSet};
use swellcast::scene::{Model, Scene, SceneError, SceneFile};
use swellcast::sea::Timeline;
use swellcast::wire::{Codec, ErrorClass, Group, MAX_TICK, UnitName};

use crate::support::{DAY, TEN_YEARS};
use table::{CASES, Must};

/// Moments that every sea must hold, the last a little before the last tick there is.
const TICKS: [i64; 5] = [0, DAY + 17, 30 * DAY, TEN_YEARS + 4711, MAX_TICK - 7200];

/// Largest water level over significant height that is no lie: 1e5 samples of a random sea reach 1.2.
const HIGHEST: f64 = 3.0;

/// Every backend there is for this scene.
fn backends(scene: &Scene) -> Vec<Box<dyn Backend>> {
    let mut all: Vec<Box<dyn Backend>> = vec![Box::new(Cpu::new(Some(2)))];
    #[cfg(feature = "gpu")]
    if scene.model == Model::Fft {
        all.extend(crate::gpu::lent().map(|gpu| -> Box<dyn Backend> { Box::new(gpu) }));
    }
    all
}

fn build(file: SceneFile) -> Result<Scene, SceneError> {
    file.check(None)
}

/// Holds a scene to what is promised of every sea: finite, bounded, moving, of the energy that it tells, and fit to be
/// sent. Says what is wrong.
fn holds(scene: &Scene, ticks: &[i64]) -> Result<(), String> {
    let timeline = Timeline::new(scene);
    let statistics = timeline.statistics_at(0);
    let (hs, wanted) = (statistics.hs_m, statistics.wanted_hs_m);
    if !(hs.is_finite() && wanted.is_finite() && hs <= wanted * 1.01 + 1e-9) {
        return Err(format!("Hs {hs} of {wanted}"));
    }
    let numbers = serde_json::to_string(&statistics).unwrap();
    // A number that is not finite is written as null; these may be absent, the others not.
    if ["hs_m\":null", "mean_square_slope\":null", "coverage\":null", "fraction\":null"]
        .iter()
        .any(|n| numbers.contains(n))
    {
        return Err(numbers);
    }
    bounded(&timeline, hs, ticks)?;
    for backend in backends(timeline.scene()) {
        let mut stepper = Stepper::new(backend, timeline.clone().into(), 1);
        frames_are_made(&mut stepper, &timeline, &ticks[..1])?;
    }
    moves(&timeline, hs)
}

/// Every sample is finite, foam from 0 to 1, and no water higher than a sea of this height can be.
fn bounded(timeline: &Timeline, hs: f64, ticks: &[i64]) -> Result<(), String> {
    for backend in backends(timeline.scene()) {
        let name = backend.name();
        let mut stepper = Stepper::new(backend, timeline.clone().into(), 1);
        for (place, &tick) in ticks.iter().enumerate() {
            let all = FieldSet::of(&Field::ALL);
            // A software GPU takes most of its time for foam's memory, and what it holds follows from all the other fields.
            let fields = if name == "cpu" || place == 0 { all } else { all.difference(FieldSet::of(&[Field::Foam])) };
            let surface = stepper.surface(tick, fields).map_err(|e| e.to_string())?;
            let mut highest = 0.0;
            for (index, cascade) in surface.cascades.iter().enumerate() {
                for field in Field::ALL {
                    let plane = cascade.plane(field).unwrap_or(&[]);
                    if let Some(wrong) = plane.iter().find(|v| !v.is_finite()) {
                        return Err(format!("{name}: {field:?} of cascade {index} is {wrong} at tick {tick}"));
                    }
                    if field == Field::Foam && plane.iter().any(|f| !(0.0..=1.0).contains(f)) {
                        return Err(format!("{name}: foam of cascade {index} is not from 0 to 1 at tick {tick}"));
                    }
                }
                let heights = cascade.plane(Field::Height).unwrap_or(&[]);
                highest += heights.iter().fold(0.0_f32, |most, h| most.max(h.abs()));
            }
            if f64::from(highest) > HIGHEST * hs + 1e-6 {
                return Err(format!("{name}: water {highest} m high at tick {tick} with Hs {hs} m"));
            }
        }
    }
    Ok(())
}

/// Every group of every cascade makes its frames, saturated or not.
fn frames_are_made(stepper: &mut Stepper, timeline: &Timeline, ticks: &[i64]) -> Result<(), String> {
    let foam = timeline.scene().effects.foam.is_some();
    let groups = Group::ALL.into_iter().filter(|group| foam || *group != Group::Foam);
    let unit = |cascade, group| {
        (UnitName { cascade, level: 0, class: ErrorClass::HalfMillimetre, group, codec: Codec::I16 }, 1)
    };
    let numbers: Vec<u8> = timeline.layout().cascades.iter().map(|cascade| cascade.index).collect();
    let demand: Demand = groups.flat_map(|group| numbers.iter().map(move |n| unit(*n, group))).collect();
    stepper.set_demand(&demand);
    for &tick in ticks {
        while stepper.warm_foam(tick).map_err(|e| e.to_string())? {}
        let batch = stepper.frames(tick, &demand).map_err(|e| e.to_string())?;
        let units: std::collections::BTreeSet<_> = batch.frames.iter().map(|frame| frame.unit).collect();
        if batch.refused > 0 || units.len() != demand.len() {
            return Err(format!(
                "{} of {} frames, {} refused, at tick {tick}",
                units.len(),
                demand.len(),
                batch.refused
            ));
        }
    }
    Ok(())
}

/// A sea with waves is neither flat nor frozen.
fn moves(timeline: &Timeline, hs: f64) -> Result<(), String> {
    if hs < 1e-6 {
        return Ok(());
    }
    let heights = |tick: i64| -> Vec<f32> {
        let cascades = timeline.layout().cascades.len();
        (0..cascades).flat_map(|c| crate::support::cpu_fields(timeline, tick, c, &[Field::Height]).remove(0)).collect()
    };
    // Hours apart: the slowest wave in a puddle needs minutes.
    let (a, b) = (heights(DAY), heights(DAY + 3600 * 7200 + 1234));
    let most = |values: &mut dyn Iterator<Item = f32>| f64::from(values.fold(0.0_f32, f32::max));
    let (height, change) =
        (most(&mut a.iter().map(|h| h.abs())), most(&mut a.iter().zip(&b).map(|(a, b)| (a - b).abs())));
    // A loop may close in that time; its waves have moved in between.
    let loops = timeline.scene().repeat.ticks < 1 << 32;
    if height < 0.1 * hs || (change < 0.01 * hs && !loops) {
        return Err(format!("Hs {hs} m, but the water is {height} m high and moves {change} m in an hour"));
    }
    Ok(())
}

#[test]
fn every_hard_case_holds_or_is_refused_by_name() {
    let mut wrong = Vec::new();
    for case in CASES {
        let file = SceneFile::from_toml(&format!("name = \"case\"\n{}", case.scene));
        let got = file.and_then(build);
        let verdict = match (&case.must, got) {
            (Must::Hold, Ok(scene)) => holds(&scene, &TICKS),
            (Must::Refuse(field), Err(error)) if error.field() == Some(field) => Ok(()),
            (Must::Refuse(field), Err(error)) => Err(format!("refused with {error}, not for {field}")),
            (Must::Refuse(field), Ok(_)) => Err(format!("accepted, must be refused for {field}")),
            (Must::Hold, Err(error)) => Err(format!("refused: {error}")),
        };
        if let Err(why) = verdict {
            wrong.push(format!("{} ({}): {why}", case.what, case.scene.replace('\n', " ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_sea_that_lies_is_found_out() {
    // Told a thousand times its height, it would be flat; told a thousandth, too high.
    let scene = crate::support::wind_sea(8.0, 32, &[100.0]);
    assert_eq!(holds(&scene, &TICKS), Ok(()));
    let timeline = Timeline::new(&scene);
    assert!(moves(&timeline, 1e3 * timeline.hs_at(0)).is_err(), "a flat sea passes");
    assert!(bounded(&timeline, 1e-3 * timeline.hs_at(0), &TICKS).is_err(), "water of any height passes");
}

#[test]
fn time_may_jump_by_hours_either_way() {
    let timeline = Timeline::new(&crate::support::wind_sea(14.0, 32, &[200.0, 40.0]));
    let units = [Group::Displacement, Group::Foam];
    let unit =
        |group| (UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::I16 }, 240);
    let demand: Demand = units.map(unit).into();
    let fresh = |tick: i64| {
        let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), timeline.clone().into(), 1);
        frames(&mut stepper, tick, &demand)
    };
    let mut jumping = Stepper::new(Box::new(Cpu::new(Some(1))), timeline.clone().into(), 1);
    for tick in [7200, 5 * 3600 * 7200, 7200, 2 * 3600 * 7200, TEN_YEARS / 240 * 240, 0] {
        let jumped = frames(&mut jumping, tick, &demand);
        assert_eq!(jumped.len(), 2);
        assert!(jumped == fresh(tick), "tick {tick}");
    }
}

fn frames(stepper: &mut Stepper, tick: i64, demand: &Demand) -> Vec<(UnitName, bytes::Bytes)> {
    stepper.set_demand(demand);
    while stepper.warm_foam(tick).unwrap() {}
    stepper.frames(tick, demand).unwrap().frames.into_iter().map(|frame| (frame.unit, frame.bytes)).collect()
}
