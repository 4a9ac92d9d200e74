//! The one sea that is served, and all that its sessions and requests share.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use serde_json::Value;
use tokio::task::spawn_blocking;

use super::accuracy::Claims;
use super::budget::Budget;
use super::bulletin::Bulletin;
use super::egress::Egress;
use super::hello;
use super::metrics::Metrics;
use super::plan::Costs;
use super::points::PointsBoard;
use super::probe::Probes;
use super::proposal::Gate;
use super::ring::Ring;
use super::seats::Seats;
use super::settings::Settings;
use super::source::Source;
use super::subscriptions::Subscriptions;
use crate::body::Problem;
use crate::control::{Begun, Epoch, Store};
use crate::engine::{Batch, Clock, Counters, Engine, EngineSettings, Publish};
use crate::plan::Demand;
use crate::sea::{Layout, Timeline};
use crate::wire::{Hello, Status, TICKS_PER_SECOND, UnitName};

/// How often the time that was reached is noted, ticks: 5 s.
const NOTE_EVERY: i64 = 5 * TICKS_PER_SECOND;

/// A sea under way: its log, its timeline, the engine that makes its frames and the ring that holds them.
pub struct Ocean {
    pub(super) settings: Settings,
    pub(super) epoch: Epoch,
    pub(super) clock: Clock,
    pub(super) store: Arc<Store>,
    pub(super) ring: Arc<Ring>,
    pub(super) bulletin: Arc<Bulletin>,
    pub(super) seats: Arc<Seats>,
    pub(super) metrics: Metrics,
    pub(super) egress: Arc<Egress>,
    pub(super) costs: Costs,
    pub(super) claims: Claims,
    pub(super) budget: Budget,
    pub(super) probes: Probes,
    pub(super) points: Arc<PointsBoard>,
    /// Told when frames come of another backend than before.
    pub(super) backend_changed: Arc<tokio::sync::Notify>,
    /// Changes are decided one at a time.
    pub(super) gate: tokio::sync::Mutex<Gate>,
    current: RwLock<Current>,
    status: RwLock<Status>,
    pub(super) source: Source,
    wishes: Mutex<Wishes>,
    pub(super) clients: AtomicUsize,
    /// The statistics that were told last: tick, entry of the log, and text.
    statistics: Arc<tokio::sync::Mutex<Option<(i64, u64, Value)>>>,
    /// The tick that was noted last.
    noted: Arc<tokio::sync::Mutex<i64>>,
    /// One composes the status at a time.
    composing: Arc<tokio::sync::Mutex<()>>,
    pub(super) next_client: AtomicU64,
}

/// The sea as all its changes so far make it.
#[derive(Clone, Debug)]
pub struct Current {
    /// Newest entry of the log.
    pub sequence: u64,
    /// The sea at every tick.
    pub timeline: Arc<Timeline>,
}

/// What a source of frames is made of.
pub(super) struct Parts {
    /// The sea.
    pub timeline: Arc<Timeline>,
    /// Server time.
    pub clock: Clock,
    /// Which timeline.
    pub epoch: Epoch,
    /// Where frames go.
    pub publish: Publish,
}

struct Wishes {
    subscriptions: Subscriptions,
    /// What the engine was told last.
    demand: Demand,
}

/// While it lives, the engine waits before a tick.
pub struct Held {
    ocean: Arc<Ocean>,
}

impl Drop for Held {
    fn drop(&mut self) {
        self.ocean.source.hold(None);
    }
}

impl Ocean {
    /// Sets a sea under way, as its log left it. Integrates spectra: takes a tenth of a second, and more for a
    /// large scene.
    pub fn start(store: Store, begun: Begun, settings: Settings) -> Arc<Self> {
        let of_engine = EngineSettings { most_units: settings.live_units, ..settings.engine.clone() };
        Self::with(store, begun, settings, |Parts { timeline, clock, epoch, publish }| {
            Source::Engine(Engine::start(timeline, clock, epoch.id, of_engine, publish))
        })
    }

