//! One connection to a server: the upgrade, the time exchange that keeps the shared clock, and a stream of events.
//!
//! Reconnecting is the caller's: wait, open another, and begin with an empty playback if its `hello` has a new epoch.

use std::collections::VecDeque;
use std::time::Duration;

use bytes::Bytes;
use futures_util::{SinkExt, StreamExt};
use http::{HeaderValue, Uri, header::SEC_WEBSOCKET_PROTOCOL};
use thiserror::Error;
use tokio::net::TcpStream;
use tokio::time::{Interval, MissedTickBehavior, interval, timeout};
use tokio_websockets::{ClientBuilder, Limits, Message, WebSocketStream};

use super::clock::{Exchange, SharedClock};
use super::fares::Fares;
use super::metered::Metered;
use super::playback::MAX_SAMPLES;
use crate::tile::{DecodeError, DecodedFrame, Decoder};
use crate::wire::{
    ClientMessage, ErrorCode, HEADER_BYTES, Hello, Quality, SUBPROTOCOL, ServerMessage, Status, Subscribe, Subscribed,
    TICKS_PER_SECOND, TILE, Time, UnitName, UnitRate, WireChange,
};

/// Largest message taken: the largest frame, 3 planes of 256 x 256 samples of 4 bytes, and tables.
const MAX_MESSAGE: usize = HEADER_BYTES + 3 * TILE * TILE * 4 + 8192;
/// Most bytes read before the upgrade is done.
const MAX_UPGRADE: usize = 64 << 10;
/// How long a server may take for the upgrade, and for reading what is sent to it.
const PATIENCE: Duration = Duration::from_secs(5);
/// A server sends `status` every second: one that says nothing for this long is gone, microseconds.
const SILENCE_US: i64 = 10_000_000;
/// Time exchanges are this far apart at first ...
const BEAT: Duration = Duration::from_millis(100);
/// ... for this many, and then every tenth beat.
const QUICK_EXCHANGES: u64 = 20;
/// A report is made once in so many beats.
const BEATS_OF_REPORT: u64 = 10;
/// Requests whose answers are still awaited.
const MAX_ASKED: usize = 16;

/// No server sends frames longer before their ticks: 10 s.
const LONGEST_LEAD: i64 = 10 * TICKS_PER_SECOND;

/// What came from the server.
#[derive(Debug)]
pub enum Event {
    /// The first message: what sea this is. A further one in the same connection: its layout changes.
    Hello(Box<Hello>),
    /// The answer to a subscription.
    Subscribed(Subscribed),
    /// A frame, and its bytes as they came.
    Frame(DecodedFrame, Bytes),
    /// How the sea and the server are, once a second.
    Status(Status),
    /// Less is sent than was granted, or all of it again.
    Quality(Quality),
    /// A change was accepted.
    Change(WireChange),
    /// The server refused something.
    Error {
        /// Kind of refusal.
        code: ErrorCode,
        /// For people.
        detail: String,
    },
    /// A frame that is not one; it was dropped.
    BadFrame(DecodeError),
    /// A text that is no message; it was dropped.
    BadText(String),
    /// Nothing more will come.
    Closed(Closed),
}

/// Why a connection ended.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Closed {
    /// The server closed it (PROTOCOL.md section 7).
    #[error("the server closed with {code}{}{reason}", if reason.is_empty() { "" } else { ": " })]
    ByServer {
        /// The close code; 1005 when it gave none.
        code: u16,
        /// Its reason.
        reason: String,
    },
    /// The connection broke.
    #[error("the connection broke: {0}")]
    Broken(String),
    /// Nothing came for ten seconds, or what was sent was not read for five.
    #[error("the server is silent")]
    Silent,
    /// Another protocol than ours.
    #[error("the server's {field} is {got}, must be {want}")]
    Other {
        /// Field of `hello`.
        field: &'static str,
        /// What it says.
        got: i64,
        /// What we speak.
        want: i64,
    },
}

