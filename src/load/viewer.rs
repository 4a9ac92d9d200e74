//! One client of the crowd: connects, subscribes, keeps asking for the time, and judges every frame by its header and
//! checksum. It holds no frame, unless it is one of those that decode.

use std::cell::RefCell;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::{TcpSocket, TcpStream};
use tokio::sync::mpsc::Receiver;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use super::reader::{Message, StreamReader, client_frame, client_text};
use super::sight::{Outcome, Sight};
use super::stage::Stage;
use crate::client::Choice;
use crate::wire::SUBPROTOCOL;

/// Bytes read at once, into one buffer a thread.
const CHUNK: usize = 256 << 10;
/// Bytes read from one client before the others have their turn.
const TURN: usize = 1 << 20;
/// What a slow client reads at once, and what its system may hold for it.
const SIP: usize = 16 << 10;
/// Largest answer to the upgrade.
const MOST_ANSWER: usize = 64 << 10;
/// How long connecting and the upgrade may take together.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long the server may take to answer a close, microseconds.
const FAREWELL_US: i64 = 5_000_000;
/// A client asks for the time this often, as a real one does.
const BEAT: Duration = Duration::from_secs(1);
/// A client that never wakes comes back after this long, since the server has let it go by then, microseconds.
const GIVEN_UP_US: i64 = 15_000_000;

thread_local! {
    static BUFFER: RefCell<Vec<u8>> = RefCell::new(vec![0; CHUNK]);
}

/// How a client behaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Manner {
    /// Reads whatever comes at once.
    Steady,
    /// Reads so many bytes a second.
    Slow(f64),
    /// Subscribes and reads nothing; after so many microseconds, if any, it reads on.
    Stalled(Option<i64>),
}

/// A client to be.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How it behaves.
    pub manner: Manner,
    /// What it asks for.
    pub choice: Choice,
    /// It keeps whole frames and decodes them.
    pub decodes: bool,
    /// It notes what frames of each tile look like, for the calibrator.
    pub notes: bool,
}

/// Why a connection was left.
enum Left {
    /// The load is over.
    Over,
    /// To come back: a stalled client that was given up.
    Again,
    /// To be replaced: it was told to leave, and did.
    Replaced,
    Ended(String),
}

/// Watches until the load is over or the connection ends. At each of its `turns` it leaves, and another with the same
/// plan comes in its place.
pub async fn view(plan: Plan, stage: Arc<Stage>, mut turns: Receiver<()>) -> Outcome {
    let mut sight = Sight::new(plan, Arc::clone(&stage));
    loop {
        match one(&mut sight, &stage, &mut turns).await {
            Left::Again => sight.connect_anew(),
            Left::Replaced => sight.give_place(),
            Left::Over => return sight.finish(None),
            Left::Ended(why) => return sight.finish(Some(why)),
        }
    }
}

async fn one(sight: &mut Sight, stage: &Stage, turns: &mut Receiver<()>) -> Left {
    let opened = timeout(PATIENCE, open(stage, sight.plan().manner)).await;
    match opened.unwrap_or_else(|_| Err("connecting takes more than 10 s".to_owned())) {
        Ok((stream, unread)) => Viewer::new(sight, stream).watch(stage, turns, &unread).await,
        Err(why) => Left::Ended(why),
    }
}

/// A connection after the upgrade, and what came behind the answer.
async fn open(stage: &Stage, manner: Manner) -> Result<(TcpStream, Vec<u8>), String> {
    let said = |error: io::Error| error.to_string();
    let socket = if stage.address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }.map_err(said)?;
    if let Manner::Slow(_) = manner {
        socket.set_recv_buffer_size(4 * SIP as u32).map_err(said)?;
    }
    let stream = socket.connect(stage.address).await.map_err(said)?;
    stream.set_nodelay(true).map_err(said)?;
    let request = format!(
        "GET {} HTTP/1.1\r\nhost: {}\r\nconnection: Upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\n\
         sec-websocket-key: c3dlbGxjYXN0IGxvYWQhIQ==\r\nsec-websocket-protocol: {SUBPROTOCOL}\r\n\r\n",
        stage.path, stage.host
    );
    let (mut sent, mut answer) = (0, Vec::new());
    while sent < request.len() {
        stream.writable().await.map_err(said)?;
        sent += unless_blocked(stream.try_write(&request.as_bytes()[sent..])).map_err(said)?.unwrap_or(0);
    }
    let mut buffer = [0; 2048];
    loop {
        stream.readable().await.map_err(said)?;
        match unless_blocked(stream.try_read(&mut buffer)).map_err(said)? {
            Some(0) => return Err("the server closed instead of upgrading".to_owned()),
            Some(n) => answer.extend_from_slice(&buffer[..n]),
            None => continue,
        }
        if let Some(end) = answer.windows(4).position(|window| window == b"\r\n\r\n") {
            let unread = answer.split_off(end + 4);
            let answer = String::from_utf8_lossy(&answer);
            let status = answer.split(' ').nth(1).unwrap_or_default();
            return if status == "101" { Ok((stream, unread)) } else { Err(format!("the server answers {status}")) };
        }
        if answer.len() > MOST_ANSWER {
            return Err("the answer to the upgrade has no end".to_owned());
        }
    }
}

fn unless_blocked(result: io::Result<usize>) -> io::Result<Option<usize>> {
    match result {
        Ok(n) => Ok(Some(n)),
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
        Err(error) => Err(error),
    }
}

/// Waits until a time of ours.
async fn until_us(stage: &Stage, us: i64) {
    sleep(Duration::from_micros((us - stage.clock.now_us()).max(0) as u64)).await;
}

