//! Why the log cannot be opened, read or written.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why the log refuses.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The folder or the file can't be used.
    #[error("{}: {source}", path.display())]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Another process has it open.
    #[error("{}: another server is using this folder", path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// Not a log of ours, or a damaged one.
    #[error("{}: not a Swellcast log, or damaged: {detail}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What was found.
        detail: String,
    },
    /// Written by a version that arranges it differently.
    #[error("format of the log is {got}, this version reads {known}")]
    Format {
        /// The file's number.
        got: u64,
        /// Ours.
        known: u64,
    },
    /// A record that this version did not write.
    #[error("damaged log: {0}")]
    Damaged(String),
    /// The folder holds the log of another scene.
    #[error(
        "the log holds scene {stored:?}, which differs from the scene {asked:?} that is asked for. To go on with the \
         stored one, name no scene; to start afresh, name another folder or move `swellcast.redb` away"
    )]
    OtherScene {
        /// Name of the stored scene.
        stored: String,
        /// Name of the scene asked for.
        asked: String,
    },
    /// An entry before there is a scene.
    #[error("the log has not begun: it has no scene yet")]
    NotBegun,
    /// An entry that is not the next.
    #[error("sequence is {got}, must be {next}")]
    OutOfOrder {
        /// The entry's sequence.
        got: u64,
        /// The next in the log.
        next: u64,
    },
    /// An idempotency key that stands for another request.
    #[error("idempotency key {key:?} was used for another request")]
    KeyReused {
        /// The key.
        key: String,
    },
    /// The database failed.
    #[error("log: {0}")]
    Database(Box<redb::Error>),
}

impl<E: Into<redb::Error>> From<E> for StoreError {
    fn from(error: E) -> Self {
        Self::Database(Box::new(error.into()))
    }
}
