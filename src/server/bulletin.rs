//! What every client is told: changes, in order and none left out, with a new `hello` where the layout is new, and the
//! newest status. One text for all.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use tokio::sync::watch;
use tokio_websockets::Message;

use crate::wire::{Hello, ServerMessage, Status, WireChange};

/// Changes kept for clients that have not read them yet; one that is further behind is closed.
const KEPT: usize = 256;

/// The board that all sessions read, and the pulse that wakes them.
#[derive(Debug)]
pub struct Bulletin {
    held: Mutex<Held>,
    /// Counts postings, so that a session looks only when there is something.
    version: AtomicU64,
    beat: AtomicU64,
    /// Sessions were woken since the last beat.
    woken: AtomicBool,
    pulse: watch::Sender<()>,
    closing: watch::Sender<bool>,
}

#[derive(Debug, Default)]
struct Held {
    changes: VecDeque<Posted>,
    /// The newest status, and how many there were.
    status: Option<Message>,
    statuses: u64,
}

#[derive(Clone, Debug)]
struct Posted {
    sequence: u64,
    change: Message,
    /// The hello that follows a change of layout, and its generation.
    hello: Option<(Message, u32)>,
}

/// Where a session stands.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reader {
    seen: u64,
    /// Newest change known to the client.
    sequence: u64,
    statuses: u64,
}

/// What is new to a session.
#[derive(Debug, Default)]
pub struct News {
    /// Changes in order, and hellos among them.
    pub changes: Vec<Message>,
    /// Generations of the layouts that the hellos tell of.
    pub layouts: Vec<u32>,
    /// The newest status, when it was not read before.
    pub status: Option<Message>,
    /// Changes were missed: the session can't go on.
    pub missed: bool,
}

impl Bulletin {
    /// An empty board.
    pub fn new() -> Self {
        Self {
            held: Mutex::default(),
            version: AtomicU64::new(0),
            beat: AtomicU64::new(0),
            woken: AtomicBool::new(false),
            pulse: watch::Sender::new(()),
            closing: watch::Sender::new(false),
        }
    }

    /// Wakes every session. Called on the engine's thread, too: does nothing but wake.
    pub fn wake(&self) {
        self.woken.store(true, Relaxed);
        self.pulse.send_replace(());
    }

    /// Changes whenever a session has something to do.
    pub fn pulse(&self) -> watch::Receiver<()> {
        self.pulse.subscribe()
    }

    /// Posts a change, and the hello that follows a change of layout.
    pub fn post_change(&self, change: WireChange, hello: Option<Hello>) {
        let sequence = change.sequence;
        let text = |message: ServerMessage| Message::text(message.to_json());
        let hello = hello.map(|hello| {
            let generation = hello.layout.generation;
            (text(ServerMessage::Hello(Box::new(hello))), generation)
        });
        let posted = Posted { sequence, change: text(ServerMessage::Change(change)), hello };
        self.post(|held| {
            held.changes.push_back(posted);
            if held.changes.len() > KEPT {
                held.changes.pop_front();
            }
        });
        self.wake();
    }

    /// Posts the status; the one before it is worthless. Wakes nobody: it goes with what is due next, or with the beat.
    pub fn post_status(&self, status: Status) {
        let text = Message::text(ServerMessage::Status(status).to_json());
        self.post(|held| {
            held.status = Some(text);
            held.statuses += 1;
        });
    }

    /// Counts a second: by it sessions measure silence. Wakes them unless something else has: while frames leave, waking
    /// a thousand sessions once more costs as much as a frame.
    pub fn beat(&self) {
        self.beat.fetch_add(1, Relaxed);
        if !self.woken.load(Relaxed) {
            self.wake();
        }
        self.woken.store(false, Relaxed);
    }

    /// Seconds counted so far.
    pub fn beats(&self) -> u64 {
        self.beat.load(Relaxed)
    }

    /// Tells every session that the server shuts down.
    pub fn close(&self) {
        self.closing.send_replace(true);
        self.wake();
    }

    /// Whether the server shuts down; true once and for ever.
    pub fn closing(&self) -> watch::Receiver<bool> {
        self.closing.subscribe()
    }

    /// A reader for a client that was told of changes up to `sequence`.
    pub fn reader(&self, sequence: u64) -> Reader {
        Reader { seen: 0, sequence, statuses: 0 }
    }

    /// What is new, or `None`.
    pub fn news(&self, reader: &mut Reader) -> Option<News> {
        let version = self.version.load(Relaxed);
        if version == reader.seen {
            return None;
        }
        let held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        let unread = held.changes.iter().filter(|posted| posted.sequence > reader.sequence);
        let first = unread.clone().next().map_or(reader.sequence + 1, |posted| posted.sequence);
        let (mut changes, mut layouts) = (Vec::new(), Vec::new());
        for posted in unread {
            changes.push(posted.change.clone());
            if let Some((hello, generation)) = &posted.hello {
                changes.push(hello.clone());
                layouts.push(*generation);
            }
        }
        let news = News {
            changes,
            layouts,
            status: held.status.clone().filter(|_| held.statuses != reader.statuses),
            missed: first != reader.sequence + 1,
        };
        let newest = held.changes.back().map_or(0, |posted| posted.sequence);
        *reader = Reader { seen: version, sequence: reader.sequence.max(newest), statuses: held.statuses };
        Some(news)
    }

    fn post(&self, change: impl FnOnce(&mut Held)) {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut held);
        self.version.fetch_add(1, Relaxed);
    }
}
