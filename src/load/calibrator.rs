//! The raw-socket calibrator, a process of its own: sends messages that are as many, as long and as often as the
//! server's to as many connections, with nothing in between. What it costs is what no server can do without.

use std::io::{self, Write};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result};
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use socket2::SockRef;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

use super::reader::Head;
use crate::engine::Clock;
use crate::server::{Latency, Usage};
use crate::wire::{
    ClientMessage, HEADER_BYTES, Hello, MAX_MESSAGE_BYTES, SUBPROTOCOL, ServerMessage, Subscribe, Subscribed,
    TICKS_PER_SECOND,
};

/// As the server's listener has it.
#[cfg(target_os = "linux")]
const NOT_SENT: u32 = 128 << 10;

/// What to send. Read from standard input.
#[derive(Debug, Serialize, Deserialize)]
pub struct Job {
    /// When server time began, nanoseconds since 1970.
    pub zero_unix_ns: i64,
    /// What each client is told first.
    pub hello: Hello,
    /// Frames to make.
    pub tiles: Vec<JobTile>,
}

/// Frames of one tile.
#[derive(Debug, Serialize, Deserialize)]
pub struct JobTile {
    /// A header like theirs.
    pub head: Vec<u8>,
    /// Ticks between two.
    pub interval: i64,
    /// Length of each, bytes.
    pub bytes: usize,
}

/// All messages of one tick, by cascade, level, class and group.
#[derive(Debug, Default)]
struct Round {
    tick: i64,
    /// When they were ready.
    ready_us: i64,
    messages: Vec<([u8; 4], Bytes)>,
}

/// What all connections share.
struct Ground {
    job: Job,
    clock: Clock,
    /// From a round that is ready to its last byte with the system, as the server counts it.
    sending: Latency,
}

/// Listens, prints its address, and sends until standard input ends.
///
/// # Errors
/// When the job can't be read, or nothing can be listened at.
pub async fn calibrator() -> Result<()> {
    let mut text = String::new();
    io::stdin().read_line(&mut text)?;
    let job: Job = serde_json::from_str(&text).context("reading the job")?;
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    // Accepted connections inherit both, as the server's do.
    let options = SockRef::from(&listener);
    options.set_tcp_nodelay(true)?;
    #[cfg(target_os = "linux")]
    options.set_tcp_notsent_lowat(NOT_SENT)?;
    writeln!(io::stdout(), "{}", listener.local_addr()?)?;
    let (rounds, watched) = watch::channel(Arc::new(Round::default()));
    let clock = Clock::start(job.zero_unix_ns);
    let ground = Arc::new(Ground { job, clock, sending: Latency::default() });
    tokio::select! {
        () = pace(&ground, &rounds) => {}
        () = accept(&listener, &ground, &watched) => {}
        // Whoever started it holds the other end for as long as it is needed.
        _ = tokio::task::spawn_blocking(|| io::stdin().read_line(&mut String::new())) => {}
    }
    Ok(())
}

/// Makes the messages of every tick when they are due.
async fn pace(ground: &Ground, rounds: &watch::Sender<Arc<Round>>) {
    let Ground { job, clock, .. } = ground;
    let Some(step) = job.tiles.iter().map(|tile| tile.interval).min() else { return std::future::pending().await };
    let mut tick = (clock.now_tick() / step + 1) * step;
    loop {
        // A tick for which it is late is left out, as the server does.
        tick = (tick + step).max((clock.now_tick() + job.hello.lead_ticks) / step * step);
        tokio::time::sleep(clock.until(tick - job.hello.lead_ticks)).await;
        let due = job.tiles.iter().filter(|tile| tick % tile.interval == 0);
        let messages = due.filter_map(|tile| message(tile, tick)).collect();
        rounds.send_replace(Arc::new(Round { tick, ready_us: clock.now_us(), messages }));
    }
}

/// A frame with the WebSocket's own head before it: encoded once.
fn message(tile: &JobTile, tick: i64) -> Option<([u8; 4], Bytes)> {
    let head = Head(tile.head.as_slice().try_into().ok()?);
    let length = tile.bytes.max(HEADER_BYTES);
    let mut bytes = vec![130];
    match length {
        n @ 0..126 => bytes.push(n as u8),
        n if n <= 0xffff => {
            bytes.push(126);
            bytes.extend_from_slice(&(n as u16).to_be_bytes());
        }
        n => {
            bytes.push(127);
            bytes.extend_from_slice(&(n as u64).to_be_bytes());
        }
    }
    let begin = bytes.len();
    bytes.resize(begin + length, tick as u8);
    head.seal(tick as u64, &mut bytes[begin..]);
    Some((head.unit(), bytes.into()))
}

async fn accept(listener: &TcpListener, ground: &Arc<Ground>, rounds: &watch::Receiver<Arc<Round>>) {
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                let (ground, rounds) = (Arc::clone(ground), rounds.clone());
                // A client that leaves ends its own task.
                tokio::spawn(async move { send(&stream, &ground, rounds).await });
            }
            Err(_) => tokio::time::sleep(Duration::from_millis(100)).await,
        }
    }
}

