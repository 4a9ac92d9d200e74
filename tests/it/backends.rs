//! Which backend computes: the better one, the CPU when that is lost, and the other again.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use swellcast::backend::{Backend, BackendError, Cpu, Surface, Tap};
use swellcast::engine::{BackendChoice, Batch, Clock, Engine, EngineSettings, Opener, Stepper, interval_of_rate};
use swellcast::plan::{Demand, Plan};
use swellcast::sea::{Sea, Timeline};
use swellcast::server::Settings;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

use crate::served::{Got, Served, header};
use crate::support::wind_sea;

/// A backend that is the CPU but for its name, and for what is done to it.
struct Other {
    cpu: Cpu,
    lost: Arc<AtomicBool>,
    /// Factor on every sea it is given.
    wrong: f64,
    slow: Duration,
}

impl Backend for Other {
    fn name(&self) -> &'static str {
        "other"
    }

    fn load(&mut self, sea: &Sea) -> Result<(), BackendError> {
        let mut sea = sea.clone();
        for mode in sea.cascades.iter_mut().flat_map(|cascade| &mut cascade.modes) {
            (mode.forward, mode.backward) = (mode.forward * self.wrong, mode.backward * self.wrong);
        }
        self.cpu.load(&sea)
    }

    fn step(&mut self, tick: i64, plan: &Plan) -> Result<&Surface, BackendError> {
        if self.lost.load(SeqCst) {
            return Err(BackendError::DeviceLost("it was pulled out".to_owned()));
        }
        std::thread::sleep(self.slow);
        self.cpu.step(tick, plan)
    }

    fn surface(&self) -> &Surface {
        self.cpu.surface()
    }

    fn tap(&self, cascade: usize, tap: Tap) -> Option<Vec<f32>> {
        self.cpu.tap(cascade, tap)
    }
}

/// An engine of a small sea with another backend at hand; its frames, and how often that one was opened.
struct Rig {
    engine: Engine,
    batches: Receiver<Batch>,
    timeline: Arc<Timeline>,
    lost: Arc<AtomicBool>,
    opened: Arc<AtomicUsize>,
}

fn demand() -> Demand {
    let unit = |group| {
        (
            UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::I16 },
            interval_of_rate(30),
        )
    };
    [Group::Displacement, Group::Foam].map(unit).into()
}

/// Opens that backend unless it is lost, and counts how often it was asked to.
fn opener(lost: &Arc<AtomicBool>, opened: &Arc<AtomicUsize>, wrong: f64, slow: Duration) -> Opener {
    let (lost, opened) = (Arc::clone(lost), Arc::clone(opened));
    Opener(Arc::new(move || {
        opened.fetch_add(1, SeqCst);
        if lost.load(SeqCst) {
            return Err("there is none".to_owned());
        }
        Ok(Box::new(Other { cpu: Cpu::new(Some(1)), lost: Arc::clone(&lost), wrong, slow }))
    }))
}

fn rig(choice: BackendChoice, wrong: f64, slow: Duration) -> Rig {
    let timeline = Arc::new(Timeline::new(&wind_sea(14.0, 32, &[120.0])));
    let (lost, opened) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
    let settings = EngineSettings {
        threads: Some(1),
        backend: choice,
        opener: Some(opener(&lost, &opened, wrong, slow)),
        ..EngineSettings::default()
    };
    let (sender, batches) = channel();
    let sender = Mutex::new(sender);
    let publish = Box::new(move |batch| drop(sender.lock().unwrap().send(batch)));
    let clock = Clock::start(Clock::unix_now_ns());
    let engine = Engine::start(Arc::clone(&timeline), clock, 1, settings, publish);
    engine.set_demand(demand());
    Rig { engine, batches, timeline, lost, opened }
}

impl Rig {
    /// Batches until one is as it should be, that one included.
    fn until(&self, wanted: impl Fn(&Batch) -> bool) -> Vec<Batch> {
        let mut got = Vec::new();
        // Twenty seconds of frames.
        for _ in 0..600 {
            got.push(self.batches.recv_timeout(Duration::from_secs(5)).expect("frames come"));
            if wanted(&got[got.len() - 1]) {
                return got;
            }
        }
        panic!("it does not come")
    }

    fn note(&self) -> String {
        self.engine.counters().backend_note.unwrap_or_default()
    }
}

