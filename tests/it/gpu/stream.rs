//! Frames by the GPU: quantised there, one step from the CPU's at most, and what a lost device does.

use std::collections::BTreeMap;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use swellcast::backend::{Backend, BackendError, Cpu, Storage};
use swellcast::engine::{BackendChoice, Batch, Clock, Engine, EngineSettings, Opener, Stepper, interval_of_rate};
use swellcast::pass::quantise::{quantise, quantiser_step};
use swellcast::plan::Demand;
use swellcast::plan::Field;
use swellcast::sea::Timeline;
use swellcast::tile::{SentFrame, decode};
use swellcast::wire::{Codec, ErrorClass, Group, POINTS_HEADER_BYTES, UnitName};

use super::gpu;
use crate::support::{plan, wind_sea};

/// Every group at two levels and in two classes.
fn demand(cascades: u8) -> Demand {
    let mut demand = Demand::new();
    for (cascade, group) in (0..cascades).flat_map(|c| Group::ALL.map(|g| (c, g))) {
        for (level, class) in [(0, ErrorClass::Millimetre), (1, ErrorClass::FiveMillimetres)] {
            demand.insert(UnitName { cascade, level, class, group, codec: Codec::I16 }, 240);
        }
    }
    demand
}

/// Decoded planes of every unit, tiles in their order, of a stepper with this backend.
fn frames(backend: Box<dyn Backend>, timeline: &Timeline, tick: i64) -> BTreeMap<UnitName, (f32, Vec<f32>)> {
    let demand = demand(timeline.layout().cascades.len() as u8);
    let mut stepper = Stepper::new(backend, Arc::new(timeline.clone()), 1);
    stepper.set_demand(&demand);
    while stepper.warm_foam(tick).unwrap() {}
    let batch = stepper.frames(tick, &demand).unwrap();
    assert_eq!((batch.refused, batch.tick), (0, tick));
    let mut planes = BTreeMap::new();
    for SentFrame { unit, bytes: frame, .. } in batch.frames {
        let decoded = decode(&frame).unwrap();
        let (_, plane) = planes.entry(unit).or_insert((decoded.header.step[0], Vec::new()));
        plane.extend(decoded.planes.concat());
    }
    assert_eq!(planes.len(), demand.len());
    planes
}

#[test]
fn quantised_samples_are_one_step_from_the_cpus_at_most() {
    let Some(gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(14.0, 64, &[200.0, 40.0]));
    let (got, want) = (frames(Box::new(gpu), &timeline, 7200), frames(Box::new(Cpu::new(Some(2))), &timeline, 7200));
    for (unit, (step, want)) in want {
        let got = &got[&unit].1;
        let steps = got.iter().zip(&want).map(|(got, want)| ((got - want) / step).round().abs());
        let differ = steps.clone().filter(|steps| *steps > 0.0).count();
        if unit.group == Group::Foam {
            // At the threshold one may break where the other doesn't.
            assert!(differ * 200 <= want.len(), "{unit:?}: {differ} of {}", want.len());
            continue;
        }
        assert!(steps.clone().all(|steps| steps <= 1.0), "{unit:?} is off by {:?}", steps.fold(0.0, f32::max));
        // A mean difference of a millionth of the field over a step of a thousandth, and chance.
        assert!(differ * 100 <= want.len(), "{unit:?}: {differ} of {}", want.len());
        assert!(want.iter().any(|v| *v != 0.0), "{unit:?} is all zero");
    }
}

#[test]
fn followed_points_are_the_same_water() {
    let Some(gpu) = gpu(Storage::F32) else { return };
    let timeline = Arc::new(Timeline::new(&wind_sea(14.0, 64, &[200.0, 40.0])));
    let points = |backend: Box<dyn Backend>| {
        let mut stepper = Stepper::new(backend, Arc::clone(&timeline), 1);
        let points = (0..50).map(|i| [f64::from(i) * 3.7, f64::from(i) * -1.9]).collect();
        stepper.set_points(vec![swellcast::engine::PointsWish { client: 1, id: 1, interval: 240, points }]);
        stepper.frames(480, &Demand::new()).unwrap().points.remove(0).bytes
    };
    let (got, want) = (points(Box::new(gpu)), points(Box::new(Cpu::new(Some(1)))));
    assert_eq!(got.len(), want.len());
    let numbers = |bytes: &[u8]| -> Vec<f32> {
        bytes[POINTS_HEADER_BYTES..].as_chunks::<4>().0.iter().map(|word| f32::from_le_bytes(*word)).collect()
    };
    let apart = numbers(&got).into_iter().zip(numbers(&want)).filter(|(a, b)| (a - b).abs() > 1e-3 * (1.0 + b.abs()));
    assert_eq!(apart.count(), 0);
}

