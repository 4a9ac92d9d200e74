//! Frames are a function of (log, seed, tick, unit): whoever makes them, whenever they began.

use std::collections::BTreeMap;
use std::sync::Arc;

use swellcast::backend::Cpu;
use swellcast::engine::{Batch, Stepper};
use swellcast::plan::Demand;
use swellcast::plan::{Field, FieldSet};
use swellcast::reference;
use swellcast::scene::{Change, ChangeKind, Foam, preset};
use swellcast::sea::Timeline;
use swellcast::tile::{Plane, SentFrame, Stamp, UnitEncoder, decode};
use swellcast::wire::{Codec, ErrorClass, FLAG_SATURATED, Group, UnitName, split};

use crate::support::{max_error, wind_sea};

const INTERVAL: i64 = 240;

fn unit(cascade: u8, group: Group) -> UnitName {
    UnitName { cascade, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::I16 }
}

fn everything(cascades: u8) -> Demand {
    (0..cascades).flat_map(|c| Group::ALL.map(|group| (unit(c, group), INTERVAL))).collect()
}

fn stepper(timeline: &Timeline, demand: &Demand) -> Stepper {
    let mut stepper = Stepper::new(Box::new(Cpu::new(Some(2))), Arc::new(timeline.clone()), 7);
    stepper.set_demand(demand);
    stepper
}

fn by_unit(batch: Batch) -> BTreeMap<UnitName, bytes::Bytes> {
    batch.frames.into_iter().map(|frame| (frame.unit, frame.bytes)).collect()
}

#[test]
fn a_server_that_began_later_sends_the_same_bytes_foam_included() {
    let at = 40 * 7200;
    let change = Change {
        sequence: 1,
        effective_tick: at,
        transition_ticks: 5 * 7200,
        kind: ChangeKind::Wind { speed_mps: 16.0, direction_from_deg: 200.0 },
    };
    let timeline = Timeline::new(&wind_sea(11.0, 64, &[300.0, 40.0])).with(change.clone(), 0);
    let demand = everything(2);
    // One runs through every frame of 30 s and the change; the other joins in the middle of the change.
    let mut old = stepper(&timeline, &demand);
    let joined = at + 2 * 7200;
    let mut tick = joined - 30 * 7200;
    while old.warm_foam(tick).unwrap() {}
    while tick < joined {
        old.frames(tick, &demand).unwrap();
        while old.warm_foam(tick + INTERVAL).unwrap() {}
        tick += INTERVAL;
    }
    let mut young = stepper(&Timeline::replay(timeline.scene(), &[change], joined), &demand);
    while young.warm_foam(joined).unwrap() {}
    let mut foam = 0;
    for frame in 0..6 {
        let tick = joined + frame * INTERVAL;
        let (old, young) = (by_unit(old.frames(tick, &demand).unwrap()), by_unit(young.frames(tick, &demand).unwrap()));
        assert_eq!(old.len(), 2 * Group::ALL.len(), "every unit is there, foam warm");
        assert!(old == young, "frames differ at tick {tick}");
        let plane = &decode(&old[&unit(1, Group::Foam)]).unwrap().planes[0];
        foam += plane.iter().filter(|f| **f > 0.1).count();
    }
    assert!(foam > 30, "the test must see foam, it saw {foam} samples");
}

#[test]
fn foam_is_absent_until_it_is_warm_and_other_frames_flow() {
    let timeline = Timeline::new(&wind_sea(11.0, 32, &[100.0]));
    let demand = everything(1);
    let mut stepper = stepper(&timeline, &demand);
    let cold = by_unit(stepper.frames(0, &demand).unwrap());
    assert!(!cold.contains_key(&unit(0, Group::Foam)) && cold.len() == Group::ALL.len() - 1);
    while stepper.warm_foam(INTERVAL).unwrap() {}
    assert!(by_unit(stepper.frames(INTERVAL, &demand).unwrap()).contains_key(&unit(0, Group::Foam)));
}

#[test]
fn foam_agrees_with_the_reference_recursion() {
    let timeline = Timeline::new(&wind_sea(14.0, 32, &[60.0]));
    let foam: Foam = timeline.scene().effects.foam.unwrap();
    for tick in [720 * 10, 720 * 10 + 240] {
        let mut stepper = stepper(&timeline, &Demand::new());
        let fast = stepper.surface(tick, FieldSet::of(&[Field::Foam])).unwrap();
        let fast = fast.cascades[0].plane(Field::Foam).unwrap().to_vec();
        let slow = reference::foam(&timeline, 0, tick, &foam);
        assert!(slow.iter().any(|f| *f > 0.1), "the test must see foam");
        // Foam just above 1/512 in one arithmetic may be flushed in the other.
        let error = max_error(&fast, &slow);
        assert!(error < 1.1 / 512.0, "{error}");
        let far = fast.iter().zip(&slow).filter(|(a, b)| (f64::from(**a) - **b).abs() > 1e-4).count();
        assert!(far < 5, "{far} samples differ by more than rounding");
    }
}

