//! How a change is accepted: checked, built, written to the log, put in force and told, one after the other.

use std::sync::Arc;

use http::StatusCode;
use tokio::task::spawn_blocking;

use super::allowance::Allowance;
use super::hello::reach;
use super::ocean::{Current, Held, Ocean};
use crate::body::{Problem, When};
use crate::control::{Answer, Key, StoreError};
use crate::scene::{Change, ChangeKind, CrossFade};
use crate::sea::{Cascade, MAX_OVERLAPPING, Timeline};
use crate::wire::{TICKS_PER_SECOND, WireChange, WireChangeKind};

/// Between the first frames that a change can act on and its acceptance: room for the disk, 100 ms.
const MARGIN: i64 = TICKS_PER_SECOND / 10;
/// How long before it acts a change can be announced: a day. Further out, a slip of the hand would be for ever.
const FARTHEST: i64 = 86_400 * TICKS_PER_SECOND;
/// Most changes that are accepted and not yet over; each holds a spectrum ...
pub const MAX_OPEN: usize = 64;
/// ... and of large ones fewer: cells of all their tables, a gigabyte.
const MAX_OPEN_CELLS: usize = 100_000_000;
/// How long before it acts a change of layout can be announced, ten minutes: until it is over there is no other.
const FARTHEST_LAYOUT: i64 = 600 * TICKS_PER_SECOND;
/// Longest that building is expected to take, ticks: a minute.
const LONGEST_BUILD: i64 = 60 * TICKS_PER_SECOND;
/// Changes that may come at once, and how fast that allowance grows back.
const BURST: i64 = 64;
const TICKS_PER_CHANGE: i64 = TICKS_PER_SECOND / 2;
/// How often a change without a tick of its own is built again because building took longer than expected.
const ATTEMPTS: u32 = 4;

/// A change that somebody asks for.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// What is to change.
    pub kind: ChangeKind,
    /// When.
    pub when: When,
    /// How long the sea takes to follow.
    pub transition_s: f64,
    /// Name of the request, for a sender that may repeat it.
    pub key: Option<String>,
    /// Newest entries of the log that the sender has in mind; `None`: any.
    pub if_match: Option<Vec<u64>>,
}

/// What deciding needs to remember.
#[derive(Debug)]
pub struct Gate {
    /// Changes that may not be over yet.
    open: Vec<Change>,
    /// Ticks that building a timeline is expected to take.
    build: i64,
    allowance: Allowance,
}

impl Gate {
    /// A gate after `changes`, where building took `build_us`.
    pub fn new(changes: Vec<Change>, build_us: i64, tick: i64) -> Self {
        let mut gate = Self { open: changes, build: 0, allowance: Allowance::new(BURST, TICKS_PER_CHANGE) };
        gate.forget(tick);
        gate.expect(build_us);
        gate
    }

    fn forget(&mut self, tick: i64) {
        self.open.retain(|change| change.effective_tick.saturating_add(change.transition_ticks) > tick);
    }

    fn expect(&mut self, build_us: i64) {
        // Half as long again as last time.
        self.build = (build_us.saturating_mul(TICKS_PER_SECOND) / 1_000_000 * 3 / 2).clamp(36, LONGEST_BUILD);
    }

    fn admit(&mut self, tick: i64, cells: usize) -> Result<(), Problem> {
        let most = (MAX_OPEN_CELLS / cells.max(1)).clamp(2, MAX_OPEN);
        if self.open.len() >= most {
            let detail = format!("{} changes are accepted and not yet over, must be below {most}", self.open.len());
            return Err(Problem::conflict("too-many-changes", detail));
        }
        if !self.allowance.take(tick) {
            let title = "Too many changes";
            let detail = format!("more than {BURST} changes at once, or 2 a second for long");
            return Err(Problem::new(StatusCode::TOO_MANY_REQUESTS, "too-fast", title, detail).retry_after(1));
        }
        Ok(())
    }
}

impl Ocean {
    /// Decides on a change. Goes on to its end even when the asker has gone.
    ///
    /// # Errors
    /// `Problem`; the sea and the log are then as before.
    pub async fn propose(self: &Arc<Self>, proposal: Proposal) -> Result<Answer, Problem> {
        let (ocean, arrived) = (Arc::clone(self), self.tick());
        let decide = tokio::spawn(async move {
            let answer = ocean.decide(proposal, arrived).await;
            if answer.is_ok() {
                let ocean = Arc::clone(&ocean);
                tokio::spawn(async move {
                    ocean.refresh_status().await;
                    ocean.bulletin.wake();
                });
            }
            answer
        });
        decide.await.unwrap_or_else(|error| Err(failed(&error)))
    }