#[test]
fn a_lost_backend_loses_no_tick_and_the_sea_goes_on_to_the_byte() {
    let rig = rig(BackendChoice::Gpu, 1.0, Duration::ZERO);
    rig.until(|batch| batch.backend == "other" && batch.frames.len() == 2);
    rig.lost.store(true, SeqCst);
    let mut batches = rig.until(|batch| batch.backend == "cpu");
    // Foam is run again from the beginning of its memory, and comes soon after.
    batches.extend(rig.until(|batch| batch.frames.len() == 2));
    let skipped = rig.engine.counters().skipped_frames;
    let ticks: Vec<i64> = batches.iter().map(|batch| batch.tick).collect();
    let missed = ticks.windows(2).filter(|pair| pair[1] - pair[0] != interval_of_rate(30)).count() as u64;
    assert!(missed <= skipped, "{ticks:?}, of which the machine was too slow for {skipped}");
    let last = &batches[batches.len() - 1];
    assert_eq!(last.backend, "cpu");
    let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), Arc::clone(&rig.timeline), 1);
    stepper.set_demand(&demand());
    while stepper.warm_foam(last.tick).unwrap() {}
    assert!(stepper.frames(last.tick, &demand()).unwrap().frames == last.frames, "tick {}", last.tick);
    let counters = rig.engine.counters();
    assert_eq!((counters.backend_losses, counters.backend_changes, counters.backend), (1, 2, "cpu"));
    assert!(rig.note().contains("pulled out"), "{}", rig.note());
    // Not there yet at the first try, and then it is.
    std::thread::sleep(Duration::from_millis(1200));
    rig.lost.store(false, SeqCst);
    rig.until(|batch| batch.backend == "other");
    assert!(rig.opened.load(SeqCst) >= 3, "opened {} times", rig.opened.load(SeqCst));
}

#[test]
fn auto_keeps_the_cpu_where_the_other_is_wrong_or_slow_and_says_why() {
    for (wrong, slow, why) in [(1.0001, Duration::ZERO, "errs"), (1.0, Duration::from_millis(20), "slower")] {
        let rig = rig(BackendChoice::Auto, wrong, slow);
        rig.until(|_| rig.note().contains(why));
        assert!(rig.until(|_| true)[0].backend == "cpu");
        assert_eq!(rig.opened.load(SeqCst), 1, "what was refused is not opened again");
    }
}

#[test]
fn whoever_asks_for_a_backend_gets_it_however_slow() {
    let rig = rig(BackendChoice::Gpu, 1.0, Duration::from_millis(2));
    rig.until(|batch| batch.backend == "other");
    assert_eq!(rig.engine.counters().backend_note, None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_stays_and_is_told_when_the_backend_is_lost() {
    let (lost, opened) = (Arc::new(AtomicBool::new(false)), Arc::default());
    let engine = EngineSettings {
        threads: Some(1),
        backend: BackendChoice::Gpu,
        opener: Some(opener(&lost, &opened, 1.0, Duration::ZERO)),
        ..EngineSettings::default()
    };
    let settings = Settings { engine, ..Settings::default() };
    let served = Served::start(&wind_sea(14.0, 32, &[120.0]), settings).await;
    let mut client = served.client().await;
    client.subscribe(30, &["displacement"]).await;
    while client.text("status").await["backend"] != "other" {}
    assert_eq!(served.get("/readyz").await.body, "ready: other\n");
    lost.store(true, SeqCst);
    let mut ticks = Vec::new();
    loop {
        match client.next().await {
            Got::Frame(frame) => ticks.push(header(&frame).tick),
            Got::Text(message) if message["type"] == "status" && message["backend"] == "cpu" => break,
            Got::Text(_) => {}
            Got::Closed(code) => panic!("closed with {code}"),
        }
    }
    for _ in 0..15 {
        ticks.push(header(&client.frame().await).tick);
    }
    let interval = interval_of_rate(30) as u64;
    let missing: u64 = ticks.windows(2).map(|pair| (pair[1] - pair[0]) / interval - 1).sum();
    assert!(missing <= served.ocean.counters().skipped_frames, "{missing} frames are missing: {ticks:?}");
    let ready = served.get("/readyz").await;
    assert!(ready.status == 200 && ready.body.starts_with("ready: cpu; device lost"), "{}", ready.body);
    let metrics = served.get("/metrics").await.body;
    assert!(metrics.contains("\nswellcast_backend_losses_total 1\n"), "{metrics}");
    served.stop().await;
}