async fn send(stream: &TcpStream, ground: &Ground, mut rounds: watch::Receiver<Arc<Round>>) -> io::Result<()> {
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        // By single bytes, so that nothing behind it is taken.
        read(stream, &mut head, 1).await?;
    }
    if head.starts_with(b"GET /metrics ") {
        return write(stream, figures(ground).as_bytes()).await;
    }
    let upgrade = format!(
        "HTTP/1.1 101 Switching Protocols\r\nconnection: upgrade\r\nupgrade: websocket\r\n\
         sec-websocket-protocol: {SUBPROTOCOL}\r\n\r\n"
    );
    write(stream, upgrade.as_bytes()).await?;
    write(stream, &text(&ServerMessage::Hello(Box::new(ground.job.hello.clone())))).await?;
    let Some(Subscribe { id, rate_hz, units, .. }) = request(stream).await? else { return Ok(()) };
    let from_tick = rounds.borrow_and_update().tick;
    let mut wanted: Vec<_> = units.iter().map(|wanted| (key(wanted.unit), wanted.rate_hz.unwrap_or(rate_hz))).collect();
    wanted.sort_unstable();
    write(stream, &text(&ServerMessage::Subscribed(Subscribed { id, rate_hz, units, from_tick }))).await?;
    let mut waste = [0; 1024];
    loop {
        tokio::select! {
            changed = rounds.changed() => {
                if changed.is_err() {
                    return Ok(());
                }
                let round = Arc::clone(&rounds.borrow_and_update());
                for (unit, bytes) in &round.messages {
                    let rate = wanted.binary_search_by_key(unit, |wanted| wanted.0).map(|at| wanted[at].1);
                    if rate.is_ok_and(|rate| round.tick % (TICKS_PER_SECOND / i64::from(rate.max(1))) == 0) {
                        write(stream, bytes).await?;
                    }
                }
                ground.sending.observe(ground.clock.now_us() - round.ready_us);
            }
            ready = stream.readable() => {
                ready?;
                match stream.try_read(&mut waste) {
                    Ok(0) => return Ok(()),
                    Err(error) if error.kind() != io::ErrorKind::WouldBlock => return Err(error),
                    _ => {}
                }
            }
        }
    }
}

/// What the server says of itself in `/metrics`, as far as there is the same here.
fn figures(ground: &Ground) -> String {
    let mut page = String::from("HTTP/1.1 200 OK\r\nconnection: close\r\n\r\n");
    if let Some(Usage { cpu_seconds, resident_bytes }) = Usage::own() {
        page += &format!("process_cpu_seconds_total {cpu_seconds}\nprocess_resident_memory_bytes {resident_bytes}\n");
    }
    ground.sending.write("swellcast_sending_seconds", "As the server's.", &mut page);
    page
}

fn key(unit: crate::wire::UnitName) -> [u8; 4] {
    [unit.cascade, unit.level, unit.class.id(), unit.group.id()]
}

/// The client's subscription: its first message.
async fn request(stream: &TcpStream) -> io::Result<Option<Subscribe>> {
    let mut bytes = Vec::new();
    read(stream, &mut bytes, 2).await?;
    let length = match bytes[1] & 127 {
        126 => {
            read(stream, &mut bytes, 2).await?;
            usize::from(u16::from_be_bytes([bytes[2], bytes[3]]))
        }
        127 => return Ok(None),
        short => usize::from(short),
    };
    let mut payload = Vec::new();
    // Our own clients' masks are zeros.
    read(stream, &mut payload, 4).await?;
    payload.clear();
    read(stream, &mut payload, length.min(MAX_MESSAGE_BYTES)).await?;
    let parsed = std::str::from_utf8(&payload).ok().and_then(|text| ClientMessage::parse(text).ok());
    Ok(parsed
        .and_then(|message| if let ClientMessage::Subscribe(subscribe) = message { Some(subscribe) } else { None }))
}

/// Reads `n` more bytes.
async fn read(stream: &TcpStream, into: &mut Vec<u8>, n: usize) -> io::Result<()> {
    let end = into.len() + n;
    while into.len() < end {
        stream.readable().await?;
        let mut part = vec![0; end - into.len()];
        match stream.try_read(&mut part) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(n) => into.extend_from_slice(&part[..n]),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

async fn write(stream: &TcpStream, mut bytes: &[u8]) -> io::Result<()> {
    while !bytes.is_empty() {
        match stream.try_write(bytes) {
            Ok(n) => bytes = &bytes[n..],
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => stream.writable().await?,
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// A server's text as bytes of a WebSocket.
fn text(message: &ServerMessage) -> Vec<u8> {
    let text = message.to_json();
    let mut bytes = vec![129];
    if text.len() < 126 {
        bytes.push(text.len() as u8);
    } else {
        bytes.push(127);
        bytes.extend_from_slice(&(text.len() as u64).to_be_bytes());
    }
    bytes.extend_from_slice(text.as_bytes());
    bytes
}
