//! A recording served as if it were live: the same sea at a later time of day.

use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Weak};

use super::ocean::Ocean;
use super::offer::Offer;
use super::player::{Player, Round, Stage};
use super::proposal::MAX_OPEN;
use super::settings::Settings;
use super::source::Source;
use crate::control::{Begun, Epoch, Store};
use crate::engine::Clock;
use crate::recording::{Block, Preface, Recording, RecordingError};
use crate::scene::{CascadesFile, Change, ChangeKind, Scene, SceneFile};
use crate::wire::{TICKS_PER_SECOND, WireChange, WireChangeKind};

/// The first frames leave so long after the beginning, ticks: half a second.
const HEADSTART: i64 = TICKS_PER_SECOND / 2;

/// How a recording is served.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReplaySettings {
    /// Seconds of it that are left out.
    pub from_s: f64,
    /// Again and again. The sea must repeat itself, and be recorded for as long as it takes to.
    pub repeat: bool,
}

impl Ocean {
    /// Serves a recording. Blocks as [`Ocean::start`] does.
    ///
    /// # Errors
    /// [`RecordingError`] when the recording is damaged, or can't be served in this way.
    pub fn replay(
        mut recording: Recording,
        replay: ReplaySettings,
        settings: Settings,
    ) -> Result<Arc<Self>, RecordingError> {
        let path = recording.path().to_owned();
        let preface = recording.preface().clone();
        let scene = scene_of(&path, &preface)?;
        let first = recording.leaves(0);
        let first = first.ok_or_else(|| RecordingError::field(&path, "blocks", 0, "at least 1"))?;
        let skipped = (replay.from_s * TICKS_PER_SECOND as f64) as i64;
        let from = recording.at(first.saturating_add(skipped));
        let begins = recording.leaves(from).ok_or_else(|| {
            let last = recording.leaves(recording.len().wrapping_sub(1)).unwrap_or(first);
            let bound = format!("below {} s", (last - first) / TICKS_PER_SECOND);
            RecordingError::field(&path, "beginning", format!("{} s", replay.from_s), bound)
        })?;
        let round = replay.repeat.then(|| round_of(&recording, begins, &scene)).transpose()?;
        // What was announced before is part of the sea.
        let mut changes: Vec<Change> = preface.changes.iter().map(heard).collect();
        let mut taken = preface.taken.clone();
        for block in (0..from).filter(|block| !recording.is_of_frames(*block)).collect::<Vec<_>>() {
            match recording.block(block)? {
                Block::Change(change) => changes.push(heard(&change)),
                Block::Taken(new) => taken = new,
                Block::Frames { .. } => {}
            }
        }
        let course = Change::check_course(&scene, &changes);
        course.map_err(|(sequence, error)| {
            RecordingError::field(&path, "changes", format!("wrong in entry {sequence}: {error}"), "those of a log")
        })?;
        let open = changes.iter().filter(|change| change.effective_tick > begins).count();
        if open > MAX_OPEN {
            let bound = format!("at most {MAX_OPEN}");
            return Err(RecordingError::field(&path, "changes that are to come at the beginning", open, bound));
        }
        let epoch = Epoch {
            id: u64::from_str_radix(&preface.hello.epoch, 16)
                .map_err(|_| RecordingError::field(&path, "hello.epoch", &preface.hello.epoch, "16 digits"))?,
            unix_ns: Clock::unix_now_ns().saturating_sub(ns_of(begins - HEADSTART)),
        };
        let store = Store::in_memory().and_then(|store| {
            store.begin(&scene, epoch)?;
            changes.iter().try_for_each(|change| store.append(change, None).map(drop))?;
            Ok(store)
        });
        let store = store.map_err(|error| RecordingError::field(&path, "changes", error, "those of a log"))?;
        let begun = Begun { epoch, scene, changes, reached_tick: 0 };
        let (announce, announced) = channel();
        let ocean = Self::with(store, begun, settings, |parts| {
            let stage = Stage { offer: Arc::new(Offer::new(&taken)), publish: parts.publish, announce };
            Source::Recording(Player::start(recording, from, round, parts.clock, stage))
        });
        let weak = Arc::downgrade(&ocean);
        let listen = move || follow(&weak, &announced);
        let thread = std::thread::Builder::new().name("swellcast-changes".to_owned()).spawn(listen);
        drop(thread.expect("the system gives a thread at start"));
        Ok(ocean)
    }
}

