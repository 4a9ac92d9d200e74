//! A link emulator: a TCP proxy that adds delay, jitter, a rate and stalls to each direction, and holds back its
//! sender when its buffer is full. Drops and reorders nothing: over TCP, loss shows as stalls.

use std::io;
use std::net::SocketAddr;
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use socket2::SockRef;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use tokio::task::JoinHandle;
use tokio::time::sleep;

use crate::engine::Clock;

/// Most bytes read at once: what one draw of the jitter holds for. At low rates no more than passes in 10 ms, or a packet.
const CHUNK: usize = 16 << 10;
const PACKET: usize = 1460;
/// What the systems on both sides of the link may hold besides its own buffer.
const SYSTEM_BUFFER: usize = 64 << 10;
/// A direction holds at least so much, and else what is on its way at its rate, twice.
const LEAST_BUFFER: usize = 256 << 10;
/// What a direction without a rate holds.
const UNLIMITED_BUFFER: usize = 1 << 20;

/// One direction of a link. All zero: nothing is added.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direction {
    /// What every byte waits, milliseconds.
    pub delay_ms: f64,
    /// The wait differs evenly by as much either way, milliseconds; at most the delay.
    pub jitter_ms: f64,
    /// Megabits a second; 0: as fast as it goes.
    pub rate_mbps: f64,
    /// Nothing passes for so long, milliseconds, ...
    pub stall_ms: f64,
    /// ... once in so long, milliseconds.
    pub stall_every_ms: f64,
}

/// Both directions, and the seed of what is random.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkSettings {
    /// From the client.
    pub up: Direction,
    /// To the client.
    pub down: Direction,
    /// The same seed gives the same jitter, chunk by chunk.
    pub seed: u64,
}

impl Direction {
    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let number = |text: &str| {
            let number = text.parse().ok().filter(|number: &f64| (0.0..=1e6).contains(number));
            number.ok_or_else(|| format!("{key} is {text:?}, must be a number from 0 to 1e6"))
        };
        match key {
            "delay" => self.delay_ms = number(value)?,
            "jitter" => self.jitter_ms = number(value)?,
            "rate" => self.rate_mbps = number(value)?,
            "stall" => {
                let (stall, every) = value.split_once('/').ok_or("stall must be like 100/5000, milliseconds")?;
                (self.stall_ms, self.stall_every_ms) = (number(stall)?, number(every)?);
            }
            _ => return Err(format!("{key:?} must be delay, jitter, rate, stall, or one of them after up. or down.")),
        }
        Ok(())
    }

    fn check(&self) -> Result<(), String> {
        if self.jitter_ms > self.delay_ms {
            return Err(format!("jitter is {}, must be at most the delay, {}", self.jitter_ms, self.delay_ms));
        }
        if self.stall_ms > 0.0 && self.stall_ms >= self.stall_every_ms {
            return Err(format!("stall is {}, must be below its period, {}", self.stall_ms, self.stall_every_ms));
        }
        Ok(())
    }

    fn chunk(&self) -> usize {
        if self.rate_mbps == 0.0 { CHUNK } else { ((self.rate_mbps * 1250.0) as usize).clamp(PACKET, CHUNK) }
    }

    fn buffer(&self) -> usize {
        if self.rate_mbps == 0.0 {
            return UNLIMITED_BUFFER;
        }
        let on_its_way = self.rate_mbps * 125.0 * (self.delay_ms + self.jitter_ms);
        LEAST_BUFFER.max(2 * on_its_way as usize)
    }

    /// The first moment from `us` on at which no stall is, given when the first one begins.
    fn after_stall(&self, us: i64, first_us: i64) -> i64 {
        let (stall, every) = ((self.stall_ms * 1e3) as i64, (self.stall_every_ms * 1e3) as i64);
        if stall == 0 || us < first_us {
            return us;
        }
        us + (stall - (us - first_us) % every).max(0)
    }
}

impl FromStr for LinkSettings {
    type Err = String;

    /// Reads `delay=20,jitter=10,rate=50,stall=100/5000,up.delay=5,seed=1`: milliseconds, megabits a second. A name
    /// alone means both directions, but for `rate` and `stall`, which mean down.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut settings = Self::default();
        for part in text.split(',') {
            let (key, value) = part.split_once('=').ok_or_else(|| format!("{part:?} must be like delay=20"))?;
            match key.split_once('.') {
                _ if key == "seed" => settings.seed = value.parse().map_err(|_| "seed must be a whole number")?,
                Some(("up", key)) => settings.up.set(key, value)?,
                Some(("down", key)) => settings.down.set(key, value)?,
                _ => {
                    settings.down.set(key, value)?;
                    if matches!(key, "delay" | "jitter") {
                        settings.up.set(key, value)?;
                    }
                }
            }
        }
        settings.up.check()?;
        settings.down.check()?;
        Ok(settings)
    }
}