#[test]
fn every_sample_keeps_the_error_its_frame_promises() {
    let timeline = Timeline::new(&preset("beaufort-9").unwrap());
    let mut stepper = stepper(&timeline, &Demand::new());
    let tick = 9 * 7200;
    let surface = stepper.surface(tick, FieldSet::SPECTRAL).unwrap().clone();
    // Levels that hold every wave.
    let cascade = timeline.layout().cascades[0];
    let whole = (0..cascade.levels()).take_while(|level| cascade.level(*level).1 == cascade.half).count() as u8;
    let mut demand = Demand::new();
    for class in ErrorClass::ALL {
        for group in [Group::Displacement, Group::Slopes, Group::Derivatives] {
            for level in 0..whole {
                demand.insert(UnitName { cascade: 0, level, class, group, codec: Codec::I16 }, INTERVAL);
            }
        }
    }
    let fields = |group| match group {
        Group::Displacement => vec![Field::Dx, Field::Height, Field::Dz],
        Group::Slopes => vec![Field::SlopeX, Field::SlopeZ],
        _ => vec![Field::Dxx, Field::Dzz, Field::Dxz],
    };
    let batch = stepper.frames(tick, &demand).unwrap();
    assert_eq!(batch.frames.len(), demand.len());
    for SentFrame { unit, bytes: frame, .. } in batch.frames {
        let decoded = decode(&frame).unwrap();
        let (n, stride) = (usize::from(decoded.header.n), 1 << unit.level);
        for (c, field) in fields(unit.group).into_iter().enumerate() {
            let plane = surface.cascades[0].plane(field).unwrap();
            for (i, value) in decoded.planes[c].iter().enumerate() {
                let exact = plane[i / n * stride * 256 + i % n * stride];
                assert!(
                    // A level's own transform rounds otherwise.
                    (value - exact).abs() <= decoded.header.max_error[c] + 1e-5,
                    "{unit:?} {field:?}: {value} for {exact}"
                );
            }
        }
    }
}

#[test]
fn a_large_patch_is_cut_into_tiles_that_cover_it() {
    let timeline = Timeline::new(&wind_sea(9.0, 512, &[500.0]));
    let demand: Demand = [(unit(0, Group::Slopes), INTERVAL)].into();
    let mut stepper = stepper(&timeline, &demand);
    let batch = stepper.frames(0, &demand).unwrap();
    assert_eq!(batch.frames.len(), 4);
    let surface = stepper.surface(0, FieldSet::of(&[Field::SlopeX])).unwrap();
    let plane = surface.cascades[0].plane(Field::SlopeX).unwrap();
    for frame in batch.frames {
        let tile = decode(&frame.bytes).unwrap();
        let (x, z) = (usize::from(tile.header.tile_x) * 256, usize::from(tile.header.tile_z) * 256);
        assert_eq!((tile.header.n, tile.header.level_n), (256, 512));
        for (i, value) in tile.planes[0].iter().enumerate() {
            let exact = plane[(z + i / 256) * 512 + x + i % 256];
            assert!((value - exact).abs() <= tile.header.max_error[0]);
        }
    }
}

#[test]
fn no_demand_is_no_work() {
    let timeline = Timeline::new(&wind_sea(9.0, 32, &[100.0]));
    let mut stepper = stepper(&timeline, &Demand::new());
    assert!(!stepper.warm_foam(0).unwrap());
    assert_eq!(stepper.frames(0, &Demand::new()).unwrap().work.transforms, 0);
}

#[test]
fn what_can_not_be_told_is_flagged_or_refused() {
    let unit =
        UnitName { cascade: 0, level: 0, class: ErrorClass::HalfMillimetre, group: Group::Slopes, codec: Codec::I16 };
    let stamp = Stamp { tick: 0, epoch: 1, sequence: 0, layout: 0 };
    let calm = vec![0.1_f32; 64];
    let flags = |plane: &[f32]| {
        let frames = UnitEncoder::new(unit).take(8, &[plane, &calm].map(Plane::Samples), stamp);
        frames.map(|frames| split(&frames[0].bytes).unwrap().0.flags)
    };
    assert_eq!(flags(&calm).unwrap() & FLAG_SATURATED, 0);
    for value in [1e6, -1e6, 3e38, f32::MIN] {
        let mut plane = calm.clone();
        plane[13] = value;
        assert_eq!(flags(&plane).unwrap() & FLAG_SATURATED, FLAG_SATURATED, "{value}");
    }
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut plane = calm.clone();
        plane[63] = value;
        assert!(flags(&plane).is_err(), "{value} is sent");
    }
    // What is next to nothing is nothing.
    for value in [-0.0, 1e-45, -1e-45, f32::MIN_POSITIVE] {
        let mut plane = calm.clone();
        plane[0] = value;
        let frames = UnitEncoder::new(unit).take(8, &[&plane[..], &calm].map(Plane::Samples), stamp).unwrap();
        assert_eq!(split(&frames[0].bytes).unwrap().1[..2], [0, 0]);
    }
}
