//! What is known of the server from beside the crowd: its time, kept by one connection, and its figures from `/metrics`.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicI64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use serde::Serialize;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::buckets::Buckets;
use crate::client::{Connection, Event, exchange};
use crate::engine::Clock;
use crate::wire::Hello;

/// How long the server's first messages may take.
const PATIENCE: Duration = Duration::from_secs(5);
/// After so long the clock has its first good exchanges.
const SETTLING: Duration = Duration::from_millis(2500);

/// The connection that keeps the shared clock.
#[derive(Debug)]
pub struct Timekeeper {
    /// Server time less ours, microseconds.
    pub offset_us: Arc<AtomicI64>,
    /// How far that can be off, microseconds.
    bound_us: Arc<AtomicI64>,
    /// The server's first message.
    pub hello: Hello,
    closed: Arc<Mutex<Option<String>>>,
    task: JoinHandle<()>,
}

impl Timekeeper {
    /// Connects, and waits until the clock has settled.
    ///
    /// # Errors
    /// When there is no connection, or the server says nothing.
    pub async fn start(url: &str, clock: Clock) -> Result<Self> {
        let mut connection = Connection::open(url, move || clock.now_us()).await?;
        let hello = loop {
            match timeout(PATIENCE, connection.next()).await.context("the server says nothing for 5 s")? {
                Event::Hello(hello) => break *hello,
                Event::Closed(closed) => bail!("{closed}"),
                _ => {}
            }
        };
        let (offset_us, bound_us) = (Arc::new(AtomicI64::new(0)), Arc::new(AtomicI64::new(i64::MAX)));
        let closed = Arc::new(Mutex::new(None));
        let task = {
            let (offset_us, bound_us, closed) = (Arc::clone(&offset_us), Arc::clone(&bound_us), Arc::clone(&closed));
            tokio::spawn(async move {
                loop {
                    // The server says how it is each second.
                    let event = connection.next().await;
                    let now_us = clock.now_us();
                    if let Some(server_us) = connection.clock().server_us(now_us) {
                        offset_us.store(server_us - now_us, Relaxed);
                    }
                    if let Some(bound) = connection.error_bound_us() {
                        bound_us.store(bound, Relaxed);
                    }
                    if let Event::Closed(why) = event {
                        *closed.lock().unwrap_or_else(PoisonError::into_inner) = Some(why.to_string());
                        return;
                    }
                }
            })
        };
        let keeper = Self { offset_us, bound_us, hello, closed, task };
        tokio::time::sleep(SETTLING).await;
        match keeper.closed() {
            Some(why) => bail!(why),
            None => Ok(keeper),
        }
    }

    /// How far the shared clock can be off, milliseconds.
    pub fn error_bound_ms(&self) -> Option<f64> {
        Some(self.bound_us.load(Relaxed)).filter(|us| *us < i64::MAX).map(|us| us as f64 / 1e3)
    }

    /// Why the server ended this connection, if it did.
    pub fn closed(&self) -> Option<String> {
        self.closed.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Drop for Timekeeper {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Figures of a server at one moment; what it doesn't say is absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Seconds of processor since it began.
    pub cpu_seconds: Option<f64>,
    /// Memory in use, bytes.
    pub resident_bytes: Option<f64>,
    /// Stream clients.
    pub clients: Option<f64>,
    /// Bytes of frames handed to sockets since it began.
    pub sent_bytes: Option<f64>,
    /// Times that a client was moved to the newest frames.
    pub jumps: Option<f64>,
    /// Ticks that it made.
    pub steps: Option<f64>,
    /// Ticks that it passed over, too slow.
    pub skipped: Option<f64>,
    /// From frames that are ready to their last byte with the system.
    pub sending: Buckets,
}

/// A server whose figures are read from its `/metrics`.
#[derive(Clone, Debug)]
pub struct Watched {
    /// Where it is.
    pub address: SocketAddr,
    /// What it is called.
    pub host: String,
}

impl Watched {
    /// Its figures now; all absent when it doesn't answer.
    pub async fn figures(&self) -> Figures {
        let page = exchange(self.address, &self.host, "GET", "/metrics", "").await;
        page.map(|(_, page)| Figures::parse(&page)).unwrap_or_default()
    }
}

impl Figures {
    /// Reads a page in Prometheus' text form.
    pub fn parse(page: &str) -> Self {
        let value = |name: &str| {
            let line = page.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))?;
            line.trim().parse().ok()
        };
        Self {
            cpu_seconds: value("process_cpu_seconds_total"),
            resident_bytes: value("process_resident_memory_bytes"),
            clients: value("swellcast_clients"),
            sent_bytes: value("swellcast_frame_bytes_sent_total"),
            jumps: value("swellcast_client_jumps_total"),
            steps: value("swellcast_steps_total"),
            skipped: value("swellcast_frames_skipped_total"),
            sending: Buckets::parse(page, "swellcast_sending_seconds"),
        }
    }
}
