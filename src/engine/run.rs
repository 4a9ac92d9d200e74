//! The step thread: waits for the next tick that is due, makes it, and warms foam in the time between.

use std::collections::BTreeSet;
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering::Relaxed, Ordering::SeqCst};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::backends::{BackendChoice, Backends, Opener};
use super::clock::Clock;
use super::point_feed::PointsWish;
use super::schedule::{HEADSTART, lead_ticks, next_tick};
use super::step::{Batch, Stepper, Work};
use crate::backend::BackendError;
use crate::plan::{Demand, Lingering};
use crate::sea::Timeline;
use crate::wire::{SLOWEST_INTERVAL, UnitName};

/// Foam steps run after each frame even when the next frame is already due, so that foam warms on a busy machine.
const FOAM_STEPS_AT_LEAST: u32 = 2;
/// Pause after a backend error.
const AFTER_ERROR: Duration = Duration::from_millis(100);

/// How the engine runs.
#[derive(Clone, Debug)]
pub struct EngineSettings {
    /// Threads of the CPU backend; `None`: one for each core.
    pub threads: Option<usize>,
    /// Most units that are made, those included that nobody wants any more.
    pub most_units: usize,
    /// What computes.
    pub backend: BackendChoice,
    /// How the backend is opened that is not the CPU; without one the CPU computes.
    pub opener: Option<Opener>,
}

impl Default for EngineSettings {
    fn default() -> Self {
        Self { threads: None, most_units: 64, backend: BackendChoice::default(), opener: None }
    }
}

/// What the engine has done since it started.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counters {
    /// Ticks made.
    pub steps: u64,
    /// Two-dimensional transforms, foam's own included.
    pub work: Work,
    /// Ticks passed over because the machine was too slow.
    pub skipped_frames: u64,
    /// Frames not sent because they held a value that is not finite.
    pub refused_frames: u64,
    /// Errors of the backend.
    pub backend_errors: u64,
    /// Milliseconds that the last tick took, encoding included.
    pub step_ms: f64,
    /// Seconds spent in steps altogether.
    pub step_seconds: f64,
    /// Whether frames carry all the foam that is wanted.
    pub foam_warm: bool,
    /// The newest tick made; `None` before the first.
    pub tick: Option<i64>,
    /// Name of the backend.
    pub backend: &'static str,
    /// Times that another backend took over.
    pub backend_changes: u64,
    /// Times that one was lost.
    pub backend_losses: u64,
    /// Why the CPU computes where something else was asked for.
    pub backend_note: Option<String>,
}

/// Where frames go.
pub type Publish = Box<dyn FnMut(Batch) + Send>;

/// A running engine; stops when it is dropped.
pub struct Engine {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    inbox: Mutex<Inbox>,
    news: Condvar,
    counters: Mutex<Counters>,
    alive: AtomicBool,
    /// The engine makes no tick from this one on; `i64::MAX` when nothing holds it.
    hold: AtomicI64,
    /// Counts changes of the inbox, so that the thread looks only when there is something.
    version: AtomicU64,
}

/// What the engine is told: the newest of each, so that it is bounded.
#[derive(Default)]
struct Inbox {
    timeline: Option<Arc<Timeline>>,
    demand: Option<Demand>,
    points: Option<Vec<PointsWish>>,
    /// Units that somebody begins to follow.
    joins: BTreeSet<UnitName>,
    stop: bool,
}