struct Viewer<'a> {
    sight: &'a mut Sight,
    stream: TcpStream,
    reader: StreamReader,
    /// Messages that wait for the socket.
    out: Vec<u8>,
    /// Nothing is read before this time of ours.
    read_from_us: i64,
    /// It has closed; the server's answer to that must come by this time of ours.
    leaves_by_us: Option<i64>,
    /// That answer came.
    answered: bool,
}

impl<'a> Viewer<'a> {
    fn new(sight: &'a mut Sight, stream: TcpStream) -> Self {
        let reader = StreamReader::new(sight.plan().decodes);
        Self { sight, stream, reader, out: Vec::new(), read_from_us: 0, leaves_by_us: None, answered: false }
    }

    async fn watch(&mut self, stage: &Stage, turns: &mut Receiver<()>, unread: &[u8]) -> Left {
        let mut stop = stage.stop.clone();
        let mut beat = interval(BEAT);
        beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        if let Err(why) = self.take(unread, stage.clock.now_us()) {
            return Left::Ended(why);
        }
        loop {
            if let Err(why) = self.write() {
                return Left::Ended(why);
            }
            let asleep = self.read_from_us > stage.clock.now_us();
            let stalled = asleep && matches!(self.sight.plan().manner, Manner::Stalled(_));
            tokio::select! {
                biased;
                // An error: whoever could stop us is gone.
                _ = stop.wait_for(|stop| *stop) => break,
                () = until_us(stage, self.read_from_us), if asleep => {
                    if stalled && !self.wake(stage.clock.now_us()) {
                        return Left::Again;
                    }
                }
                // What is on its way to it until the server answers counts as ever. The others' channels are closed.
                Some(()) = turns.recv(), if self.sight.is_granted() && self.leaves_by_us.is_none() => {
                    self.out.extend(client_frame(8, &1000u16.to_be_bytes()));
                    self.leaves_by_us = Some(stage.clock.now_us() + FAREWELL_US);
                }
                () = until_us(stage, self.leaves_by_us.unwrap_or_default()), if self.leaves_by_us.is_some() => {
                    return Left::Ended("the server doesn't answer a close for 5 s".to_owned());
                }
                _ = beat.tick(), if !stalled && self.leaves_by_us.is_none() => {
                    if let Some(request) = self.sight.ask_time(stage.clock.now_us()) {
                        self.out.extend(client_text(&request));
                    }
                }
                ready = self.stream.readable(), if !asleep => {
                    if let Err(why) = ready.map_err(|e| e.to_string()).and_then(|()| self.read(stage)) {
                        return if self.answered { Left::Replaced } else { Left::Ended(why) };
                    }
                }
                _ = self.stream.writable(), if !self.out.is_empty() => {}
            }
        }
        // Going away; nobody waits for the answer.
        self.out.extend(client_frame(8, &1001u16.to_be_bytes()));
        let _ = self.write();
        Left::Over
    }

    /// The end of a stall; whether to read on.
    fn wake(&mut self, now_us: i64) -> bool {
        let wakes = matches!(self.sight.plan().manner, Manner::Stalled(Some(_)));
        if wakes {
            self.sight.wake(now_us);
        }
        wakes
    }

    fn read(&mut self, stage: &Stage) -> Result<(), String> {
        BUFFER.with_borrow_mut(|buffer| {
            let slow = matches!(self.sight.plan().manner, Manner::Slow(_));
            let most = if slow { SIP } else { buffer.len() };
            let mut turn = 0;
            while turn < TURN && self.read_from_us <= stage.clock.now_us() {
                let Some(n) = unless_blocked(self.stream.try_read(&mut buffer[..most])).map_err(|e| e.to_string())?
                else {
                    break;
                };
                if n == 0 {
                    return Err("the connection ended without a close".to_owned());
                }
                turn += n;
                let now_us = stage.clock.now_us();
                self.take(&buffer[..n], now_us)?;
                if let Manner::Slow(bytes_per_second) = self.sight.plan().manner {
                    let due = self.read_from_us.max(now_us - 100_000);
                    self.read_from_us = due + (n as f64 * 1e6 / bytes_per_second) as i64;
                }
            }
            Ok(())
        })
    }

    fn take(&mut self, bytes: &[u8], now_us: i64) -> Result<(), String> {
        let (sight, out, read_from_us) = (&mut *self.sight, &mut self.out, &mut self.read_from_us);
        let (leaves, answered) = (self.leaves_by_us.is_some(), &mut self.answered);
        let mut ended = Ok(());
        let read = self.reader.feed(bytes, |message| match message {
            Message::Text(text) => match sight.text(text, now_us) {
                Ok(Some(answer)) => out.extend(client_text(&answer)),
                Ok(None) => {}
                Err(why) => ended = Err(why),
            },
            Message::Frame(head, bytes, whole) => sight.frame(&head, bytes, whole, now_us),
            Message::Bad(bad) => sight.bad(bad),
            // Behind a close nothing may be said.
            Message::Ping(_) if leaves => {}
            Message::Ping(data) => out.extend(client_frame(10, data)),
            Message::Close(code) => (*answered, ended) = (leaves, Err(format!("the server closed with {code}"))),
        });
        if let Manner::Stalled(wakes) = sight.plan().manner
            && sight.begins_to_stall()
        {
            *read_from_us = now_us + wakes.unwrap_or(GIVEN_UP_US);
        }
        ended?;
        read.map_err(|e| e.to_string())
    }

    fn write(&mut self) -> Result<(), String> {
        while !self.out.is_empty() {
            match unless_blocked(self.stream.try_write(&self.out)) {
                Ok(Some(n)) => drop(self.out.drain(..n)),
                Ok(None) => break,
                Err(error) => return Err(error.to_string()),
            }
        }
        Ok(())
    }
}