    /// Sets a sea under way whose frames come from what `source` gives.
    pub(super) fn with(
        store: Store,
        begun: Begun,
        settings: Settings,
        source: impl FnOnce(Parts) -> Source,
    ) -> Arc<Self> {
        let Begun { epoch, scene, changes, reached_tick } = begun;
        let mut clock = Clock::start(epoch.unix_ns);
        if clock.now_tick() < reached_tick {
            tracing::warn!(reached_tick, "the calendar was set back; the sea goes on from where it was");
            clock = clock.not_before(reached_tick.saturating_add(NOTE_EVERY).saturating_add(hello::reach()));
        }
        let (tick, started) = (clock.now_tick(), clock.now_us());
        let timeline = Arc::new(Timeline::replay(&scene, &changes, tick));
        let build_us = clock.now_us() - started;
        let (ring, bulletin) = (Arc::new(Ring::new(settings.ring_bytes)), Arc::new(Bulletin::new()));
        let points = Arc::new(PointsBoard::new(settings.live_points));
        let (to_ring, to_board, to_all) = (Arc::clone(&ring), Arc::clone(&points), Arc::clone(&bulletin));
        let (backend_changed, mut backend) = (Arc::new(tokio::sync::Notify::new()), "cpu");
        let (to_pulse, budget) = (Arc::clone(&backend_changed), Budget::new(settings.budget_ms));
        let to_pace = Arc::clone(&budget.pace);
        let publish = Box::new(move |mut batch: Batch| {
            if std::mem::replace(&mut backend, batch.backend) != batch.backend {
                to_pulse.notify_one();
            }
            to_pace.note(batch.tick, batch.step_ms);
            to_board.post(std::mem::take(&mut batch.points));
            to_ring.push(batch, clock.now_us());
            to_all.wake();
        });
        let source = source(Parts { timeline: Arc::clone(&timeline), clock, epoch, publish });
        let status = hello::status(&timeline, &source.counters(), tick, 0);
        let sequence = changes.last().map_or(0, |change| change.sequence);
        Arc::new(Self {
            seats: Seats::new(settings.connections, settings.connections_per_address),
            wishes: Mutex::new(Wishes {
                subscriptions: Subscriptions::new(settings.live_units),
                demand: Demand::new(),
            }),
            epoch,
            clock,
            store: Arc::new(store),
            ring,
            bulletin,
            metrics: Metrics::default(),
            egress: Arc::new(Egress::new(settings.egress_mbps)),
            settings,
            costs: Costs::default(),
            claims: Claims::default(),
            budget,
            probes: Probes::default(),
            points,
            backend_changed,
            gate: tokio::sync::Mutex::new(Gate::new(changes, build_us, tick)),
            current: RwLock::new(Current { sequence, timeline }),
            status: RwLock::new(status),
            source,
            clients: AtomicUsize::new(0),
            statistics: Arc::default(),
            noted: Arc::new(tokio::sync::Mutex::new(i64::MIN)),
            composing: Arc::default(),
            next_client: AtomicU64::new(1),
        })
    }

    /// The tick.
    pub fn tick(&self) -> i64 {
        self.clock.now_tick()
    }