/// A poisoned lock holds plain data that is whole after every statement.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Engine {
    /// Starts the thread. `publish` runs on it and must not block.
    ///
    /// # Panics
    /// If the system gives no thread.
    pub fn start(
        timeline: Arc<Timeline>,
        clock: Clock,
        epoch: u64,
        settings: EngineSettings,
        publish: Publish,
    ) -> Self {
        let backends = Backends::new(settings.backend, settings.threads, settings.opener, clock);
        let stepper = Stepper::new(backends.cpu(), Arc::clone(&timeline), epoch);
        let counters = Counters { backend: stepper.backend(), ..Counters::default() };
        let shared = Arc::new(Shared {
            inbox: Mutex::default(),
            news: Condvar::new(),
            counters: Mutex::new(counters),
            alive: AtomicBool::new(true),
            hold: AtomicI64::new(i64::MAX),
            version: AtomicU64::new(0),
        });
        let of_thread = Arc::clone(&shared);
        let work = move || {
            let _alive = Alive(&of_thread);
            Loop {
                shared: &of_thread,
                stepper,
                backends,
                timeline,
                clock,
                publish,
                lingering: Lingering::new(settings.most_units),
                demand: Demand::new(),
                of_points: None,
                last: None,
                joins: BTreeSet::new(),
                seen: 0,
            }
            .run();
        };
        let thread = std::thread::Builder::new().name("swellcast-engine".to_owned()).spawn(work);
        Self { shared, thread: Some(thread.expect("the system gives a thread at start")) }
    }

    /// The timeline from the next step on.
    pub fn set_timeline(&self, timeline: Arc<Timeline>) {
        self.tell(|inbox| inbox.timeline = Some(timeline));
    }

    /// The demand from the next step on. None: the engine rests.
    pub fn set_demand(&self, demand: Demand) {
        self.tell(|inbox| inbox.demand = Some(demand));
    }

    /// Somebody begins to follow these units: their next frames come also as who has none before them can read them.
    pub fn join(&self, units: Vec<UnitName>) {
        self.tell(|inbox| {
            // Of a unit that nobody wants there is nothing to join; what is wanted is bounded.
            inbox.joins.extend(units);
        });
    }

    /// Points whose water is told from the next step on. They don't linger.
    pub fn set_points(&self, points: Vec<PointsWish>) {
        self.tell(|inbox| inbox.points = Some(points));
    }

    /// Makes no tick from this one on until told otherwise: frames are then late instead of wrong while a change of
    /// that tick is being decided. A timeline that was set before the release is in force after it.
    pub fn hold(&self, tick: Option<i64>) {
        self.tell(|_| self.shared.hold.store(tick.unwrap_or(i64::MAX), SeqCst));
    }

    /// What has been done so far.
    pub fn counters(&self) -> Counters {
        lock(&self.shared.counters).clone()
    }

    /// Whether the thread lives.
    pub fn is_alive(&self) -> bool {
        self.shared.alive.load(Relaxed)
    }

    /// Stops the thread and waits for it.
    pub fn stop(self) {}

    fn tell(&self, change: impl FnOnce(&mut Inbox)) {
        let mut inbox = lock(&self.shared.inbox);
        change(&mut inbox);
        // Under the lock, or a thread about to wait would miss it.
        self.shared.version.fetch_add(1, SeqCst);
        self.shared.news.notify_all();
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.tell(|inbox| inbox.stop = true);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so on standard error, and `is_alive` says it, too.
            let _ = thread.join();
        }
    }
}

/// Marks the engine dead however its thread ends.
struct Alive<'a>(&'a Shared);

impl Drop for Alive<'_> {
    fn drop(&mut self) {
        self.0.alive.store(false, Relaxed);
    }
}

struct Loop<'a> {
    shared: &'a Shared,
    stepper: Stepper,
    backends: Backends,
    timeline: Arc<Timeline>,
    clock: Clock,
    publish: Publish,
    lingering: Lingering,
    demand: Demand,
    /// The smallest interval of points, where somebody follows any.
    of_points: Option<i64>,
    last: Option<i64>,
    /// Units that somebody begins to follow.
    joins: BTreeSet<UnitName>,
    seen: u64,
}

