//! What all clients of one run share: where the server is, its time, the books they write in, and the end.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicI64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::watch;

use super::churn::Turnover;
use super::figures::{Histogram, Row};
use crate::engine::Clock;

/// Most rows over time; a longer run has longer rows.
const MOST_ROWS: f64 = 600.0;

/// One run's common ground.
#[derive(Debug)]
pub struct Stage {
    /// Our clock.
    pub clock: Clock,
    /// Where to connect.
    pub address: SocketAddr,
    /// Host and path of the upgrade.
    pub host: String,
    /// Path of the upgrade.
    pub path: String,
    /// Server time less ours, microseconds.
    pub offset_us: Arc<AtomicI64>,
    /// Becomes true at the end.
    pub stop: watch::Receiver<bool>,
    /// Clients that were granted their subscription, or gave up.
    pub settled: AtomicUsize,
    /// Clients that left and were replaced.
    pub turnover: Turnover,
    /// The books.
    pub ledger: Ledger,
}

impl Stage {
    /// Server time at a time of ours.
    pub fn server_us(&self, now_us: i64) -> i64 {
        now_us + self.offset_us.load(Relaxed)
    }

    /// Counts a client that was granted its subscription, or gave up.
    pub fn settle(&self) {
        self.settled.fetch_add(1, Relaxed);
    }
}

/// Rows over time, and the ages of all that was counted in the measured window.
#[derive(Debug)]
pub struct Ledger {
    begun_us: i64,
    row_us: i64,
    /// First row of the window, and how many rows it has.
    window: AtomicI64,
    window_rows: i64,
    rows: Mutex<Vec<Row>>,
    /// Of clients that are slow, and of those that woke.
    others: Mutex<[Histogram; 2]>,
}

impl Ledger {
    /// Books from a time of ours on, with a window of `seconds` that begins later, in a run that lasts `all` seconds.
    pub fn new(begun_us: i64, seconds: f64, all: f64) -> Self {
        let row_s = (all / MOST_ROWS).ceil().max(1.0);
        Self {
            begun_us,
            row_us: (row_s * 1e6) as i64,
            window: AtomicI64::new(i64::MAX),
            window_rows: (seconds / row_s).ceil() as i64,
            rows: Mutex::default(),
            others: Mutex::default(),
        }
    }

    /// The row of a time of ours.
    pub fn row(&self, now_us: i64) -> i64 {
        (now_us - self.begun_us).max(0) / self.row_us
    }

    /// When a row begins.
    pub fn begin_us(&self, row: i64) -> i64 {
        self.begun_us + row * self.row_us
    }

    /// Length of a row, seconds.
    pub fn row_s(&self) -> f64 {
        self.row_us as f64 / 1e6
    }

    /// Opens the window at a row; its first and the one after its last.
    pub fn open_window(&self, first: i64) -> (i64, i64) {
        self.window.store(first, Relaxed);
        (first, first + self.window_rows)
    }

    /// Whether a row is in the measured window.
    pub fn measures(&self, row: i64) -> bool {
        let first = self.window.load(Relaxed);
        row >= first && row - first < self.window_rows
    }

    /// Adds what a client received in a row.
    pub fn post(&self, at: i64, part: &Row) {
        let mut rows = self.rows.lock().unwrap_or_else(PoisonError::into_inner);
        // A run that lasts longer than it was to ends in its last row.
        let at = (at as usize).min(2 * MOST_ROWS as usize);
        if rows.len() <= at {
            rows.resize_with(at + 1, Row::default);
        }
        rows[at].merge(part);
    }

    /// Adds ages of a slow client, or of one that woke.
    pub fn post_other(&self, woke: bool, ages: &Histogram) {
        self.others.lock().unwrap_or_else(PoisonError::into_inner)[usize::from(woke)].merge(ages);
    }

    /// All rows so far.
    pub fn rows(&self) -> Vec<Row> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Ages of slow clients, and of those that woke.
    pub fn others(&self) -> [Histogram; 2] {
        self.others.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
