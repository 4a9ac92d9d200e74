//! Frames by the GPU: quantised there, one step from the CPU's at most, and what a lost device does.

use std::collections::BTreeMap;
use std::sync::Arc;

use swellcast::backend::{Backend, BackendError, Cpu, Storage};
use swellcast::engine::Stepper;
use swellcast::plan::Demand;
use swellcast::plan::Field;
use swellcast::sea::Timeline;
use swellcast::tile::decode;
use swellcast::wire::{ErrorClass, Group, POINTS_HEADER_BYTES, UnitName};

use super::gpu;
use crate::support::{plan, wind_sea};

/// Every group at two levels and in two classes.
fn demand(cascades: u8) -> Demand {
    let mut demand = Demand::new();
    for (cascade, group) in (0..cascades).flat_map(|c| Group::ALL.map(|g| (c, g))) {
        for (level, class) in [(0, ErrorClass::Millimetre), (1, ErrorClass::FiveMillimetres)] {
            demand.insert(UnitName { cascade, level, class, group }, 240);
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
    for (unit, frame) in batch.frames {
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
    gpu.lose();
    for tick in [240, 480] {
        assert!(matches!(gpu.step(tick, &plan), Err(BackendError::DeviceLost(_))), "tick {tick}");
    }
}