/// Why there is no connection.
#[derive(Debug, Error)]
pub enum ConnectError {
    /// The URL can't be used.
    #[error("url is {url:?}, must be like http://host:port or ws://host:port")]
    Url {
        /// As given.
        url: String,
    },
    /// No connection to that address.
    #[error("can't connect to {address}")]
    Connect {
        /// Host and port.
        address: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// The upgrade was refused or went wrong.
    #[error("{address} refuses the stream: {reason}")]
    Upgrade {
        /// Host and port.
        address: String,
        /// What went wrong.
        reason: String,
    },
}

/// An open connection. `N` gives our time: microseconds of any clock that only goes forward.
pub struct Connection<N> {
    socket: WebSocketStream<Metered<TcpStream>>,
    now_us: N,
    clock: SharedClock,
    beat: Interval,
    beats: u64,
    asked: VecDeque<i64>,
    heard_us: i64,
    subscriptions: u64,
    decoder: Decoder,
    fares: Fares,
    reports: bool,
    closed: Option<Closed>,
}

impl<N: Fn() -> i64> Connection<N> {
    /// Connects to the stream of a server.
    ///
    /// # Errors
    /// [`ConnectError`] when the URL is wrong, nobody listens, or the upgrade is refused or takes more than 5 s.
    pub async fn open(url: &str, now_us: N) -> Result<Self, ConnectError> {
        let (uri, host, port) = stream_uri(url).ok_or_else(|| ConnectError::Url { url: url.to_owned() })?;
        let address = format!("{host}:{port}");
        let refused = |reason: String| ConnectError::Upgrade { address: address.clone(), reason };
        let late = || std::io::Error::from(std::io::ErrorKind::TimedOut);
        let tcp = timeout(PATIENCE, TcpStream::connect((host.trim_matches(['[', ']']), port)))
            .await
            .unwrap_or_else(|_| Err(late()))
            .map_err(|source| ConnectError::Connect { address: address.clone(), source })?;
        // Time exchanges are a few bytes each and must not wait for one another.
        tcp.set_nodelay(true).map_err(|source| ConnectError::Connect { address: address.clone(), source })?;
        let builder = ClientBuilder::from_uri(uri)
            .limits(Limits::default().max_payload_len(Some(MAX_MESSAGE)))
            .add_header(SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(SUBPROTOCOL))
            .map_err(|e| refused(e.to_string()))?;
        let (mut socket, response) = timeout(PATIENCE, builder.connect_on(Metered::new(tcp, MAX_UPGRADE)))
            .await
            .map_err(|_| refused("it takes more than 5 s".to_owned()))?
            .map_err(|e| refused(e.to_string()))?;
        if response.headers().get(SEC_WEBSOCKET_PROTOCOL).is_none_or(|name| name != SUBPROTOCOL) {
            return Err(refused(format!("it doesn't speak {SUBPROTOCOL}")));
        }
        socket.get_mut().open();
        let mut beat = interval(BEAT);
        beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let heard_us = now_us();
        Ok(Self {
            socket,
            now_us,
            clock: SharedClock::new(),
            beat,
            beats: 0,
            asked: VecDeque::new(),
            heard_us,
            subscriptions: 0,
            decoder: Decoder::new(MAX_SAMPLES as usize),
            fares: Fares::default(),
            reports: true,
            closed: None,
        })
    }

    /// Replaces the subscription; the answer comes as [`Event::Subscribed`] with the id that this returns. With `keys`,
    /// every second begins with key frames.
    pub async fn subscribe(&mut self, rate_hz: u32, units: Vec<UnitName>, keys: bool) -> u64 {
        self.subscriptions += 1;
        let id = self.subscriptions;
        let units = units.into_iter().map(UnitRate::from).collect();
        self.send(&ClientMessage::Subscribe(Subscribe { id, rate_hz, units, keys })).await;
        id
    }

    /// Tells the server no more how this client fares: for one that shows nothing, and would have it all however late.
    pub fn stop_reports(&mut self) {
        self.reports = false;
    }

    /// The shared clock.
    pub fn clock(&self) -> &SharedClock {
        &self.clock
    }

    /// Server time now, microseconds since tick 0; `None` before the first exchange.
    pub fn server_us(&self) -> Option<i64> {
        self.clock.server_us((self.now_us)())
    }

    /// How far server time can be off now, microseconds.
    pub fn error_bound_us(&self) -> Option<i64> {
        self.clock.error_bound_us((self.now_us)())
    }

    /// The next event. Keeps the time exchange going meanwhile, so it must be called again and again; may be dropped
    /// at any time without losing an event. After [`Event::Closed`] there is only that.
    pub async fn next(&mut self) -> Event {
        loop {
            if let Some(closed) = &self.closed {
                return Event::Closed(closed.clone());
            }
            tokio::select! {
                _ = self.beat.tick() => self.on_beat().await,
                message = self.socket.next() => {
                    self.heard_us = (self.now_us)();
                    match message {
                        Some(Ok(message)) => if let Some(event) = self.read(message).await { return event },
                        Some(Err(error)) => self.close(Closed::Broken(error.to_string())),
                        None => self.close(Closed::Broken("no more bytes".to_owned())),
                    }
                }
            }
        }
    }

    /// Says goodbye; waits for the server's answer for a moment only.
    pub async fn close_politely(mut self) {
        let _ = timeout(PATIENCE / 5, self.socket.close()).await;
    }

    async fn on_beat(&mut self) {
        let now = (self.now_us)();
        if now - self.heard_us > SILENCE_US {
            return self.close(Closed::Silent);
        }
        let due = self.beats < QUICK_EXCHANGES || self.beats.is_multiple_of(10);
        self.beats += 1;
        if due {
            if self.asked.len() == MAX_ASKED {
                self.asked.pop_front();
            }
            self.asked.push_back(now);
            self.send(&ClientMessage::Time(Time { t0: now as f64 })).await;
        }
        if self.reports
            && self.beats.is_multiple_of(BEATS_OF_REPORT)
            && let Some(report) = self.server_us().and_then(|server_us| self.fares.report(server_us))
        {
            self.send(&ClientMessage::Report(report)).await;
        }
    }