impl Loop<'_> {
    fn run(mut self) {
        loop {
            // Read before the news: whoever releases the engine has told it of the new timeline first.
            let hold = self.shared.hold.load(SeqCst);
            if !self.take_news() {
                break;
            }
            self.settle_backend();
            self.settle_demand();
            let Some(interval) = self.demand.values().copied().chain(self.of_points).min() else {
                self.last = None;
                self.rest(Duration::from_secs(1));
                continue;
            };
            let lead = lead_ticks(SLOWEST_INTERVAL) + HEADSTART;
            let due = self.clock.now_tick() + lead;
            let (tick, skipped) = next_tick(self.last, due, interval);
            let done = if tick >= hold {
                self.rest(Duration::from_secs(1));
                Ok(())
            } else if tick <= due {
                self.make(tick, skipped, interval)
            } else {
                self.stepper.warm_foam(tick).map(|worked| {
                    if !worked {
                        self.rest(self.clock.until(tick - lead));
                    }
                })
            };
            if let Err(error) = done {
                self.recover(&error);
            }
        }
    }

    fn make(&mut self, tick: i64, skipped: u64, interval: i64) -> Result<(), BackendError> {
        let started = self.clock.now_us();
        // Also after an error: the next attempt is the next tick.
        self.last = Some(tick);
        let mut made = self.stepper.frames(tick, &self.demand);
        if let Err(error) = &made
            && self.backends.other_computes()
        {
            // The same tick again, by the CPU, so that it is not missed.
            self.recover(error);
            made = self.stepper.frames(tick, &self.demand);
        }
        let mut batch = made?;
        let ms = (self.clock.now_us() - started) as f64 / 1e3;
        batch.step_ms = ms;
        {
            let mut counters = lock(&self.shared.counters);
            counters.steps += 1;
            counters.work += batch.work;
            counters.skipped_frames += skipped;
            counters.refused_frames += batch.refused;
            counters.step_ms = ms;
            counters.step_seconds += ms / 1e3;
            counters.tick = Some(tick);
        }
        (self.publish)(batch);
        for _ in 0..FOAM_STEPS_AT_LEAST {
            self.stepper.warm_foam(tick + interval)?;
        }
        lock(&self.shared.counters).foam_warm = self.stepper.foam_is_warm(tick + interval);
        Ok(())
    }

    /// Moves to the other backend when that one is there.
    fn settle_backend(&mut self) {
        if let Some(backend) = self.backends.arrived(&self.timeline) {
            drop(self.stepper.replace_backend(backend));
            lock(&self.shared.counters).backend_changes += 1;
        }
        self.tell_backend();
    }

    /// After an error: the CPU takes the place of another backend, whatever that failed with; the CPU itself is given a
    /// moment, and begins anew.
    fn recover(&mut self, error: &BackendError) {
        tracing::error!(%error, backend = self.stepper.backend(), "backend");
        lock(&self.shared.counters).backend_errors += 1;
        if !self.backends.other_computes() {
            self.stepper.forget();
            self.rest(AFTER_ERROR);
            return;
        }
        let cpu = self.backends.lost(error);
        let lost = ManuallyDrop::new(self.stepper.replace_backend(cpu));
        // A device that hangs may never let go: not on this thread. Where there is no other, its memory stays.
        let let_go = move || drop(ManuallyDrop::into_inner(lost));
        drop(std::thread::Builder::new().name("swellcast-let-go".to_owned()).spawn(let_go));
        {
            let mut counters = lock(&self.shared.counters);
            counters.backend_losses += 1;
            counters.backend_changes += 1;
        }
        self.tell_backend();
    }

    fn tell_backend(&self) {
        let mut counters = lock(&self.shared.counters);
        (counters.backend, counters.backend_note) = (self.stepper.backend(), self.backends.note());
    }

    /// Takes what the engine was told; false to stop.
    fn take_news(&mut self) -> bool {
        let version = self.shared.version.load(SeqCst);
        if version == self.seen {
            return true;
        }
        self.seen = version;
        let Inbox { timeline, demand, points, mut joins, stop } = std::mem::take(&mut *lock(&self.shared.inbox));
        if let Some(timeline) = timeline {
            self.timeline = Arc::clone(&timeline);
            self.stepper.set_timeline(timeline);
        }
        if let Some(demand) = demand {
            self.lingering.set(demand, self.clock.now_tick());
        }
        if let Some(points) = points {
            let points: Vec<PointsWish> = points.into_iter().filter(|wish| wish.interval > 0).collect();
            self.of_points = points.iter().map(|wish| wish.interval).min();
            self.stepper.set_points(points);
        }
        self.joins.append(&mut joins);
        !stop
    }

    /// Brings the demand up to date with what was told, and with the time.
    fn settle_demand(&mut self) {
        let demand = self.lingering.at(self.clock.now_tick());
        if demand != self.demand {
            self.stepper.set_demand(&demand);
            self.demand = demand;
        }
        for unit in std::mem::take(&mut self.joins) {
            if self.demand.contains_key(&unit) {
                self.stepper.join(unit);
            }
        }
    }

    /// Waits, at most this long, for news.
    fn rest(&self, at_most: Duration) {
        let inbox = lock(&self.shared.inbox);
        let no_news = |_: &mut Inbox| self.shared.version.load(SeqCst) == self.seen;
        // Poisoned or timed out: the loop looks again in any case.
        drop(self.shared.news.wait_timeout_while(inbox, at_most, no_news));
    }
}