/// A link under way, on a port of its own; it ends, with all its connections, when this is dropped.
#[derive(Debug)]
pub struct Link {
    /// Where to connect instead of the target.
    pub address: SocketAddr,
    task: JoinHandle<()>,
}

impl Link {
    /// Starts a link to a target.
    ///
    /// # Errors
    /// When nothing can be listened at.
    pub async fn start(target: SocketAddr, settings: LinkSettings, clock: Clock) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0").await?;
        SockRef::from(&listener).set_send_buffer_size(SYSTEM_BUFFER)?;
        let address = listener.local_addr()?;
        let task = tokio::spawn(async move {
            let mut connections = tokio::task::JoinSet::new();
            for number in 0.. {
                let Ok((client, _)) = listener.accept().await else {
                    sleep(Duration::from_millis(100)).await;
                    continue;
                };
                connections.spawn(carry(client, target, settings, number, clock));
                // What is over is forgotten.
                while connections.try_join_next().is_some() {}
            }
        });
        Ok(Self { address, task })
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn carry(client: TcpStream, target: SocketAddr, settings: LinkSettings, number: u64, clock: Clock) {
    let Ok(server) = connect(target).await else { return };
    let _ = client.set_nodelay(true);
    let (from_client, to_client) = client.into_split();
    let (from_server, to_server) = server.into_split();
    let seed = settings.seed.wrapping_add(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    tokio::join!(
        pass(from_client, to_server, settings.up, seed, clock),
        pass(from_server, to_client, settings.down, !seed, clock)
    );
}

async fn connect(target: SocketAddr) -> io::Result<TcpStream> {
    let socket = if target.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // What the system took in would be out of the sender's sight.
    socket.set_recv_buffer_size(SYSTEM_BUFFER as u32)?;
    let stream = socket.connect(target).await?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

/// Bytes on their way, with their room in the buffer.
type OnTheWay = (i64, Bytes, OwnedSemaphorePermit);

/// Carries one direction until its sender ends or its receiver is gone.
async fn pass(from: OwnedReadHalf, to: OwnedWriteHalf, direction: Direction, seed: u64, clock: Clock) {
    let room = Arc::new(Semaphore::new(direction.buffer()));
    let (enter, leave) = mpsc::unbounded_channel();
    let mut random = Random(seed);
    let first_stall_us = clock.now_us() + (random.next() * direction.stall_every_ms * 1e3) as i64;
    // Either ends when the other has let go of its end.
    let taking = take(from, enter, room, direction, random, clock);
    tokio::join!(taking, give(leave, &to, direction, first_stall_us, clock));
}

async fn take(
    from: OwnedReadHalf,
    enter: mpsc::UnboundedSender<OnTheWay>,
    room: Arc<Semaphore>,
    direction: Direction,
    mut random: Random,
    clock: Clock,
) {
    let mut buffer = vec![0; direction.chunk()];
    let mut last_us = i64::MIN;
    loop {
        let Ok(mut permit) = Arc::clone(&room).acquire_many_owned(buffer.len() as u32).await else { return };
        let n = loop {
            if from.readable().await.is_err() {
                return;
            }
            match from.try_read(&mut buffer) {
                Ok(0) => return,
                Ok(n) => break n,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(_) => return,
            }
        };
        let wait_ms = direction.delay_ms + direction.jitter_ms * (2.0 * random.next() - 1.0);
        // Nothing overtakes.
        last_us = last_us.max(clock.now_us() + (wait_ms * 1e3) as i64);
        // The room that it didn't need.
        drop(permit.split(buffer.len() - n));
        if enter.send((last_us, Bytes::copy_from_slice(&buffer[..n]), permit)).is_err() {
            return;
        }
    }
}

async fn give(
    mut leave: mpsc::UnboundedReceiver<OnTheWay>,
    to: &OwnedWriteHalf,
    direction: Direction,
    first_stall_us: i64,
    clock: Clock,
) {
    let mut free_us = i64::MIN;
    while let Some((due_us, mut bytes, permit)) = leave.recv().await {
        let due_us = direction.after_stall(due_us.max(free_us), first_stall_us);
        until(clock, due_us).await;
        // Stalls that began while it waited.
        until(clock, direction.after_stall(clock.now_us(), first_stall_us)).await;
        if direction.rate_mbps > 0.0 {
            free_us = due_us + (bytes.len() as f64 * 8.0 / direction.rate_mbps) as i64;
        }
        while !bytes.is_empty() {
            if to.writable().await.is_err() {
                return;
            }
            match to.try_write(&bytes) {
                Ok(n) => drop(bytes.split_to(n)),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(_) => return,
            }
        }
        drop(permit);
    }
}

async fn until(clock: Clock, us: i64) {
    let wait_us = us - clock.now_us();
    if wait_us > 0 {
        sleep(Duration::from_micros(wait_us as u64)).await;
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    /// Evenly from 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(64)
    }
}