/// Takes up changes as they are announced.
fn follow(ocean: &Weak<Ocean>, announced: &Receiver<WireChange>) {
    while let Ok(change) = announced.recv() {
        let Some(ocean) = ocean.upgrade() else { return };
        if let Err(problem) = ocean.take_up(heard(&change)) {
            tracing::error!(change.sequence, ?problem, "the recording has a change that does not fit");
        }
    }
}

fn scene_of(path: &Path, preface: &Preface) -> Result<Scene, RecordingError> {
    let wrong = |error: String| RecordingError::field(path, "scene", error, "one that this version knows");
    let file: SceneFile = serde_json::from_value(preface.scene.clone()).map_err(|error| wrong(error.to_string()))?;
    file.check(None).map_err(|error| wrong(error.to_string()))
}

/// The part that can be played again and again: whole repeats of the sea, from the first second of which all is there.
fn round_of(recording: &Recording, begins: i64, scene: &Scene) -> Result<Round, RecordingError> {
    let refused = |got: String, bound: String| RecordingError::field(recording.path(), "what is repeated", got, bound);
    if recording.has_changes() {
        return Err(refused("a sea that changes".to_owned(), "one that does not".to_owned()));
    }
    let lead = recording.preface().hello.lead_ticks;
    let first = (begins + lead).div_euclid(TICKS_PER_SECOND) * TICKS_PER_SECOND + TICKS_PER_SECOND;
    let last = recording.leaves(recording.len().wrapping_sub(1)).map_or(first, |leaves| leaves + lead);
    let repeat = i64::try_from(scene.repeat.ticks).unwrap_or(i64::MAX);
    // Frames between the last two of a round wait for the second of them, half a second at most.
    let whole = (last - first - TICKS_PER_SECOND / 2).max(0) / repeat;
    let mut span = whole.saturating_mul(repeat);
    while span > 0 && span % TICKS_PER_SECOND != 0 {
        span -= repeat;
    }
    if span <= 0 {
        let s = |ticks: i64| format!("{:.1} s", ticks as f64 / TICKS_PER_SECOND as f64);
        let bound = format!("{} or more of whole seconds (`loop_s` of the scene), and 2 s besides", s(repeat));
        return Err(refused(s(last - first), bound));
    }
    Ok(Round { first, span })
}

fn ns_of(ticks: i64) -> i64 {
    i64::try_from(i128::from(ticks) * 1_000_000_000 / i128::from(TICKS_PER_SECOND)).unwrap_or(i64::MAX)
}

/// A change as the log has it, from what clients were told.
fn heard(change: &WireChange) -> Change {
    let WireChange { sequence, effective_tick, transition_ticks, change } = change.clone();
    let kind = match change {
        WireChangeKind::Wind { speed_mps, direction_from_deg } => ChangeKind::Wind { speed_mps, direction_from_deg },
        WireChangeKind::Water { depth_m, gravity } => ChangeKind::Water { depth_m, gravity },
        WireChangeKind::Layout { n, band_limit, finest_wavelength_m, patches_m, wind_range_mps } => {
            let n = n.map(|n| n as usize);
            ChangeKind::Layout {
                cascades: CascadesFile { n, band_limit, finest_wavelength_m, patches_m },
                wind_range_mps,
            }
        }
    };
    Change { sequence, effective_tick, transition_ticks, kind }
}