    async fn decide(self: &Arc<Self>, proposal: Proposal, arrived: i64) -> Result<Answer, Problem> {
        if !self.source.can_change() {
            return Err(Problem::conflict("recorded", "this sea was recorded: it can't be changed any more"));
        }
        let mut gate = self.gate.lock().await;
        let Current { sequence, timeline } = self.current();
        let kind = proposal.kind.clone().check()?;
        let key = proposal.key.as_ref().map(|id| {
            let request = (&kind, proposal.when, proposal.transition_s);
            Key { id: id.clone(), request: serde_json::to_string(&request).unwrap_or_default() }
        });
        if let Some(answer) = self.answered(&key).await? {
            return Ok(answer);
        }
        if proposal.if_match.as_ref().is_some_and(|wanted| !wanted.contains(&sequence)) {
            let detail = format!("the newest entry of the log is {sequence}, which If-Match does not name");
            let title = "The sea has changed meanwhile";
            return Err(Problem::new(StatusCode::PRECONDITION_FAILED, "changed-meanwhile", title, detail)
                .at("If-Match")
                .allowed(format!("\"{sequence}\"")));
        }
        gate.forget(self.tick());
        // Checked before the allowance is touched: such a refusal costs nothing.
        let first = self.change_of(&proposal, &kind, sequence + 1, arrived, gate.build)?;
        fit(&timeline, &first, self.tick())?;
        gate.admit(self.tick(), timeline.layout().cascades.iter().map(Cascade::cells).sum())?;
        let (change, next, held) = self.build(&proposal, kind, sequence + 1, arrived, &timeline, &mut gate).await?;
        let (store, written, entry) = (Arc::clone(&self.store), key, change.clone());
        let answer = spawn_blocking(move || store.append(&entry, written.as_ref())).await.map_err(|e| failed(&e))??;
        for warning in next.warnings().iter().filter(|warning| !timeline.warnings().contains(warning)) {
            tracing::warn!("{warning}");
        }
        self.put_in_force(change, next, Some(held), &mut gate);
        Ok(answer)
    }

    /// Takes up a change that was accepted before, as it was. Blocks while its sea is built.
    ///
    /// # Errors
    /// `Problem` when it does not follow from what there is.
    pub(super) fn take_up(&self, change: Change) -> Result<(), Problem> {
        let mut gate = self.gate.blocking_lock();
        let (Current { sequence, timeline }, now) = (self.current(), self.tick());
        gate.forget(now);
        if change.sequence != sequence + 1 || gate.open.len() >= MAX_OPEN {
            let detail = format!("entry {sequence} is the newest, {} are not over yet", gate.open.len());
            return Err(Problem::conflict("recorded", detail).allowed(MAX_OPEN));
        }
        timeline.check(&change).map_err(|(_, error)| Problem::from(error))?;
        let next = Arc::new(timeline.with(change.clone(), now));
        crowd(&next, gate.open.iter().chain([&change]))?;
        self.store.append(&change, None)?;
        self.put_in_force(change, next, None, &mut gate);
        self.compose_status();
        self.bulletin.wake();
        Ok(())
    }

    fn put_in_force(&self, change: Change, timeline: Arc<Timeline>, held: Option<Held>, gate: &mut Gate) {
        self.adopt(Current { sequence: change.sequence, timeline });
        drop(held);
        let hello = CrossFade::of(&change).map(|_| self.hello());
        self.bulletin.post_change(told(&change), hello);
        gate.open.push(change);
    }

    async fn answered(&self, key: &Option<Key>) -> Result<Option<Answer>, Problem> {
        let Some(key) = key.clone() else { return Ok(None) };
        let store = Arc::clone(&self.store);
        let answer: Result<_, StoreError> = spawn_blocking(move || store.answer(&key)).await.map_err(|e| failed(&e))?;
        Ok(answer?)
    }

    /// Builds the timeline with the change, at a tick that is still to come when it is built.
    async fn build(
        self: &Arc<Self>,
        proposal: &Proposal,
        kind: ChangeKind,
        sequence: u64,
        arrived: i64,
        timeline: &Arc<Timeline>,
        gate: &mut Gate,
    ) -> Result<(Change, Arc<Timeline>, Held), Problem> {
        for _ in 0..ATTEMPTS {
            let change = self.change_of(proposal, &kind, sequence, arrived, gate.build)?;
            let effective_tick = change.effective_tick;
            let (now, started) = (self.tick(), self.clock.now_us());
            fit(timeline, &change, now)?;
            let (timeline, new) = (Arc::clone(timeline), change.clone());
            let built = spawn_blocking(move || Arc::new(timeline.with(new, now))).await;
            let next = built.map_err(|error| failed(&error))?;
            gate.expect(self.clock.now_us() - started);
            crowd(&next, gate.open.iter().chain([&change]))?;
            // From here on the engine makes no tick that the change would alter, however long the disk takes.
            let held = self.hold(effective_tick);
            if effective_tick >= self.tick() + reach() + MARGIN {
                return Ok((change, next, held));
            }
            if gate.build == LONGEST_BUILD {
                break;
            }
        }
        let detail = format!("building the change took longer than expected, up to {ATTEMPTS} times");
        Err(Problem::new(StatusCode::SERVICE_UNAVAILABLE, "too-slow", "The server is too busy", detail).retry_after(1))
    }

