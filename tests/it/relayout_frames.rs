//! Frames across a change of layout: each cascade at its own ticks alone, the same from every server, foam included.

use std::sync::Arc;

use bytes::Bytes;
use swellcast::backend::Cpu;
use swellcast::engine::Stepper;
use swellcast::plan::Demand;
use swellcast::scene::KEEP_TICKS;
use swellcast::sea::Timeline;
use swellcast::tile::decode;
use swellcast::wire::{Codec, ErrorClass, Group, REST_TICKS, UnitName, split};

use crate::relayout::layout;
use crate::support::scene;

const SECOND: i64 = 7200;
const INTERVAL: i64 = 240;
const AT: i64 = 40 * SECOND;
const FADE_S: i64 = 2;
const ENDS: i64 = AT + FADE_S * SECOND;
const UNTIL: i64 = ENDS + REST_TICKS;

fn before() -> Timeline {
    let wind = "[wind]\nspeed_mps = 14\nrange_mps = [2.0, 20.0]\n";
    Timeline::new(&scene(&format!("name = \"t\"\n{wind}[cascades]\nn = 64\npatches_m = [220.0]\n")))
}

/// All groups of both layouts.
fn demand() -> Demand {
    let unit = |cascade, group| {
        (UnitName { cascade, level: 0, class: ErrorClass::HalfMillimetre, group, codec: Codec::I16 }, INTERVAL)
    };
    [0, 8].into_iter().flat_map(|cascade| Group::ALL.map(|group| unit(cascade, group))).collect()
}

fn stepper(timeline: Timeline) -> Stepper {
    let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), Arc::new(timeline), 7);
    stepper.set_demand(&demand());
    stepper
}

/// Frames of a tick, foam warm, in order of (cascade, group).
fn frames(stepper: &mut Stepper, tick: i64) -> (Vec<(UnitName, Bytes)>, u64) {
    while stepper.warm_foam(tick).unwrap() {}
    let batch = stepper.frames(tick, &demand()).unwrap();
    (batch.frames.into_iter().map(|frame| (frame.unit, frame.bytes)).collect(), batch.work.transforms)
}

fn cascades(frames: &[(UnitName, Bytes)]) -> Vec<u8> {
    let mut cascades: Vec<u8> = frames.iter().map(|(unit, _)| unit.cascade).collect();
    cascades.dedup();
    cascades
}

fn is_still(frames: &[(UnitName, Bytes)], cascade: u8) -> bool {
    let mut of = frames.iter().filter(|(unit, _)| unit.cascade == cascade);
    of.all(|(unit, frame)| {
        let tile = decode(frame).unwrap();
        // Still water is not squeezed: both are 1, to the step.
        let rest =
            if unit.group == Group::Jacobian { (1.0 / tile.header.step[0]).round() * tile.header.step[0] } else { 0.0 };
        tile.planes.iter().flatten().all(|value| *value == rest)
    })
}

#[test]
fn a_cascade_has_frames_at_its_ticks_alone_and_the_last_are_nothing() {
    let mut stepper = stepper(before().with(layout(1, AT, FADE_S, 32, &[150.0]), AT));
    let mut last_moving = 0;
    for tick in (AT - 5 * INTERVAL..UNTIL + 5 * INTERVAL).step_by(INTERVAL as usize) {
        let (frames, transforms) = frames(&mut stepper, tick);
        let want: &[u8] = match tick {
            _ if tick < AT => &[0],
            _ if tick < UNTIL => &[0, 8],
            _ => &[8],
        };
        assert_eq!(cascades(&frames), want, "at tick {tick}");
        assert_eq!(frames.len(), want.len() * Group::ALL.len(), "all groups, foam too");
        // Foam steps are run two at most between these frames.
        let most = (want.len() * (11 + 3)) as u64;
        if tick > AT + SECOND {
            assert!(transforms <= most, "{transforms} transforms at tick {tick}, {most} for what is there");
        }
        for (_, frame) in &frames {
            let header = split(frame).unwrap().0;
            assert_eq!((header.layout, header.sequence), if tick < AT { (0, 0) } else { (1, 1) });
        }
        if tick < UNTIL && !is_still(&frames, 0) {
            last_moving = tick;
        }
        assert_eq!(is_still(&frames, 8), tick <= AT, "at tick {tick}");
    }
    assert!(
        last_moving < ENDS && last_moving > ENDS - SECOND / 2,
        "the old waves end {} ticks early",
        ENDS - last_moving
    );
}