#[test]
fn a_device_that_is_lost_says_so_at_once() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(9.0, 32, &[150.0]));
    let sea = timeline.at(0);
    gpu.load(&sea).unwrap();
    let plan = plan(&sea, &[Field::Height]);
    assert!(gpu.step(0, &plan).is_ok());
    gpu.loss()();
    for tick in [240, 480] {
        assert!(matches!(gpu.step(tick, &plan), Err(BackendError::DeviceLost(_))), "tick {tick}");
    }
}

#[test]
fn what_the_device_refuses_is_told_and_not_passed_over() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(9.0, 32, &[150.0]));
    let sea = timeline.at(0);
    gpu.load(&sea).unwrap();
    // A petabyte is neither valid nor there.
    assert!(matches!(gpu.copy(1 << 50, 1), Err(BackendError::DeviceLost(_))));
    let plan = plan(&sea, &[Field::Height]);
    assert!(matches!(gpu.step(0, &plan), Err(BackendError::DeviceLost(_))), "and all that follows, too");
}

#[test]
fn a_device_destroyed_in_mid_stream_costs_no_tick() {
    if gpu(Storage::F32).is_none() {
        return;
    }
    let timeline = Arc::new(Timeline::new(&wind_sea(14.0, 32, &[120.0])));
    let unit =
        UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group: Group::Displacement, codec: Codec::I16 };
    let demand = Demand::from([(unit, interval_of_rate(15))]);
    let (tell, loss) = channel();
    let tell = Mutex::new(tell);
    let open = move || -> Result<Box<dyn Backend>, String> {
        let gpu = gpu(Storage::F32).ok_or("there is none")?;
        tell.lock().unwrap().send(Box::new(gpu.loss()) as Box<dyn Fn() + Send>).unwrap();
        Ok(Box::new(gpu))
    };
    let settings = EngineSettings {
        threads: Some(1),
        backend: BackendChoice::Gpu,
        opener: Some(Opener(Arc::new(open))),
        ..EngineSettings::default()
    };
    let (publish, batches) = channel();
    let publish = Mutex::new(publish);
    let publish = Box::new(move |batch| drop(publish.lock().unwrap().send(batch)));
    let clock = Clock::start(Clock::unix_now_ns());
    let engine = Engine::start(Arc::clone(&timeline), clock, 1, settings, publish);
    engine.set_demand(demand.clone());
    let next = || batches.recv_timeout(Duration::from_secs(20)).expect("frames come");
    while next().backend != "gpu" {}
    loss.recv().unwrap()();
    let mut made: Vec<Batch> = vec![next()];
    while made.len() < 10 || made[made.len() - 1].backend != "cpu" {
        made.push(next());
    }
    let interval = interval_of_rate(15);
    let missed: i64 = made.windows(2).map(|pair| (pair[1].tick - pair[0].tick) / interval - 1).sum();
    assert!(missed as u64 <= engine.counters().skipped_frames, "{missed} ticks are missing");
    assert_eq!(engine.counters().backend_losses, 1);
    // At the right tick, to the byte.
    let by_cpu = made.iter().find(|batch| batch.backend == "cpu").unwrap();
    let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), timeline, 1);
    assert!(stepper.frames(by_cpu.tick, &demand).unwrap().frames == by_cpu.frames);
}

#[test]
fn as_few_samples_differ_as_their_difference_is_small() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(14.0, 256, &[300.0]));
    let (sea, fields) = (timeline.at(0), [Field::Height, Field::Dx, Field::SlopeX, Field::Dxx]);
    let [got, want] = super::both(&mut gpu, &sea, 7200, &plan(&sea, &fields));
    for (field, group) in
        fields.into_iter().zip([Group::Height, Group::Displacement, Group::Slopes, Group::Derivatives])
    {
        let step = quantiser_step(ErrorClass::HalfMillimetre, group);
        let [got, want] = [&got, &want].map(|surface| surface.cascades[0].plane(field).unwrap());
        let counts = |plane: &[f32]| {
            let mut counts = vec![0i16; plane.len()];
            quantise(plane.iter().copied(), step, &mut counts);
            counts
        };
        let mean = got.iter().zip(want).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / got.len() as f64;
        let apart: Vec<i32> =
            counts(got).iter().zip(counts(want)).map(|(a, b)| (i32::from(*a) - i32::from(b)).abs()).collect();
        assert!(apart.iter().all(|apart| *apart <= 1), "{field:?}");
        // A threshold lies between two values as often as they are apart; twice that, and the chance of a few samples.
        let expected = mean / f64::from(step) * got.len() as f64;
        let differ = apart.iter().filter(|apart| **apart > 0).count();
        assert!(
            differ as f64 <= 2.0 * expected + 4.0 * expected.sqrt() + 4.0,
            "{field:?}: {differ}, not {expected:.1}"
        );
    }
}
