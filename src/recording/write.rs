//! Writes a recording: block by block as frames come, and the index at the end.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crc32fast::Hasher;

use super::{
    BLOCK_MAGIC, END_MAGIC, Entry, INDEX_MAGIC, Kind, MAGIC, MOST_BLOCK, MOST_PREFACE, Preface, RecordingError, Taken,
};
use crate::wire::WireChange;

/// A recording under way. One that is not finished can be read all the same, up to its last whole block.
#[derive(Debug)]
pub struct RecordingWriter {
    path: PathBuf,
    file: BufWriter<File>,
    offset: u64,
    index: Vec<Entry>,
    /// Frames that leave together, each after its length.
    block: Vec<u8>,
    leaves: i64,
}

impl RecordingWriter {
    /// Begins a file; one of this name that is there already is an error.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn create(path: &Path, preface: &Preface) -> Result<Self, RecordingError> {
        let file = File::create_new(path).map_err(|source| RecordingError::Io { path: path.to_owned(), source })?;
        let file = BufWriter::new(file);
        // What comes before the first frames leaves as soon as there is somebody.
        let leaves = preface.hello.tick;
        let mut writer = Self { path: path.to_owned(), file, offset: 0, index: Vec::new(), block: Vec::new(), leaves };
        let preface = serde_json::to_vec(preface).expect("plain data serialises");
        if preface.len() > MOST_PREFACE {
            let bound = format!("at most {MOST_PREFACE}");
            return Err(RecordingError::field(path, "length of the preface", preface.len(), bound));
        }
        writer.put(&MAGIC)?;
        writer.put(&(preface.len() as u64).to_le_bytes())?;
        writer.put(&preface)?;
        Ok(writer)
    }

    /// Adds a frame that is due to leave at a tick. Frames come in the order in which they left.
    ///
    /// # Errors
    /// [`RecordingError::Io`].
    pub fn frame(&mut self, leaves: i64, frame: &[u8]) -> Result<(), RecordingError> {
        if leaves > self.leaves || self.block.len() + 4 + frame.len() > MOST_BLOCK {
            self.end_block()?;
            self.leaves = self.leaves.max(leaves);
        }
        self.block.extend((frame.len() as u32).to_le_bytes());
        self.block.extend(frame);
        Ok(())
    }

    /// Adds a change that was announced now.
    ///
    /// # Errors
    /// [`RecordingError::Io`].
    pub fn change(&mut self, change: &WireChange) -> Result<(), RecordingError> {
        self.end_block()?;
        let text = serde_json::to_vec(change).expect("plain data serialises");
        self.put_block(Kind::Change, &text)
    }

    /// From now on these units are recorded.
    ///
    /// # Errors
    /// [`RecordingError::Io`].
    pub fn taken(&mut self, taken: &Taken) -> Result<(), RecordingError> {
        self.end_block()?;
        let text = serde_json::to_vec(taken).expect("plain data serialises");
        self.put_block(Kind::Taken, &text)
    }

    /// Bytes so far.
    pub fn bytes(&self) -> u64 {
        self.offset + self.block.len() as u64
    }

    /// Writes the index. The file is whole and on the disk when this returns.
    ///
    /// # Errors
    /// [`RecordingError::Io`].
    pub fn finish(mut self) -> Result<u64, RecordingError> {
        self.end_block()?;
        let (begins, entries) = (self.offset, self.index.len() as u64);
        let mut index = INDEX_MAGIC.to_vec();
        for Entry { leaves, offset, kind } in &self.index {
            index.extend(leaves.to_le_bytes());
            index.extend(offset.to_le_bytes());
            index.extend(u64::from(kind.id()).to_le_bytes());
        }
        index.extend(begins.to_le_bytes());
        index.extend(entries.to_le_bytes());
        let mut crc = Hasher::new();
        crc.update(&index);
        index.extend(u64::from(crc.finalize()).to_le_bytes());
        index.extend(END_MAGIC);
        self.put(&index)?;
        let Self { path, file, offset, .. } = self;
        let synced = file.into_inner().map_err(std::io::IntoInnerError::into_error).and_then(|file| file.sync_all());
        synced.map_err(|source| RecordingError::Io { path, source })?;
        Ok(offset)
    }

    fn end_block(&mut self) -> Result<(), RecordingError> {
        if self.block.is_empty() {
            return Ok(());
        }
        let block = std::mem::take(&mut self.block);
        self.put_block(Kind::Frames, &block)?;
        self.block = block;
        self.block.clear();
        Ok(())
    }

    fn put_block(&mut self, kind: Kind, contents: &[u8]) -> Result<(), RecordingError> {
        self.index.push(Entry { leaves: self.leaves, offset: self.offset, kind });
        let mut head = BLOCK_MAGIC.to_vec();
        head.extend(kind.id().to_le_bytes());
        head.extend(self.leaves.to_le_bytes());
        head.extend((contents.len() as u64).to_le_bytes());
        let mut crc = Hasher::new();
        crc.update(&head);
        head.extend(u64::from(crc.finalize()).to_le_bytes());
        self.put(&head)?;
        self.put(contents)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), RecordingError> {
        let written = self.file.write_all(bytes);
        self.offset += bytes.len() as u64;
        written.map_err(|source| RecordingError::Io { path: self.path.clone(), source })
    }
}
