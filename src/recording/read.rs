//! Reads a recording: what it is of, its index, and one block at a time.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crc32fast::Hasher;

use super::{
    BLOCK_HEAD, BLOCK_MAGIC, END_MAGIC, ENTRY, Entry, FOOTER, INDEX_MAGIC, Kind, MAGIC, MOST_BLOCK, MOST_PREFACE,
    MOST_UNITS, Preface, RecordingError, Taken,
};
use crate::wire::{HEADER_BYTES, Hello, MAX_TICK, TICKS_PER_SECOND, WireChange};

/// Longest that a frame leaves before its tick.
const LONGEST_LEAD: i64 = 10 * TICKS_PER_SECOND;

/// An open recording.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    file: File,
    bytes: u64,
    preface: Preface,
    index: Vec<Entry>,
    whole: bool,
}

/// One block.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// Frames that leave together; each stands in `bytes` from `.0` to `.1`.
    Frames {
        /// All of them.
        bytes: Vec<u8>,
        /// Where each stands.
        frames: Vec<(usize, usize)>,
    },
    /// A change that is announced.
    Change(WireChange),
    /// Other units from now on.
    Taken(Taken),
}

impl Recording {
    /// Opens a file. One that was not finished is read through, and ends with its last whole block.
    ///
    /// # Errors
    /// [`RecordingError`] naming what is wrong.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let failed = |source| RecordingError::Io { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(failed)?;
        let bytes = file.metadata().map_err(failed)?.len();
        let mut head = [0; 16];
        let no_recording = |got: String| RecordingError::field(path, "magic", got, "that of a recording");
        file.read_exact(&mut head).map_err(|_| no_recording(format!("in a file of {bytes} bytes")))?;
        let (magic, length) = (&head[..8], u64_of(&head[8..]));
        if magic != MAGIC {
            return Err(no_recording(format!("{magic:?}")));
        }
        let most = (MOST_PREFACE as u64).min(bytes - 16);
        if length > most {
            return Err(RecordingError::field(path, "length of the preface", length, format!("at most {most}")));
        }
        let mut text = vec![0; length as usize];
        file.read_exact(&mut text).map_err(failed)?;
        let preface: Preface = serde_json::from_slice(&text)
            .map_err(|error| RecordingError::field(path, "the preface", error, "as docs/recording.md says"))?;
        check(path, &preface)?;
        let mut recording = Self { path: path.to_owned(), file, bytes, preface, index: Vec::new(), whole: true };
        let begins = 16 + length;
        match recording.read_index(begins)? {
            Some(index) => recording.index = index,
            None => {
                recording.index = recording.scan(begins)?;
                recording.whole = false;
            }
        }
        Ok(recording)
    }

    /// What it is of.
    pub fn preface(&self) -> &Preface {
        &self.preface
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it was finished.
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    /// Its blocks.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// The tick at which a block leaves.
    pub fn leaves(&self, block: usize) -> Option<i64> {
        self.index.get(block).map(|entry| entry.leaves)
    }

    /// Whether a block holds frames.
    pub fn is_of_frames(&self, block: usize) -> bool {
        self.index.get(block).is_some_and(|entry| entry.kind == Kind::Frames)
    }

    /// The first block that leaves at `tick` or later.
    pub fn at(&self, tick: i64) -> usize {
        self.index.partition_point(|entry| entry.leaves < tick)
    }

    /// Whether the sea, or what is recorded of it, changes on the way.
    pub fn has_changes(&self) -> bool {
        self.index.iter().any(|entry| entry.kind != Kind::Frames)
    }

    /// Reads a block. Its frames are not looked into.
    ///
    /// # Errors
    /// [`RecordingError`] when it is not there, or not as it must be.
    pub fn block(&mut self, block: usize) -> Result<Block, RecordingError> {
        let Entry { offset, kind, .. } = *self
            .index
            .get(block)
            .ok_or_else(|| RecordingError::field(&self.path, "block", block, format!("below {}", self.index.len())))?;
        let (entry, length) = self.head(offset)?.ok_or_else(|| self.damaged(offset))?;
        if entry.kind != kind {
            return Err(self.damaged(offset));
        }
        let mut bytes = vec![0; length];
        self.read(offset + BLOCK_HEAD as u64, &mut bytes)?;
        match entry.kind {
            Kind::Change => {
                let change = serde_json::from_slice(&bytes);
                Ok(Block::Change(change.map_err(|_| self.damaged(offset))?))
            }
            Kind::Taken => {
                let taken: Option<Taken> = serde_json::from_slice(&bytes).ok();
                let taken = taken.filter(|taken| taken.units.len() <= MOST_UNITS);
                Ok(Block::Taken(taken.ok_or_else(|| self.damaged(offset))?))
            }
            Kind::Frames => {
                let frames = frames_of(&bytes).ok_or_else(|| self.damaged(offset))?;
                Ok(Block::Frames { bytes, frames })
            }
        }
    }

    fn damaged(&self, offset: u64) -> RecordingError {
        RecordingError::field(&self.path, "block", format!("damaged at byte {offset}"), "as docs/recording.md says")
    }

    fn read(&mut self, offset: u64, into: &mut [u8]) -> Result<(), RecordingError> {
        let read = self.file.seek(SeekFrom::Start(offset)).and_then(|_| self.file.read_exact(into));
        read.map_err(|source| RecordingError::Io { path: self.path.clone(), source })
    }

    /// The head of the block at an offset and the length of its contents; `None` where none stands, or not all of it.
    fn head(&mut self, offset: u64) -> Result<Option<(Entry, usize)>, RecordingError> {
        if self.bytes.checked_sub(offset).is_none_or(|left| left < BLOCK_HEAD as u64) {
            return Ok(None);
        }
        let mut head = [0; BLOCK_HEAD];
        self.read(offset, &mut head)?;
        let mut crc = Hasher::new();
        crc.update(&head[..24]);
        let whole = head[..4] == BLOCK_MAGIC && u64::from(crc.finalize()) == u64_of(&head[24..]);
        let kind = Kind::from_id(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
        let (leaves, length) = (u64_of(&head[8..]) as i64, u64_of(&head[16..]));
        let fits = length <= (MOST_BLOCK as u64).min(self.bytes - offset - BLOCK_HEAD as u64);
        Ok(kind.filter(|_| whole && fits).map(|kind| (Entry { leaves, offset, kind }, length as usize)))
    }

    /// The index; `None` when the file does not end with one.
    fn read_index(&mut self, begins: u64) -> Result<Option<Vec<Entry>>, RecordingError> {
        let Some(at) = self.bytes.checked_sub(FOOTER as u64).filter(|at| *at >= begins) else { return Ok(None) };
        let mut footer = [0; FOOTER];
        self.read(at, &mut footer)?;
        let (offset, entries, crc) = (u64_of(&footer), u64_of(&footer[8..]), u64_of(&footer[16..]));
        let length = entries.checked_mul(ENTRY as u64).and_then(|bytes| bytes.checked_add(4));
        if footer[24..] != END_MAGIC
            || offset < begins
            || length.and_then(|bytes| offset.checked_add(bytes)) != Some(at)
        {
            return Ok(None);
        }
        // Each block has a head at least.
        if entries > (offset - begins) / BLOCK_HEAD as u64 {
            return Ok(None);
        }
        let mut index = vec![0; (at - offset) as usize];
        self.read(offset, &mut index)?;
        let mut computed = Hasher::new();
        computed.update(&index);
        computed.update(&footer[..16]);
        if index[..4] != INDEX_MAGIC || u64::from(computed.finalize()) != crc {
            return Ok(None);
        }
        let entry = |entry: &[u8]| {
            let kind = Kind::from_id(u32::try_from(u64_of(&entry[16..])).ok()?)?;
            Some(Entry { leaves: u64_of(entry) as i64, offset: u64_of(&entry[8..]), kind })
        };
        let entries: Option<Vec<Entry>> = index[4..].chunks_exact(ENTRY).map(entry).collect();
        Ok(entries
            .filter(|entries| entries.is_sorted_by_key(|entry| entry.leaves) && entries.iter().all(Entry::is_sane)))
    }

    /// The index, from the blocks themselves.
    fn scan(&mut self, begins: u64) -> Result<Vec<Entry>, RecordingError> {
        let (mut offset, mut index) = (begins, Vec::<Entry>::new());
        while let Some((entry, length)) = self.head(offset)? {
            if index.last().is_some_and(|last| last.leaves > entry.leaves) || !entry.is_sane() {
                break;
            }
            index.push(entry);
            offset += (BLOCK_HEAD + length) as u64;
        }
        Ok(index)
    }
}

impl Entry {
    /// Whether it leaves at what can be a tick, or as long before it as a frame can.
    fn is_sane(&self) -> bool {
        (-LONGEST_LEAD..=MAX_TICK).contains(&self.leaves)
    }
}

/// Where each frame of a block stands; `None` when their lengths don't add up.
fn frames_of(bytes: &[u8]) -> Option<Vec<(usize, usize)>> {
    let (mut at, mut frames) = (0, Vec::new());
    while at < bytes.len() {
        let length = bytes.get(at..at + 4)?;
        let begins = at + 4;
        let length = u32::from_le_bytes(length.try_into().ok()?) as usize;
        at = begins + length;
        // What is shorter is none, and would be many.
        frames.push(Some((begins, at)).filter(|_| length >= HEADER_BYTES)?);
    }
    (at == bytes.len()).then_some(frames)
}

fn u64_of(bytes: &[u8]) -> u64 {
    bytes[..8].iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

/// Checks what everything else is computed from.
fn check(path: &Path, preface: &Preface) -> Result<(), RecordingError> {
    let Hello { protocol, ticks_per_second, lead_ticks, .. } = &preface.hello;
    let must = |ok: bool, field, got: i64, bound: &str| {
        if ok { Ok(()) } else { Err(RecordingError::field(path, field, got, bound)) }
    };
    must(*protocol == 1, "hello.protocol", i64::from(*protocol), "1")?;
    must(*ticks_per_second == TICKS_PER_SECOND, "hello.ticks_per_second", *ticks_per_second, "7200")?;
    must((0..=LONGEST_LEAD).contains(lead_ticks), "hello.lead_ticks", *lead_ticks, "0 to 72000")?;
    let units = preface.taken.units.len();
    must(units <= MOST_UNITS, "length of taken.units", units as i64, "at most 64")
}