#[test]
fn waiting_for_a_layout_costs_no_transform() {
    let (mut plain, mut waiting) = (stepper(before()), stepper(before().with(layout(1, AT, FADE_S, 32, &[150.0]), 0)));
    for tick in (30 * SECOND..31 * SECOND).step_by(INTERVAL as usize) {
        assert_eq!(frames(&mut plain, tick).1, frames(&mut waiting, tick).1);
    }
}

#[test]
fn a_server_that_lived_through_it_and_one_that_began_within_send_the_same_bytes() {
    let changed = before().with(layout(1, AT, FADE_S, 32, &[150.0]), AT - SECOND);
    let mut lived = stepper(before());
    for tick in (AT - 6 * SECOND..AT - SECOND).step_by(INTERVAL as usize) {
        frames(&mut lived, tick);
    }
    lived.set_timeline(Arc::new(changed.clone()));
    let (_, transforms) = frames(&mut lived, AT - SECOND);
    assert!(transforms <= 11 + 3, "{transforms} transforms: foam of what stays is kept, that of what comes needs none");
    let mut compared = 0;
    let mut untouched = stepper(before());
    let young = [AT - 120, AT + SECOND, ENDS + 480, UNTIL + SECOND]
        .map(|joined| (joined, Timeline::replay(changed.scene(), &[layout(1, AT, FADE_S, 32, &[150.0])], joined)));
    let mut young: Vec<_> = young.into_iter().map(|(joined, timeline)| (joined, stepper(timeline))).collect();
    for tick in (AT - SECOND + INTERVAL..UNTIL + 2 * SECOND).step_by(INTERVAL as usize) {
        let (ours, _) = frames(&mut lived, tick);
        if tick < AT {
            assert!(ours == frames(&mut untouched, tick).0, "a layout that is to come alters nothing at tick {tick}");
        }
        for (joined, late) in young.iter_mut().filter(|(joined, _)| *joined <= tick) {
            let (theirs, _) = frames(late, tick);
            assert!(ours == theirs, "one that began at {joined} differs at tick {tick}");
            compared += theirs.len();
        }
    }
    assert!(compared > 500, "{compared}");
}

#[test]
fn a_number_that_is_used_again_is_another_cascade() {
    // Even generations have the same numbers: the third layout has those of the first.
    let again = UNTIL + KEEP_TICKS;
    let log = [layout(1, AT, FADE_S, 32, &[150.0]), layout(2, again, FADE_S, 16, &[90.0])];
    let mut lived = stepper(before());
    lived.set_timeline(Arc::new(Timeline::replay(before().scene(), &log[..1], AT - SECOND)));
    for tick in (UNTIL..UNTIL + SECOND).step_by(INTERVAL as usize) {
        frames(&mut lived, tick);
    }
    let third = Timeline::replay(before().scene(), &log, again - SECOND);
    lived.set_timeline(Arc::new(third.clone()));
    let mut late = stepper(third);
    // Level 2 of 64 samples was a level; of 16 it is none.
    let gone =
        UnitName { cascade: 0, level: 2, class: ErrorClass::Millimetre, group: Group::Slopes, codec: Codec::I16 };
    for tick in (again - 2 * INTERVAL..again + 3 * SECOND).step_by(INTERVAL as usize) {
        let ours = frames(&mut lived, tick).0;
        assert!(ours == frames(&mut late, tick).0, "at tick {tick}");
        assert_eq!(
            cascades(&ours),
            if tick < again {
                vec![8]
            } else if tick < again + FADE_S * SECOND + REST_TICKS {
                vec![0, 8]
            } else {
                vec![0]
            }
        );
        assert!(lived.frames(tick, &Demand::from([(gone, INTERVAL)])).unwrap().frames.is_empty());
    }
}
