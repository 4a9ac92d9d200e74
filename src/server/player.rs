//! Plays a recording: gives its frames when they are due, as the engine would.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use bytes::Bytes;
use tokio::sync::Notify;

use super::offer::Offer;
use crate::engine::{Batch, Clock, Counters, Publish, Work};
use crate::recording::{Block, Recording};
use crate::tile::SentFrame;
use crate::wire::{TICKS_PER_SECOND, WireChange};

/// The name that stands where that of a backend would.
const NAME: &str = "recording";
/// Frames that could not leave for so long are passed over: 250 ms.
const STALE: i64 = TICKS_PER_SECOND / 4;

/// Which part of a recording is played again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// The first tick.
    pub first: i64,
    /// How many ticks.
    pub span: i64,
}

/// A recording under way; stops when it is dropped.
#[derive(Debug)]
pub struct Player {
    shared: Arc<Shared>,
    /// What is recorded at this moment.
    pub offer: Arc<Offer>,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    counters: Mutex<Counters>,
    alive: AtomicBool,
    /// Somebody watches.
    wanted: AtomicBool,
    over: Notify,
}

/// Where what is played goes.
pub struct Stage {
    /// What can be had.
    pub offer: Arc<Offer>,
    /// Frames. Runs on the player's thread and must not block.
    pub publish: Publish,
    /// Changes of the sea.
    pub announce: Sender<WireChange>,
}

impl Player {
    /// Plays a recording from a block on, or a part of it for ever.
    ///
    /// # Panics
    /// If the system gives no thread.
    pub fn start(recording: Recording, from: usize, round: Option<Round>, clock: Clock, stage: Stage) -> Self {
        let offer = Arc::clone(&stage.offer);
        let counters = Counters { backend: NAME, foam_warm: true, ..Counters::default() };
        let shared = Arc::new(Shared {
            counters: Mutex::new(counters),
            alive: AtomicBool::new(true),
            wanted: AtomicBool::new(false),
            over: Notify::new(),
        });
        let (stop, stopped) = channel();
        let of_thread = Arc::clone(&shared);
        let work = move || {
            let play = Play { shared: &of_thread, recording, clock, stage, stopped };
            let _over = Over(&of_thread);
            play.run(from, round);
        };
        let thread = std::thread::Builder::new().name("swellcast-player".to_owned()).spawn(work);
        let thread = Some(thread.expect("the system gives a thread at start"));
        Self { shared, offer, stop: Some(stop), thread }
    }

    /// What has been done so far.
    pub fn counters(&self) -> Counters {
        self.shared.counters.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether there is more to come.
    pub fn is_alive(&self) -> bool {
        self.shared.alive.load(Relaxed)
    }

    /// Nothing is read while nobody watches.
    pub fn set_wanted(&self, wanted: bool) {
        self.shared.wanted.store(wanted, Relaxed);
    }

    /// Waits until the last tick has come.
    pub async fn over(&self) {
        self.shared.over.notified().await;
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so on standard error.
            let _ = thread.join();
        }
    }
}

/// Says that it is over, however the thread ends.
struct Over<'a>(&'a Shared);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.alive.store(false, Relaxed);
        self.0.over.notify_one();
    }
}

struct Play<'a> {
    shared: &'a Shared,
    recording: Recording,
    clock: Clock,
    stage: Stage,
    stopped: Receiver<()>,
}

impl Play<'_> {
    fn run(mut self, from: usize, round: Option<Round>) {
        let (mut at, mut shift) = (from, 0);
        let end =
            round.map_or(self.recording.len(), |round| self.recording.at(self.leaves_of(round.first + round.span)));
        loop {
            if at >= end {
                let Some(Round { first, span }) = round else { break };
                (at, shift) = (self.recording.at(self.leaves_of(first)), shift + span);
            }
            let Some(leaves) = self.recording.leaves(at) else { break };
            if !self.wait(leaves + shift) {
                return;
            }
            let late = self.clock.now_tick() - (leaves + shift) > STALE;
            let mut frames = self.take(at, shift, round, late);
            if let Some(Round { span, .. }) = round.filter(|_| shift > 0) {
                // What lies between the last frames of the round before leaves after the first of this one.
                let before = self.recording.at(leaves + span);
                if self.recording.leaves(before) == Some(leaves + span) {
                    frames.extend(self.take(before, shift - span, round, late));
                }
            }
            self.publish(leaves + shift + self.lead(), frames);
            at += 1;
        }
        let last = self.recording.leaves(self.recording.len().wrapping_sub(1));
        let _ = last.is_none_or(|leaves| self.wait(leaves + self.lead()));
    }

    fn lead(&self) -> i64 {
        self.recording.preface().hello.lead_ticks
    }

    /// When the first frames of a tick leave.
    fn leaves_of(&self, tick: i64) -> i64 {
        tick - self.lead()
    }

    /// Waits for a tick; false to stop.
    fn wait(&self, tick: i64) -> bool {
        loop {
            let left = self.clock.until(tick);
            if self.stopped.recv_timeout(left) != Err(RecvTimeoutError::Timeout) {
                return false;
            }
            // A long wait comes in parts.
            if self.clock.now_tick() >= tick {
                return true;
            }
        }
    }

    /// Reads a block. What of it is frames is given, `shift` ticks later than they were recorded.
    fn take(&mut self, at: usize, shift: i64, round: Option<Round>, late: bool) -> Vec<SentFrame> {
        if self.recording.is_of_frames(at) {
            if !self.shared.wanted.load(Relaxed) {
                return Vec::new();
            }
            if late {
                self.count(|counters| counters.skipped_frames += 1);
                return Vec::new();
            }
        }
        match self.recording.block(at) {
            Ok(Block::Frames { bytes, frames, .. }) => self.frames(bytes, &frames, shift, round),
            Ok(Block::Change(change)) => {
                // Nobody listens while the server ends.
                let _ = self.stage.announce.send(change);
                Vec::new()
            }
            Ok(Block::Taken(taken)) => {
                self.stage.offer.replace(&taken);
                Vec::new()
            }
            Err(error) => {
                tracing::error!(%error, "recording");
                self.count(|counters| counters.backend_errors += 1);
                Vec::new()
            }
        }
    }

    fn frames(&self, bytes: Vec<u8>, places: &[(usize, usize)], shift: i64, round: Option<Round>) -> Vec<SentFrame> {
        let bytes = Bytes::from(bytes);
        let (mut frames, mut refused) = (Vec::with_capacity(places.len()), 0);
        for (begin, end) in places {
            match SentFrame::read(bytes.slice(*begin..*end)) {
                Ok(frame) if round.is_none() => frames.push(frame),
                Ok(frame) => {
                    let within = round.is_some_and(|Round { first, span }| (first..first + span).contains(&frame.tick));
                    frames.extend(within.then(|| frame.later(shift)));
                }
                Err(error) => {
                    tracing::error!(%error, "recording");
                    refused += 1;
                }
            }
        }
        self.count(|counters| counters.refused_frames += refused);
        frames
    }

    fn publish(&mut self, tick: i64, frames: Vec<SentFrame>) {
        if frames.is_empty() {
            return;
        }
        self.count(|counters| {
            counters.steps += 1;
            counters.tick = Some(tick);
        });
        let work = Work::default();
        (self.stage.publish)(Batch { tick, frames, points: Vec::new(), backend: NAME, refused: 0, work, step_ms: 0.0 });
    }

    fn count(&self, change: impl FnOnce(&mut Counters)) {
        change(&mut self.shared.counters.lock().unwrap_or_else(PoisonError::into_inner));
    }
}