    /// The sea as it stands.
    pub fn current(&self) -> Current {
        self.current.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The status that clients were told last.
    pub fn status(&self) -> Status {
        self.status.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What the engine has done.
    pub fn counters(&self) -> Counters {
        self.source.counters()
    }

    /// Stream clients now.
    pub fn clients(&self) -> usize {
        self.clients.load(Relaxed)
    }

    /// Frames that were handed to clients' sockets.
    pub fn frames_sent(&self) -> u64 {
        self.metrics.frames_sent()
    }

    /// Units that are wanted now, and how often.
    pub fn demand(&self) -> Demand {
        self.wishes.lock().unwrap_or_else(PoisonError::into_inner).demand.clone()
    }

    /// Waits until a recording is over; a sea that is computed goes on for ever.
    pub async fn over(&self) {
        self.source.over().await;
    }

    /// Whether frames can be made.
    pub fn is_ready(&self) -> bool {
        self.source.is_alive()
    }

    /// The first message to a client, and what follows a change of layout.
    pub fn hello(&self) -> Hello {
        let Current { sequence, timeline } = self.current();
        let mut hello = hello::hello(&timeline, self.epoch, sequence, self.tick(), self.settings.live_units);
        self.source.narrow(&mut hello);
        hello
    }

    /// What the sea is like, with the newest entry of the log. Sums over all modes: made once a second at most,
    /// however many ask.
    pub(super) async fn statistics(&self) -> Result<(u64, Value), Problem> {
        // The lock goes with the work: whoever hangs up leaves it to be finished.
        let mut told = Arc::clone(&self.statistics).lock_owned().await;
        let (Current { sequence, timeline }, tick) = (self.current(), self.tick());
        if let Some((at, known, body)) = &*told
            && *known == sequence
            && (*at..*at + TICKS_PER_SECOND).contains(&tick)
        {
            return Ok((sequence, body.clone()));
        }
        let make = move || {
            let mut body = serde_json::to_value(timeline.statistics_at(tick)).ok()?;
            body["tick"] = tick.into();
            *told = Some((tick, sequence, body.clone()));
            Some(body)
        };
        let made = spawn_blocking(make).await.ok().flatten();
        made.map(|body| (sequence, body)).ok_or_else(|| Problem::internal("the statistics can't be made"))
    }

    /// Composes the status anew and tells every client.
    pub async fn refresh_status(self: &Arc<Self>) {
        let turn = Arc::clone(&self.composing).lock_owned().await;
        let ocean = Arc::clone(self);
        let compose = move || {
            // Every second and off the async threads: records of a sequence are ready when their time comes.
            ocean.current().timeline.build_ahead(ocean.tick());
            ocean.compose_status();
            // The sea first: whoever waits for the turn may open its log again.
            drop(ocean);
            drop(turn);
        };
        if let Err(error) = spawn_blocking(compose).await {
            tracing::error!(%error, "status");
        }
    }

    /// The same; sums the energies of all modes.
    pub(super) fn compose_status(&self) {
        // Composed and posted under one lock, so that none overtakes a newer one.
        let mut posted = self.status.write().unwrap_or_else(PoisonError::into_inner);
        let timeline = self.current().timeline;
        let status = hello::status(&timeline, &self.counters(), self.tick(), self.clients());
        posted.clone_from(&status);
        self.bulletin.post_status(status);
    }

    /// Lets go of cascades that have ended: of wishes for them at once, of all else when foam has forgotten them.
    pub(super) async fn retire(self: &Arc<Self>) {
        let (timeline, tick) = (self.current().timeline, self.tick());
        if timeline.lives().any(|life| life.is_over(tick)) {
            let over = |unit: &UnitName| timeline.life_of(unit.cascade).is_some_and(|(_, life)| life.is_over(tick));
            self.wish(|subscriptions| subscriptions.forget(over));
        }
        // A change that is being decided will do it.
        let Ok(_gate) = self.gate.try_lock() else { return };
        let Current { sequence, timeline } = self.current();
        if let Ok(Some(timeline)) = spawn_blocking(move || timeline.without_ended(tick)).await {
            self.adopt(Current { sequence, timeline: Arc::new(timeline) });
        }
    }

    /// Keeps the engine from making `tick` and later ones until the answer is dropped.
    pub(super) fn hold(self: &Arc<Self>, tick: i64) -> Held {
        self.source.hold(Some(tick));
        Held { ocean: Arc::clone(self) }
    }

    /// Notes, every few seconds, how far time has come.
    pub(super) async fn note_time(self: &Arc<Self>) {
        let mut noted = Arc::clone(&self.noted).lock_owned().await;
        let tick = self.tick();
        if (*noted..noted.saturating_add(NOTE_EVERY)).contains(&tick) {
            return;
        }
        let store = Arc::clone(&self.store);
        let note = move || {
            if let Err(error) = store.reach(tick) {
                tracing::error!(%error, "noting the time");
            }
            *noted = tick;
            // The store first: whoever waits for the lock may open it again.
            drop(store);
            drop(noted);
        };
        if let Err(error) = spawn_blocking(note).await {
            tracing::error!(%error, "noting the time");
        }
    }

    /// Waits until nothing is being noted or composed.
    pub(super) async fn settle(&self) {
        drop(self.noted.lock().await);
        drop(self.composing.lock().await);
    }

    /// Puts a new timeline in force. The caller holds the gate and has written the log.
    pub(super) fn adopt(&self, current: Current) {
        let (before, after) = (self.current().timeline.layout().generation, current.timeline.layout().generation);
        self.source.set_timeline(Arc::clone(&current.timeline));
        *self.current.write().unwrap_or_else(PoisonError::into_inner) = current;
        if after != before {
            // Who still wants units of these numbers means cascades that ended long ago.
            self.wish(|subscriptions| subscriptions.forget(|unit| Layout::numbers(after, unit.cascade)));
        }
    }

    pub(super) fn wish<T>(&self, change: impl FnOnce(&mut Subscriptions) -> T) -> T {
        // The engine is told under the lock, so that it hears of demands in their order.
        let mut wishes = self.wishes.lock().unwrap_or_else(PoisonError::into_inner);
        let result = change(&mut wishes.subscriptions);
        let demand = wishes.subscriptions.demand();
        if demand != wishes.demand {
            self.source.set_demand(demand.clone());
            wishes.demand = demand;
        }
        result
    }
}
