//! A server of its own for a test, on a port of its own, and the plainest of clients.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use swellcast::control::{Epoch, Store};
use swellcast::engine::Clock;
use swellcast::scene::Scene;
use swellcast::server::{self, Ocean, Settings};
use swellcast::wire::{FrameHeader, split};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_websockets::{ClientBuilder, Limits, Message, WebSocketStream};

/// Longer than anything here may take.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// A small sea: one cascade of 32 x 32, wind from 2 to 20 m/s, with foam.
pub const SMALL: &str =
    "name = \"small\"\n[wind]\nspeed_mps = 8\nrange_mps = [2.0, 20.0]\n[cascades]\nn = 32\npatches_m = [60]\n";

/// A server under way.
pub struct Served {
    pub address: SocketAddr,
    pub ocean: Arc<Ocean>,
    stop: oneshot::Sender<()>,
    done: JoinHandle<std::io::Result<()>>,
}

/// An HTTP answer.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: String,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }

    pub fn header(&self, name: &str) -> Option<&str> {
        let mut lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, value)| value)
    }
}

impl Served {
    pub async fn start(scene: &Scene, settings: Settings) -> Self {
        let store = Store::in_memory().unwrap();
        let begun = store.begin(scene, Epoch::begin(Clock::unix_now_ns() - 3_600_000_000_000)).unwrap();
        Self::of(Ocean::start(store, begun, settings)).await
    }

    pub async fn of(ocean: Arc<Ocean>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel();
        let shutdown = async move { stopped.await.unwrap_or(()) };
        let done = tokio::spawn(server::run(listener, Arc::clone(&ocean), shutdown));
        Self { address, ocean, stop, done }
    }

    pub async fn stop(self) {
        self.stop.send(()).unwrap();
        timeout(PATIENCE, self.done).await.expect("stops").unwrap().unwrap();
    }

    pub async fn raw(&self, request: &[u8]) -> String {
        raw(self.address, request).await
    }

    pub async fn http(&self, method: &str, path: &str, headers: &str, body: &str) -> Answer {
        let request = format!(
            "{method} {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\ncontent-length: {}\r\n{headers}\r\n{body}",
            self.address,
            body.len()
        );
        let text = self.raw(request.as_bytes()).await;
        let (head, body) =
            text.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no answer to {method} {path}: {text}"));
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Answer { status, head: head.to_owned(), body: body.to_owned() }
    }

    pub async fn get(&self, path: &str) -> Answer {
        self.http("GET", path, "", "").await
    }

    pub async fn client(&self) -> Client {
        Client::on(TcpStream::connect(self.address).await.unwrap()).await
    }
}

/// Sends bytes, reads to the end.
pub async fn raw(address: SocketAddr, request: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(request).await.unwrap();
    let mut answer = Vec::new();
    // A reset ends an answer, too: what came before it counts.
    let _ = timeout(PATIENCE, stream.read_to_end(&mut answer)).await.expect("answers");
    String::from_utf8_lossy(&answer).into_owned()
}

/// A stream client.
pub struct Client {
    pub stream: WebSocketStream<TcpStream>,
}

/// What a client reads.
#[derive(Debug)]
pub enum Got {
    Text(Value),
    Frame(Bytes),
    Closed(u16),
}

impl Client {
    /// A client on a connection that stands.
    pub async fn on(stream: TcpStream) -> Self {
        let uri = format!("ws://{}/v1/stream", stream.peer_addr().unwrap());
        let builder = ClientBuilder::new().uri(&uri).unwrap().limits(Limits::unlimited());
        let protocol = ("sec-websocket-protocol".parse().unwrap(), "swellcast.v1".parse().unwrap());
        let builder = builder.add_header(protocol.0, protocol.1).unwrap();
        let (stream, answer) = timeout(PATIENCE, builder.connect_on(stream)).await.expect("upgrades").unwrap();
        assert_eq!(answer.headers()["sec-websocket-protocol"], "swellcast.v1");
        Self { stream }
    }

    pub async fn send(&mut self, message: &Value) {
        self.stream.send(Message::text(message.to_string())).await.unwrap();
    }

    /// The next message; pings and pongs apart.
    pub async fn next(&mut self) -> Got {
        loop {
            let message = match timeout(PATIENCE, self.stream.next()).await.expect("the server says something") {
                Some(Ok(message)) => message,
                end => return Got::Closed(if end.is_none() { 1006 } else { 1999 }),
            };
            if let Some((code, _)) = message.as_close() {
                return Got::Closed(code.into());
            }
            if let Some(text) = message.as_text() {
                return Got::Text(serde_json::from_str(text).unwrap());
            }
            if message.is_binary() {
                return Got::Frame(message.into_payload().into());
            }
        }
    }

    /// The next text message of a type, whatever comes before it.
    pub async fn text(&mut self, kind: &str) -> Value {
        loop {
            match self.next().await {
                Got::Text(text) if text["type"] == kind => return text,
                Got::Closed(code) => panic!("closed with {code} in wait of {kind}"),
                _ => {}
            }
        }
    }

    /// The next frame, whatever comes before it.
    pub async fn frame(&mut self) -> Bytes {
        loop {
            match self.next().await {
                Got::Frame(frame) => return frame,
                Got::Closed(code) => panic!("closed with {code} in wait of a frame"),
                Got::Text(_) => {}
            }
        }
    }

    /// Reads until the server closes; with which code.
    pub async fn closed(&mut self) -> u16 {
        loop {
            if let Got::Closed(code) = self.next().await {
                return code;
            }
        }
    }

    /// Subscribes to units of the full grid of the first cascade; what the server answers.
    pub async fn subscribe(&mut self, rate_hz: u32, groups: &[&str]) -> Value {
        let units: Vec<Value> = groups.iter().map(|group| unit(0, group)).collect();
        self.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": rate_hz, "units": units })).await;
        self.text("subscribed").await
    }
}

/// A unit of the first cascade.
pub fn unit(level: u32, group: &str) -> Value {
    json!({ "cascade": 0, "level": level, "class": "1mm", "group": group })
}

/// Groups of a sea without foam.
pub const ALL: [&str; 3] = ["displacement", "slopes", "derivatives"];

/// The header of a frame.
#[track_caller]
pub fn header(frame: &Bytes) -> FrameHeader {
    split(frame).expect("every frame is whole").0
}

/// `n` frames by (tick, group).
pub async fn frames(client: &mut Client, n: usize) -> BTreeMap<(u64, u8), Bytes> {
    let mut got = BTreeMap::new();
    while got.len() < n {
        let frame = client.frame().await;
        let header = header(&frame);
        assert!(got.insert((header.tick, header.group), frame).is_none(), "a frame comes once");
    }
    got
}
