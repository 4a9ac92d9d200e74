//! Which backend computes: the CPU from the first tick, another where it is asked for or better, the CPU again when that
//! one is lost, and the other again after a while.

use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use super::clock::Clock;
use super::trial::Trial;
use crate::backend::{Backend, BackendError, Cpu};
use crate::sea::Timeline;

/// First and longest pause before the other backend is tried again, microseconds.
const PAUSES_US: [i64; 2] = [1_000_000, 60_000_000];
/// A backend that has computed for so long before it was lost is tried again as if it had been the first time.
const PROVEN_US: i64 = 60_000_000;

/// What computes the sea.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// The faster one on this scene, of those within the error bound.
    Auto,
    /// The CPU.
    #[default]
    Cpu,
    /// The GPU as long as there is one.
    Gpu,
}

/// Opens the other backend, or says why there is none.
#[derive(Clone)]
pub struct Opener(pub Arc<dyn Fn() -> Result<Box<dyn Backend>, String> + Send + Sync>);

impl fmt::Debug for Opener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Opener")
    }
}

impl Opener {
    /// Opens a GPU with these settings.
    #[cfg(feature = "gpu")]
    pub fn gpu(settings: crate::backend::GpuSettings) -> Self {
        Self(Arc::new(move || match crate::backend::Gpu::open(&settings) {
            Ok(gpu) => Ok(Box::new(gpu)),
            Err(error) => Err(error.to_string()),
        }))
    }
}

/// What came of opening the other backend.
enum Verdict {
    /// It is to compute.
    Taken,
    /// It may be better later.
    Failed(String),
    /// It will be no better.
    Refused(String),
}

/// The same, with the backend where it is to compute.
type Opened = (Verdict, Option<Box<dyn Backend>>);

/// Chooses, tries, and takes back.
pub struct Backends {
    choice: BackendChoice,
    threads: Option<usize>,
    opener: Option<Opener>,
    clock: Clock,
    opening: Option<Receiver<Opened>>,
    /// When the other one is opened next, microseconds; `None`: not at all.
    open_at: Option<i64>,
    pause_us: i64,
    /// Whether the other one ever computed.
    taken: bool,
    /// Since when it does.
    since: Option<i64>,
    /// Why the CPU computes where something else was asked for.
    note: Option<String>,
}

impl Backends {
    /// Nothing is opened before [`Backends::arrived`] is asked.
    pub fn new(choice: BackendChoice, threads: Option<usize>, opener: Option<Opener>, clock: Clock) -> Self {
        let wanted = choice != BackendChoice::Cpu && opener.is_some();
        let open_at = wanted.then_some(i64::MIN);
        let (opening, pause_us) = (None, PAUSES_US[0]);
        Self { choice, threads, opener, clock, opening, open_at, pause_us, taken: false, since: None, note: None }
    }

    /// The CPU, which is always there.
    pub fn cpu(&self) -> Box<dyn Backend> {
        Box::new(Cpu::new(self.threads))
    }

    /// Whether the other backend computes.
    pub fn other_computes(&self) -> bool {
        self.since.is_some()
    }

    /// Why the CPU computes where something else was asked for.
    pub fn note(&self) -> Option<String> {
        self.note.clone()
    }

    /// The other backend, when it has been opened, tried, and found to be the one that should compute. Opens it beside
    /// the engine where it is time.
    pub fn arrived(&mut self, timeline: &Arc<Timeline>) -> Option<Box<dyn Backend>> {
        let now = self.clock.now_us();
        if self.opening.is_none() && self.open_at.is_some_and(|at| at <= now) {
            self.open_at = None;
            self.open(Arc::clone(timeline));
        }
        let opened = match self.opening.as_ref()?.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(opened) => opened,
            Err(TryRecvError::Disconnected) => (Verdict::Failed("opening it panicked".to_owned()), None),
        };
        self.opening = None;
        let (verdict, backend) = opened;
        match verdict {
            Verdict::Taken => {
                (self.taken, self.since, self.note) = (true, Some(now), None);
                backend
            }
            Verdict::Failed(why) => {
                self.later(&why, now);
                None
            }
            Verdict::Refused(why) => {
                tracing::info!("the CPU computes: {why}");
                self.note = Some(why);
                None
            }
        }
    }

    /// Takes note that the other backend was lost, which the CPU has to replace.
    pub fn lost(&mut self, error: &BackendError) -> Box<dyn Backend> {
        let now = self.clock.now_us();
        if self.since.take().is_some_and(|since| now - since >= PROVEN_US) {
            self.pause_us = PAUSES_US[0];
        }
        match error {
            BackendError::Unsupported(_) => self.note = Some(error.to_string()),
            _ => self.later(&error.to_string(), now),
        }
        self.cpu()
    }

    fn later(&mut self, why: &str, now: i64) {
        let seconds = self.pause_us as f64 / 1e6;
        let note = format!("{why}; tried again in {seconds} s");
        tracing::warn!("the CPU computes: {note}");
        (self.note, self.open_at) = (Some(note), Some(now + self.pause_us));
        self.pause_us = (2 * self.pause_us).min(PAUSES_US[1]);
    }

    fn open(&mut self, timeline: Arc<Timeline>) {
        let Some(Opener(opener)) = self.opener.clone() else { return };
        let (choice, threads, clock) = (self.choice, self.threads, self.clock);
        // One that was never there won't come; one that was lost may, and so may one that is insisted on.
        let again = self.taken || choice == BackendChoice::Gpu;
        // One message, and nobody waits to send it.
        let (sender, receiver) = sync_channel(1);
        let work = move || {
            let mut held = None;
            let opened = match opener() {
                Ok(backend) => try_out(held.insert(backend).as_mut(), choice, threads, &timeline, &clock),
                Err(why) if again => Verdict::Failed(why),
                Err(why) => Verdict::Refused(why),
            };
            // Told before a backend that is not taken is let go, which may take its time.
            let taken = if let Verdict::Taken = opened { held.take() } else { None };
            let _ = sender.send((opened, taken));
        };
        match std::thread::Builder::new().name("swellcast-opener".to_owned()).spawn(work) {
            Ok(_) => self.opening = Some(receiver),
            Err(error) => self.later(&error.to_string(), self.clock.now_us()),
        }
    }
}

fn try_out(
    backend: &mut dyn Backend,
    choice: BackendChoice,
    threads: Option<usize>,
    timeline: &Timeline,
    clock: &Clock,
) -> Verdict {
    let name = backend.name();
    match Trial::run(backend, &mut Cpu::new(threads), timeline, clock.now_tick(), clock) {
        Err(error @ BackendError::Unsupported(_)) => Verdict::Refused(format!("{name}: {error}")),
        Err(error) => Verdict::Failed(format!("{name}: {error}")),
        Ok(trial) if choice == BackendChoice::Gpu => {
            let truth = if trial.is_true() { "" } else { ", more than a twin may have" };
            tracing::info!("{name} computes, as it was asked to: {}{truth}", trial.told());
            Verdict::Taken
        }
        Ok(trial) if !trial.is_true() => Verdict::Refused(format!("{name} errs too much: {}", trial.told())),
        Ok(trial) if !trial.is_faster() => Verdict::Refused(format!("{name} is slower: {}", trial.told())),
        Ok(trial) => {
            tracing::info!("{name} computes: {}", trial.told());
            Verdict::Taken
        }
    }
}
