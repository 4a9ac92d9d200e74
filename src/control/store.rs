//! The log's file: one embedded database, every commit on disk before it is acknowledged.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use redb::backends::InMemoryBackend;
use redb::{Builder, Database, DatabaseError, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Epoch, StoreError};
use crate::scene::{Change, Scene, SceneFile};

/// How the tables below are arranged; a file with another number is refused.
const FORMAT: u64 = 1;
const FILE: &str = "swellcast.redb";
/// The log is small and read once: the database needs no more memory than this, bytes.
const CACHE: usize = 4 << 20;

/// `format`, `epoch` and `scene`, each as JSON.
const META: TableDefinition<&str, &[u8]> = TableDefinition::new("meta");
/// Sequence to [`Change`] as JSON.
const CHANGES: TableDefinition<u64, &[u8]> = TableDefinition::new("changes");
/// Idempotency key to [`Kept`] as JSON.
const ANSWERS: TableDefinition<&str, &[u8]> = TableDefinition::new("answers");

/// The durable log. All methods block on the disk: call them off the async threads.
#[derive(Debug)]
pub struct Store {
    database: Database,
}

/// What a log holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Begun {
    /// Which timeline.
    pub epoch: Epoch,
    /// The scene it began with.
    pub scene: Scene,
    /// Every change, in order.
    pub changes: Vec<Change>,
    /// The tick that was noted last as reached: time must not go on from an earlier one.
    pub reached_tick: i64,
}

/// An idempotency key and the request it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    /// As the client sent it.
    pub id: String,
    /// The request in a form that is equal for equal requests.
    pub request: String,
}

/// What an accepted change was answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Answer {
    /// Place in the log.
    pub sequence: u64,
    /// When it acts.
    pub effective_tick: i64,
}

#[derive(Serialize, Deserialize)]
struct Kept {
    request: String,
    answer: Answer,
}

impl Store {
    /// Opens the log in a folder; both are created when absent.
    ///
    /// # Errors
    /// [`StoreError`] when the folder can't be used, another process holds it, or the file is foreign or damaged.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(FILE);
        fs::create_dir_all(folder).map_err(|source| StoreError::Io { path: folder.to_owned(), source })?;
        if !path.exists() {
            create(folder, &path)?;
        }
        let database = open(&path)?;
        let store = Self { database };
        store.check_format().map_err(|error| match error {
            StoreError::Database(error) => StoreError::Unreadable { path, detail: error.to_string() },
            error => error,
        })?;
        Ok(store)
    }

    /// A log that lasts as long as the process.
    ///
    /// # Errors
    /// None in practice; the database's own are passed on.
    pub fn in_memory() -> Result<Self, StoreError> {
        let database = Builder::new().set_cache_size(CACHE).create_with_backend(InMemoryBackend::new())?;
        write_format(&database)?;
        Ok(Self { database })
    }

    /// What the log holds, or `None` when it is new.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] when a record is missing or not as written.
    pub fn begun(&self) -> Result<Option<Begun>, StoreError> {
        let read = self.database.begin_read()?;
        let meta = read.open_table(META)?;
        let (Some(epoch), Some(scene)) = (meta.get("epoch")?, meta.get("scene")?) else { return Ok(None) };
        let file: SceneFile = parse("scene", scene.value())?;
        let scene = file.check(None).map_err(|error| StoreError::Damaged(format!("scene: {error}")))?;
        let reached_tick = meta.get("reached")?.map_or(Ok(0), |tick| parse("reached", tick.value()))?;
        let changes = changes(&read, 0, usize::MAX)?;
        let course = Change::check_course(&scene, &changes);
        course.map_err(|(sequence, error)| StoreError::Damaged(format!("entry {sequence}: {error}")))?;
        Ok(Some(Begun { epoch: parse("epoch", epoch.value())?, scene, changes, reached_tick }))
    }

    /// Begins the log with a scene; a log that has begun with the same one is given back as it stands.
    ///
    /// # Errors
    /// [`StoreError::OtherScene`] when it has begun with another.
    pub fn begin(&self, scene: &Scene, epoch: Epoch) -> Result<Begun, StoreError> {
        let asked = SceneFile::from(scene);
        if let Some(begun) = self.begun()? {
            return if SceneFile::from(&begun.scene) == asked {
                Ok(begun)
            } else {
                Err(StoreError::OtherScene { stored: begun.scene.name, asked: asked.name })
            };
        }
        let write = self.database.begin_write()?;
        {
            let mut meta = write.open_table(META)?;
            meta.insert("epoch", json(&epoch)?.as_slice())?;
            meta.insert("scene", json(&asked)?.as_slice())?;
        }
        write.commit()?;
        self.begun()?.ok_or(StoreError::NotBegun)
    }

    /// Notes that time has come to a tick, so that a calendar that is set back can't make it happen twice.
    ///
    /// # Errors
    /// The database's.
    pub fn reach(&self, tick: i64) -> Result<(), StoreError> {
        let write = self.database.begin_write()?;
        write.open_table(META)?.insert("reached", json(&tick)?.as_slice())?;
        write.commit()?;
        Ok(())
    }

    /// Appends the next change. Returns when it is on disk. A key that the log knows gives its first answer, and
    /// nothing is appended.
    ///
    /// # Errors
    /// [`StoreError::OutOfOrder`] unless `change.sequence` is the next, [`StoreError::KeyReused`],
    /// [`StoreError::NotBegun`], and the database's.
    pub fn append(&self, change: &Change, key: Option<&Key>) -> Result<Answer, StoreError> {
        let answer = Answer { sequence: change.sequence, effective_tick: change.effective_tick };
        let write = self.database.begin_write()?;
        {
            if write.open_table(META)?.get("scene")?.is_none() {
                return Err(StoreError::NotBegun);
            }
            if let Some(key) = key {
                let mut answers = write.open_table(ANSWERS)?;
                if let Some(kept) = answers.get(key.id.as_str())? {
                    return known(key, kept.value());
                }
                let kept = Kept { request: key.request.clone(), answer };
                answers.insert(key.id.as_str(), json(&kept)?.as_slice())?;
            }
            let mut changes = write.open_table(CHANGES)?;
            let next = changes.last()?.map_or(0, |(sequence, _)| sequence.value()) + 1;
            if change.sequence != next {
                return Err(StoreError::OutOfOrder { got: change.sequence, next });
            }
            changes.insert(next, json(change)?.as_slice())?;
        }
        write.commit()?;
        Ok(answer)
    }

    /// The first answer to an idempotency key.
    ///
    /// # Errors
    /// [`StoreError::KeyReused`] when the key stands for another request.
    pub fn answer(&self, key: &Key) -> Result<Option<Answer>, StoreError> {
        let read = self.database.begin_read()?;
        let answers = read.open_table(ANSWERS)?;
        answers.get(key.id.as_str())?.map(|kept| known(key, kept.value())).transpose()
    }

    /// Up to `limit` changes after sequence `after`, in order.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] for a record that can't be read.
    pub fn page(&self, after: u64, limit: usize) -> Result<Vec<Change>, StoreError> {
        changes(&self.database.begin_read()?, after, limit)
    }

    fn check_format(&self) -> Result<(), StoreError> {
        let read = self.database.begin_read()?;
        let meta = read.open_table(META)?;
        let Some(format) = meta.get("format")? else {
            return Err(StoreError::Damaged("it has no format number".to_owned()));
        };
        match parse("format", format.value())? {
            FORMAT => Ok(()),
            got => Err(StoreError::Format { got, known: FORMAT }),
        }
    }
}

