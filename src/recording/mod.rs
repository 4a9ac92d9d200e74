//! A stream in a file: what a client of a server received, with the scene it is of, so that it can be served again.
//!
//! Invariant: nothing that stands in a file makes a reader panic, hang, or hold more memory than one block.
//! `docs/recording.md` is the format.

mod read;
mod write;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

use crate::wire::{Hello, TICKS_PER_SECOND, UnitName, UnitRate, WireChange};

pub use read::{Block, Recording};
pub use write::RecordingWriter;

/// First bytes of a file, and of what stands in it.
const MAGIC: [u8; 8] = *b"SWREC\0\0\x01";
const BLOCK_MAGIC: [u8; 4] = *b"BLCK";
const INDEX_MAGIC: [u8; 4] = *b"INDX";
const END_MAGIC: [u8; 8] = *b"SWREC\0\0E";
/// Before a block's contents: magic, kind, the tick at which it leaves, bytes that follow, checksum of these four.
const BLOCK_HEAD: usize = 32;
/// One block in the index: the tick at which it leaves, where it stands, its kind.
const ENTRY: usize = 24;
/// Behind the index: where it stands, how many entries it has, checksum of all of it, magic.
const FOOTER: usize = 32;
/// Largest preface, and largest block.
const MOST_PREFACE: usize = 16 << 20;
const MOST_BLOCK: usize = 256 << 20;
/// Most units that are recorded, as many as a client can have.
const MOST_UNITS: usize = 64;

/// What a recording is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Preface {
    /// The server's first message.
    pub hello: Hello,
    /// The scene that the timeline began with, as `GET /v1/scenes/{name}` has it.
    pub scene: Value,
    /// The log up to the beginning of the recording.
    pub changes: Vec<WireChange>,
    /// What is recorded, until a block says otherwise.
    pub taken: Taken,
}

/// Units that are recorded, at most 64.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Taken {
    /// Frames a second of units that have no rate of their own.
    pub rate_hz: u32,
    /// The units.
    pub units: Vec<UnitRate>,
}

/// Why a recording can't be written, or is none.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The system's.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file that is no recording, or one that is damaged.
    #[error("{}: {field} is {got}, must be {bound}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field.
        field: &'static str,
        /// What it holds.
        got: String,
        /// What it may hold.
        bound: String,
    },
}

impl Taken {
    /// Each unit with the ticks between its frames.
    pub fn intervals(&self) -> Vec<(UnitName, i64)> {
        let rate = |unit: &UnitRate| i64::from(unit.rate_hz.unwrap_or(self.rate_hz));
        let interval = |unit: &UnitRate| TICKS_PER_SECOND / rate(unit).clamp(1, TICKS_PER_SECOND);
        self.units.iter().map(|unit| (unit.unit, interval(unit))).collect()
    }
}

impl RecordingError {
    /// A field that is not as it must be.
    pub fn field(path: &Path, field: &'static str, got: impl ToString, bound: impl ToString) -> Self {
        Self::Field { path: path.to_owned(), field, got: got.to_string(), bound: bound.to_string() }
    }
}

/// What a block holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Frames that leave together.
    Frames,
    /// One change of the sea, as clients are told.
    Change,
    /// Other units from now on.
    Taken,
}

impl Kind {
    fn id(self) -> u32 {
        match self {
            Self::Frames => 0,
            Self::Change => 1,
            Self::Taken => 2,
        }
    }

    fn from_id(id: u32) -> Option<Self> {
        [Self::Frames, Self::Change, Self::Taken].into_iter().find(|kind| kind.id() == id)
    }
}

/// One block in the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    leaves: i64,
    offset: u64,
    kind: Kind,
}
