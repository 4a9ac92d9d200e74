//! A change of wind blends: nothing pops, overlapping changes included, and every server agrees.

use swellcast::backend::{Backend, Cpu};
use swellcast::engine::Stepper;
use swellcast::plan::Demand;
use swellcast::plan::Field;
use swellcast::scene::{Change, ChangeKind, Scene, preset};
use swellcast::sea::Timeline;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

use crate::support::plan;

const FRAME: i64 = 240;
const SECOND: i64 = 7200;

fn wind(sequence: u64, at: i64, seconds: i64, speed_mps: f64, from: f64) -> Change {
    let kind = ChangeKind::Wind { speed_mps, direction_from_deg: from };
    Change { sequence, effective_tick: at, transition_ticks: seconds * SECOND, kind }
}

fn scene_at(speed: f64) -> Scene {
    let mut scene = preset("beaufort-5").unwrap();
    scene.sea.wind.as_mut().unwrap().speed_mps = speed;
    scene
}

/// Largest change of the summed height of any of 65,536 points from one frame to the next, over some frames.
fn largest_step(timeline: &Timeline, from: i64, frames: i64) -> f32 {
    let mut cpu = Cpu::new(Some(2));
    let (mut before, mut largest): (Vec<f32>, f32) = (Vec::new(), 0.0);
    let mut loaded: Option<i64> = None;
    for frame in 0..=frames {
        let tick = from + frame * FRAME;
        if !loaded.is_some_and(|loaded| timeline.same_sea(loaded, tick)) {
            cpu.load(&timeline.at(tick)).unwrap();
            loaded = Some(tick);
        }
        let surface = cpu.step(tick, &plan(&timeline.at(tick), &[Field::Height])).unwrap();
        let mut height = vec![0.0; 65_536];
        for cascade in &surface.cascades {
            for (sum, h) in height.iter_mut().zip(cascade.plane(Field::Height).unwrap()) {
                *sum += h;
            }
        }
        for (a, b) in before.iter().zip(&height) {
            largest = largest.max((a - b).abs());
        }
        before = height;
    }
    largest
}

fn steady(speed: f64) -> f32 {
    largest_step(&Timeline::new(&scene_at(speed)), 100 * SECOND, 150)
}

#[test]
fn a_change_of_wind_moves_no_point_faster_than_a_steady_sea_does() {
    let (calm, rough) = (steady(5.0), steady(20.0));
    let at = 100 * SECOND;
    for (from, to) in [(5.0, 20.0), (20.0, 5.0)] {
        let timeline = Timeline::new(&scene_at(from));
        let once = timeline.with(wind(1, at, 5, to, 250.0), at);
        let changing = largest_step(&once, at - 5 * FRAME, 160);
        println!("{from} to {to} m/s: {changing:.4} m a frame, steady {calm:.4} and {rough:.4}");
        assert!(changing <= 1.2 * calm.max(rough));

        let interrupted = once.with(wind(2, at + 2 * SECOND, 5, from, 200.0), at);
        let changing = largest_step(&interrupted, at - 5 * FRAME, 220);
        println!("{from} to {to} m/s and back after 2 s: {changing:.4} m a frame");
        assert!(changing <= 1.2 * calm.max(rough));
    }
}

#[test]
fn energy_never_rises_above_both_ends_of_a_change() {
    let at = 50 * SECOND;
    let timeline = Timeline::new(&scene_at(5.0)).with(wind(1, at, 10, 15.0, 90.0), at);
    let timeline = timeline.with(wind(2, at + 3 * SECOND, 10, 8.0, 250.0), at);
    let highest =
        [5.0, 15.0, 8.0].map(|speed| Timeline::new(&scene_at(speed)).hs_at(0)).into_iter().fold(0.0, f64::max);
    for second in -1..16 {
        assert!(timeline.hs_at(at + second * SECOND) <= highest * (1.0 + 1e-12));
    }
    let end = Timeline::new(&scene_at(8.0)).hs_at(0);
    assert!((timeline.hs_at(at + 20 * SECOND) - end).abs() < 1e-9);
}

#[test]
fn the_order_in_which_changes_were_accepted_does_not_matter_to_the_sea() {
    let scene = scene_at(6.0);
    let depth = |sequence, at, depth_m| Change {
        sequence,
        effective_tick: at,
        transition_ticks: 0,
        kind: ChangeKind::Water { depth_m: Some(depth_m), gravity: None },
    };
    let late = wind(1, 40 * SECOND, 5, 12.0, 200.0);
    let early = depth(2, 10 * SECOND, 15.0);
    let last = depth(3, 60 * SECOND, f64::INFINITY);
    let one_by_one = Timeline::new(&scene).with(late.clone(), 0).with(early.clone(), 0).with(last.clone(), 0);
    // The second has folded into one what was over long before it began.
    let log = [early, late, last];
    let replayed = [(0, 0), (200, 171)].map(|(now, from)| (Timeline::replay(&scene, &log, now * SECOND), from));
    for (replayed, from) in replayed {
        for second in [0, 9, 10, 41, 50, 61, 171, 1000].into_iter().filter(|second| *second >= from) {
            let tick = second * SECOND;
            assert!(one_by_one.at(tick) == replayed.at(tick), "the seas differ after {second} s");
            assert_eq!(one_by_one.state_at(tick), replayed.state_at(tick));
            assert_eq!(one_by_one.sequence_at(tick), replayed.sequence_at(tick));
        }
    }
}