/// Makes the file under another name first: a kill in the middle leaves no half-made log behind.
fn create(folder: &Path, path: &Path) -> Result<(), StoreError> {
    let draft = path.with_extension("new");
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| StoreError::Io { path, source }
    };
    match fs::remove_file(&draft) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(failed(&draft)(error)),
        _ => {}
    }
    write_format(&open(&draft)?)?;
    fs::rename(&draft, path).map_err(failed(path))?;
    // The name must outlast a power cut as well as the bytes.
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(failed(folder))
}

fn open(path: &Path) -> Result<Database, StoreError> {
    let path: PathBuf = path.to_owned();
    // Without the check, the database trusts a file that was closed cleanly and may panic on foreign bytes in it.
    let opened = Builder::new().set_cache_size(CACHE).set_check_integrity_on_open(true).create(&path);
    opened.map_err(|error| match error {
        DatabaseError::DatabaseAlreadyOpen | DatabaseError::LockProtocolMismatch => StoreError::InUse { path },
        DatabaseError::Storage(redb::StorageError::Io(source)) if source.kind() != std::io::ErrorKind::InvalidData => {
            StoreError::Io { path, source }
        }
        error => StoreError::Unreadable { path, detail: error.to_string() },
    })
}

fn write_format(database: &Database) -> Result<(), StoreError> {
    let write = database.begin_write()?;
    {
        write.open_table(META)?.insert("format", json(&FORMAT)?.as_slice())?;
        write.open_table(CHANGES)?;
        write.open_table(ANSWERS)?;
    }
    write.commit()?;
    Ok(())
}

fn changes(read: &ReadTransaction, after: u64, limit: usize) -> Result<Vec<Change>, StoreError> {
    let table = read.open_table(CHANGES)?;
    let mut changes = Vec::new();
    for (entry, expected) in table.range(after.saturating_add(1)..)?.take(limit).zip(after.saturating_add(1)..) {
        let (sequence, value) = entry?;
        let change: Change = parse("change", value.value())?;
        if sequence.value() != expected || change.sequence != expected {
            return Err(StoreError::Damaged(format!("entry {expected} is missing or misplaced")));
        }
        changes.push(change);
    }
    Ok(changes)
}

fn known(key: &Key, kept: &[u8]) -> Result<Answer, StoreError> {
    let kept: Kept = parse("answer", kept)?;
    if kept.request == key.request { Ok(kept.answer) } else { Err(StoreError::KeyReused { key: key.id.clone() }) }
}

fn json(value: &impl Serialize) -> Result<Vec<u8>, StoreError> {
    serde_json::to_vec(value).map_err(|error| StoreError::Damaged(error.to_string()))
}

fn parse<T: DeserializeOwned>(what: &str, bytes: &[u8]) -> Result<T, StoreError> {
    serde_json::from_slice(bytes).map_err(|error| StoreError::Damaged(format!("{what}: {error}")))
}