    /// The entry that a proposal would be now, if it can be built before the first frames of its tick leave.
    fn change_of(
        &self,
        proposal: &Proposal,
        kind: &ChangeKind,
        sequence: u64,
        arrived: i64,
        build: i64,
    ) -> Result<Change, Problem> {
        let earliest = self.tick() + reach() + MARGIN + build;
        let tick = proposal.when.tick(arrived, earliest);
        let (field, value) = match proposal.when {
            When::Soon => ("effective_tick", None),
            When::Tick(tick) => ("effective_tick", Some(serde_json::Value::from(tick))),
            When::In(s) => ("in_seconds", Some(serde_json::Value::from(s))),
        };
        let transition_ticks = Change::check_time(kind, tick, proposal.transition_s)?;
        let farthest = if let ChangeKind::Layout { .. } = kind { FARTHEST_LAYOUT } else { FARTHEST };
        let latest = earliest.saturating_add(farthest);
        if tick > latest {
            let detail = format!("the change would act at tick {tick}; the latest it can be announced for is {latest}");
            let title = "Too far ahead: a change can be announced a day before it acts, one of layout ten minutes";
            return Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "too-far", title, detail)
                .at(field)
                .found(value.unwrap_or_default())
                .allowed(latest));
        }
        if tick >= earliest {
            return Ok(Change { sequence, effective_tick: tick, transition_ticks, kind: kind.clone() });
        }
        let detail = format!("the change would act at tick {tick}; the earliest it can act at is {earliest}");
        let title = "Too early: frames of that tick are on their way";
        Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "too-early", title, detail)
            .at(field)
            .found(value.unwrap_or_default())
            .allowed(earliest))
    }
}

/// Refuses a change that can't act as things will be at its tick, or after which an accepted one no longer could.
fn fit(timeline: &Timeline, change: &Change, now: i64) -> Result<(), Problem> {
    let settled = timeline.layout_settled();
    if CrossFade::of(change).is_some() && now < settled {
        let detail = format!("the change of layout before it is settled at tick {settled}; now is tick {now}");
        return Err(Problem::conflict("layout-under-way", detail).allowed(settled));
    }
    timeline.check(change).map_err(|(sequence, error)| {
        if sequence == change.sequence {
            return error.into();
        }
        let detail = format!("entry {sequence} of the log is accepted and could then not act: {error}");
        Problem::conflict("against-accepted", detail).allowed(sequence)
    })
}

/// Refuses a timeline with too many transitions under way at once. They can only be most just after one begins.
fn crowd<'a>(timeline: &Timeline, changes: impl Iterator<Item = &'a Change>) -> Result<(), Problem> {
    for change in changes {
        let under_way = timeline.overlapping(change.effective_tick.saturating_add(1));
        if under_way > MAX_OVERLAPPING {
            let tick = change.effective_tick;
            let detail =
                format!("{under_way} transitions would be under way after tick {tick}, at most {MAX_OVERLAPPING}");
            return Err(Problem::conflict("too-many-transitions", detail).at("transition_s").allowed(MAX_OVERLAPPING));
        }
    }
    Ok(())
}

/// A change as clients are told.
pub fn told(change: &Change) -> WireChange {
    let Change { sequence, effective_tick, transition_ticks, kind } = change.clone();
    let change = match kind {
        ChangeKind::Wind { speed_mps, direction_from_deg } => WireChangeKind::Wind { speed_mps, direction_from_deg },
        ChangeKind::Water { depth_m, gravity } => WireChangeKind::Water { depth_m, gravity },
        ChangeKind::Layout { cascades, wind_range_mps } => WireChangeKind::Layout {
            n: cascades.n.map(|n| u32::try_from(n).unwrap_or(u32::MAX)),
            band_limit: cascades.band_limit,
            finest_wavelength_m: cascades.finest_wavelength_m,
            patches_m: cascades.patches_m,
            wind_range_mps,
        },
    };
    WireChange { sequence, effective_tick, transition_ticks, change }
}

fn failed(error: &tokio::task::JoinError) -> Problem {
    tracing::error!(%error, "change");
    Problem::internal("the change could not be made; see the server's log")
}