#[test]
fn a_change_leaves_the_past_alone() {
    let timeline = Timeline::new(&scene_at(9.0));
    let changed = timeline.with(wind(1, 500, 0, 18.0, 0.0), 0);
    assert!(timeline.at(499) == changed.at(499));
    assert!(timeline.at(500) != changed.at(500));
    assert_eq!((changed.sequence_at(499), changed.sequence_at(500)), (0, 1));
}

#[test]
fn records_follow_one_another_at_their_ticks_and_never_jump() {
    let scene = preset("ndbc-41010-replay").unwrap();
    let replay = scene.replay.clone().unwrap();
    let timeline = Timeline::new(&scene);
    let hs_of = |record: &swellcast::scene::MeasuredSpectrum| 4.0 * record.m0().sqrt();
    let first = scene.sea.measured.clone().unwrap();
    assert!((timeline.hs_at(0) / hs_of(&first) - 1.0).abs() < 0.01);
    for (i, (tick, record)) in replay.ticks().zip(replay.records.iter()).enumerate().step_by(9) {
        assert_eq!(tick, (i as i64 + 1) * 60 * SECOND);
        let before = if i == 0 { &first } else { &replay.records[i - 1] };
        let after = tick + replay.transition_ticks;
        assert!((timeline.hs_at(tick) / hs_of(before) - 1.0).abs() < 0.01, "record {i} is not there too soon");
        assert!((timeline.hs_at(after) / hs_of(record) - 1.0).abs() < 0.01, "record {i} has come");
        let middle = timeline.hs_at((tick + after) / 2);
        assert!(middle <= hs_of(before).max(hs_of(record)) * 1.01);
    }
    let last = replay.records.last().unwrap();
    assert!((timeline.hs_at(30 * 86_400 * SECOND) / hs_of(last) - 1.0).abs() < 0.01, "the sea stays with the last");
    // Through a transition nothing moves faster than in a steady sea.
    let at = replay.ticks().next().unwrap();
    let (calm, changing) = (largest_step(&timeline, 10 * SECOND, 60), largest_step(&timeline, at - 5 * FRAME, 660));
    println!("{changing:.4} m a frame through a transition, {calm:.4} in a steady sea");
    assert!(changing <= 1.2 * calm);
    // A change of the water goes through all of them; a server that joined later agrees.
    let depth = ChangeKind::Water { depth_m: Some(12.0), gravity: None };
    let shoal = Change { sequence: 1, effective_tick: 90 * SECOND, transition_ticks: SECOND, kind: depth };
    let (early, late) = (timeline.with(shoal.clone(), 0), Timeline::replay(&scene, &[shoal], 200 * SECOND));
    for second in [200, 245, 260, 600] {
        assert!(early.at(second * SECOND) == late.at(second * SECOND), "after {second} s");
        assert_eq!(early.state_at(second * SECOND).water.depth_m, 12.0);
    }
}

#[test]
fn a_calm_becomes_a_hurricane_in_no_time_in_a_second_and_in_a_minute() {
    let mut calm = scene_at(2.0);
    calm.wind_range_mps = Some([2.0, 60.0]);
    calm.effects.foam = None;
    let at = 100 * SECOND;
    let steady = |speed: f64| {
        let mut scene = calm.clone();
        scene.sea.wind.as_mut().unwrap().speed_mps = speed;
        largest_step(&Timeline::new(&scene), 100 * SECOND, 90)
    };
    let most = steady(60.0);
    for seconds in [0, 1, 5, 60] {
        let log = [
            wind(1, at, seconds, 60.0, 250.0),
            // Before the first is over, or at once after it.
            wind(2, at + seconds * SECOND / 2, seconds, 2.0, 90.0),
            wind(3, at + seconds * SECOND * 3 / 4, seconds, 60.0, 300.0),
        ];
        let one_by_one = log.iter().fold(Timeline::new(&calm), |t, change| t.with(change.clone(), at));
        let joined = Timeline::replay(&calm, &log, at + seconds * SECOND);
        for tick in [at + seconds * SECOND, at + (2 * seconds + 1) * SECOND] {
            assert!(one_by_one.at(tick) == joined.at(tick), "a server that joined later");
            let frames = |timeline: &Timeline| {
                let unit =
                    |group| UnitName { cascade: 1, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::I16 };
                let demand = Demand::from([(unit(Group::Displacement), 1), (unit(Group::Slopes), 1)]);
                let mut stepper = Stepper::new(Box::new(Cpu::new(Some(2))), timeline.clone().into(), 1);
                stepper.frames(tick, &demand).unwrap().frames
            };
            assert!(frames(&one_by_one) == frames(&joined) && frames(&joined).len() == 2, "the same bytes");
        }
        let frames = (2 * seconds + 2) * 30;
        // A minute's transition is looked at where it is fastest.
        let from = at + (seconds - 20).max(0) * SECOND / 2 - 5 * FRAME;
        let moved = largest_step(&one_by_one, from, frames.min(600));
        println!("{seconds} s: {moved:.3} m a frame, {most:.3} in a steady hurricane");
        assert!(moved.is_finite() && one_by_one.hs_at(at + 200 * SECOND).is_finite());
        // What takes no time moves more than any sea does: the frames looked at are those of the change.
        assert!(seconds > 0 || moved > most, "the change was not looked at");
        assert!(seconds < 5 || moved <= 1.2 * most, "{moved} m a frame");
    }
}
