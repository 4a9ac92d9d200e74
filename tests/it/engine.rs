//! The step thread: a change that is being decided holds back the ticks that it would alter.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use swellcast::engine::{Batch, Clock, Engine, EngineSettings};
use swellcast::plan::Demand;
use swellcast::scene::{Change, ChangeKind};
use swellcast::sea::Timeline;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName, split};

use crate::support::wind_sea;

fn wait(what: &str, mut done: impl FnMut() -> bool) {
    for _ in 0..1000 {
        if done() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("waited in vain: {what}");
}

#[test]
fn a_held_engine_makes_no_tick_that_a_change_would_alter() {
    let timeline = Arc::new(Timeline::new(&wind_sea(9.0, 32, &[100.0])));
    let clock = Clock::start(Clock::unix_now_ns());
    let (batches, published) = (Arc::new(Mutex::new(Vec::<Batch>::new())), Arc::new(Mutex::new(0)));
    let (to, count) = (Arc::clone(&batches), Arc::clone(&published));
    let publish = Box::new(move |batch| {
        to.lock().unwrap().push(batch);
        *count.lock().unwrap() += 1;
    });
    let engine = Engine::start(
        Arc::clone(&timeline),
        clock,
        1,
        EngineSettings { threads: Some(1), ..EngineSettings::default() },
        publish,
    );
    let unit =
        UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group: Group::Slopes, codec: Codec::I16 };
    engine.set_demand(Demand::from([(unit, 120)]));
    wait("frames", || *published.lock().unwrap() > 3);

    let effective_tick = clock.now_tick() + 3600;
    engine.hold(Some(effective_tick));
    // Well past the time at which frames of that tick would have left.
    wait("the tick to pass", || clock.now_tick() > effective_tick + 1200);
    let newest = batches.lock().unwrap().iter().map(|batch| batch.tick).max().unwrap();
    assert!(newest < effective_tick, "{newest} of {effective_tick}");

    let kind = ChangeKind::Wind { speed_mps: 15.0, direction_from_deg: 10.0 };
    let change = Change { sequence: 1, effective_tick, transition_ticks: 0, kind };
    engine.set_timeline(Arc::new(timeline.with(change, clock.now_tick())));
    engine.hold(None);
    let so_far = *published.lock().unwrap();
    wait("frames again", || *published.lock().unwrap() > so_far + 3);
    engine.stop();
    for batch in batches.lock().unwrap().iter() {
        for frame in &batch.frames {
            let sequence = split(&frame.bytes).unwrap().0.sequence;
            assert_eq!(sequence, u64::from(batch.tick >= effective_tick), "tick {}", batch.tick);
        }
    }
}