    /// What a message says; `None` when it is only for the connection itself.
    async fn read(&mut self, message: Message) -> Option<Event> {
        if message.is_binary() {
            let frame: Bytes = message.into_payload().into();
            let decoded = self.decoder.decode(&frame);
            self.fares.decoded(&decoded, (self.now_us)() - self.heard_us);
            return Some(match decoded {
                Ok(decoded) => Event::Frame(decoded, frame),
                Err(error) => Event::BadFrame(error),
            });
        }
        if let Some((code, reason)) = message.as_close() {
            self.close(Closed::ByServer { code: code.into(), reason: reason.to_owned() });
            return None;
        }
        if message.is_ping() {
            // The pong is queued already; unless it leaves before the next ping is read, pongs could pile up.
            self.flush().await;
            return None;
        }
        let text = message.as_text()?;
        match ServerMessage::parse(text) {
            Err(error) => Some(Event::BadText(error.to_string())),
            // Points are for others.
            Ok(None | Some(ServerMessage::PointsSubscribed(_))) => None,
            Ok(Some(ServerMessage::Time(answer))) => {
                let at = self.asked.iter().position(|t0| *t0 as f64 == answer.t0)?;
                let t0 = self.asked.remove(at)?;
                self.clock.observe(Exchange { t0, t1: answer.t1_us, t2: answer.t2_us, t3: self.heard_us });
                None
            }
            Ok(Some(ServerMessage::Hello(hello))) => {
                let other = |field, got, want| Closed::Other { field, got, want };
                if hello.protocol != 1 {
                    self.close(other("protocol", hello.protocol.into(), 1));
                } else if hello.ticks_per_second != TICKS_PER_SECOND {
                    self.close(other("ticks_per_second", hello.ticks_per_second, TICKS_PER_SECOND));
                } else if !(0..=LONGEST_LEAD).contains(&hello.lead_ticks) {
                    self.close(other("lead_ticks", hello.lead_ticks, LONGEST_LEAD));
                } else {
                    return Some(Event::Hello(hello));
                }
                None
            }
            Ok(Some(ServerMessage::Subscribed(subscribed))) => {
                let granted = |unit: &UnitName| subscribed.units.iter().any(|granted| granted.unit == *unit);
                self.decoder.retain(granted);
                self.fares = Fares::default();
                Some(Event::Subscribed(subscribed))
            }
            Ok(Some(ServerMessage::Quality(quality))) => Some(Event::Quality(quality)),
            Ok(Some(ServerMessage::Status(status))) => Some(Event::Status(status)),
            Ok(Some(ServerMessage::Change(change))) => Some(Event::Change(change)),
            Ok(Some(ServerMessage::Error { code, detail, .. })) => Some(Event::Error { code, detail }),
        }
    }

    async fn send(&mut self, message: &ClientMessage) {
        let text = serde_json::to_string(message).expect("plain data serialises");
        if let Err(error) = self.socket.feed(Message::text(text)).await {
            return self.close(Closed::Broken(error.to_string()));
        }
        self.flush().await;
    }

    async fn flush(&mut self) {
        match timeout(PATIENCE, self.socket.flush()).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => self.close(Closed::Broken(error.to_string())),
            Err(_) => self.close(Closed::Silent),
        }
    }

    fn close(&mut self, why: Closed) {
        self.closed.get_or_insert(why);
    }
}

/// The address of the stream, its host and its port, from what people type.
pub(crate) fn stream_uri(url: &str) -> Option<(Uri, String, u16)> {
    let rest = match url.split_once("://") {
        Some(("http" | "ws", rest)) => rest,
        Some(_) => return None,
        None => url,
    };
    let rest = rest.trim_end_matches('/');
    let given: Uri = format!("ws://{rest}").parse().ok()?;
    let path = if given.path().len() <= 1 { "/v1/stream" } else { "" };
    let uri: Uri = format!("ws://{rest}{path}").parse().ok()?;
    let (host, port) = (uri.host()?.to_owned(), uri.port_u16().unwrap_or(80));
    Some((uri, host, port))
}

#[cfg(test)]
mod tests {
    use super::stream_uri;

    #[test]
    fn a_url_leads_to_the_stream() {
        for (url, uri, host, port) in [
            ("http://127.0.0.1:8080", "ws://127.0.0.1:8080/v1/stream", "127.0.0.1", 8080),
            ("http://127.0.0.1:8080/", "ws://127.0.0.1:8080/v1/stream", "127.0.0.1", 8080),
            ("ws://sea.example/v1/stream", "ws://sea.example/v1/stream", "sea.example", 80),
            ("localhost:9000", "ws://localhost:9000/v1/stream", "localhost", 9000),
            ("http://[::1]:8080", "ws://[::1]:8080/v1/stream", "[::1]", 8080),
        ] {
            assert_eq!(stream_uri(url), Some((uri.parse().unwrap(), host.to_owned(), port)), "{url}");
        }
        for url in ["", "https://sea.example", "ftp://sea.example", "http://", "http:// ", "http://a:b:c"] {
            assert_eq!(stream_uri(url), None, "{url:?}");
        }
    }
}
