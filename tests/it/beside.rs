//! Laws of what a hostile client costs others, which is nothing: each of their frames comes, once, in order.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use bytes::Bytes;
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use swellcast::server::Settings;
use swellcast::wire::MAX_MESSAGE_BYTES;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::sync::oneshot;
use tokio::task::{JoinHandle, JoinSet};
use tokio::time::{Instant, sleep, timeout};
use tokio_websockets::{Message, Payload};

use crate::served::{Client, Got, PATIENCE, SMALL, Served, header, unit};
use crate::support::scene;

const RATE_HZ: u32 = 30;
/// Frames that are read before an attack may end.
const ENOUGH: usize = 30;
const INTERVAL: u64 = 7200 / RATE_HZ as u64;

/// A client that reads its frames beside whatever else a test does.
struct Beside {
    read: Arc<AtomicUsize>,
    stop: oneshot::Sender<()>,
    reader: JoinHandle<Vec<u64>>,
    skipped: u64,
}

impl Beside {
    async fn start(served: &Served) -> Self {
        let mut client = served.client().await;
        client.subscribe(RATE_HZ, &["displacement"]).await;
        let mut ticks = vec![header(&client.frame().await).tick];
        let (stop, mut stopped) = oneshot::channel();
        let read = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&read);
        let reader = async move {
            while stopped.try_recv().is_err() {
                ticks.push(header(&client.frame().await).tick);
                count.fetch_add(1, Relaxed);
            }
            ticks.push(header(&client.frame().await).tick);
            ticks
        };
        Self { read, stop, reader: tokio::spawn(reader), skipped: served.ocean.counters().skipped_frames }
    }

    /// The attack must go on.
    fn reads_on(&self) -> bool {
        self.read.load(Relaxed) < ENOUGH
    }

    /// Missing may be only what the engine had no time for: tests beside this one share the machine.
    async fn missed_nothing(self, served: &Served) {
        self.stop.send(()).unwrap();
        let ticks = timeout(PATIENCE, self.reader).await.expect("frames go on").unwrap();
        let mut missing = 0;
        for pair in ticks.windows(2) {
            assert!(pair[1] > pair[0] && (pair[1] - pair[0]) % INTERVAL == 0, "in order: {pair:?}");
            missing += (pair[1] - pair[0]) / INTERVAL - 1;
        }
        let skipped = served.ocean.counters().skipped_frames - self.skipped;
        assert!(missing <= skipped, "{missing} of {} frames are missing, {skipped} were skipped", ticks.len());
    }
}

/// Waits until no client is left but that of [`Beside`], and no connection but its and the one that asks.
async fn all_are_gone(served: &Served) {
    let began = Instant::now();
    loop {
        let page = served.get("/metrics").await.body;
        if page.contains("swellcast_clients 1\n") && page.contains("swellcast_connections 2\n") {
            return;
        }
        assert!(began.elapsed() < PATIENCE, "{page}");
        sleep(Duration::from_millis(50)).await;
    }
}

/// A masked frame; the mask is 0.
fn frame(first: u8, payload: &[u8]) -> Vec<u8> {
    let length = payload.len();
    let mut frame = vec![first];
    match length {
        0..126 => frame.push(0x80 | length as u8),
        126..65536 => frame.extend([&[0xfe][..], &(length as u16).to_be_bytes()].concat()),
        _ => frame.extend([&[0xff][..], &(length as u64).to_be_bytes()].concat()),
    }
    frame.extend([0; 4]);
    frame.extend(payload);
    frame
}

/// A client that keeps little of what it does not read.
async fn deaf(served: &Served) -> Client {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    Client::on(socket.connect(served.address).await.unwrap()).await
}

fn upgrade(served: &Served, more: &str) -> String {
    format!(
        "GET /v1/stream HTTP/1.1\r\nhost: {}\r\nconnection: Upgrade\r\nupgrade: websocket\r\n\
         sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
         sec-websocket-protocol: swellcast.v1\r\n{more}\r\n",
        served.address
    )
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn silence_and_a_byte_at_a_time_end_when_the_head_is_late() {
    let head = Duration::from_secs(1);
    let served = Served::start(&scene(SMALL), Settings { head, ..Settings::default() }).await;
    let beside = Beside::start(&served).await;
    let mut all = JoinSet::new();
    for n in 0..60 {
        // Every third says nothing at all; the others would take 10 s.
        let request = if n % 3 == 0 { String::new() } else { upgrade(&served, "") };
        let (mut read, mut write) = TcpStream::connect(served.address).await.unwrap().into_split();
        all.spawn(async move {
            let trickle = async {
                for byte in request.bytes() {
                    if write.write_all(&[byte]).await.is_err() {
                        break;
                    }
                    sleep(Duration::from_millis(50)).await;
                }
                std::future::pending().await
            };
            let (began, mut answer) = (Instant::now(), [0; 16]);
            tokio::select! {
                // A reset, where bytes came after the end.
                read = read.read(&mut answer) => assert_eq!(read.unwrap_or(0), 0, "no answer to half a request"),
                () = trickle => {}
            }
            began.elapsed()
        });
    }
    while let Some(took) = timeout(PATIENCE, all.join_next()).await.expect("each ends") {
        let took = took.unwrap();
        assert!(took > head / 2 && took < 5 * head, "{took:?}");
    }
    all_are_gone(&served).await;
    beside.missed_nothing(&served).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn fragments_make_a_message_and_none_without_end() {
    let settings = Settings { silence: Duration::from_secs(1), ..Settings::default() };
    let served = Served::start(&scene(SMALL), Settings { ping: settings.silence, ..settings }).await;
    let beside = Beside::start(&served).await;

    // A byte a frame, a ping between any two.
    let mut client = served.client().await;
    let text = json!({ "type": "subscribe", "id": 7, "rate_hz": 30, "units": [unit(0, "slopes")] }).to_string();
    let mut bytes = frame(0x01, b"");
    for byte in text.bytes() {
        bytes.extend(frame(0x89, b"ping"));
        bytes.extend(frame(0x00, &[byte]));
    }
    bytes.extend(frame(0x80, b""));
    client.stream.get_mut().write_all(&bytes).await.unwrap();
    assert_eq!(client.text("subscribed").await["id"], 7);
    client.frame().await;
    drop(client);

    // Empty fragments for ever are no message: whoever sends nothing else is silent.
    let endless = [frame(0x01, b"{"), frame(0x00, b"").repeat(10_000)].concat();
    let mut all = JoinSet::new();
    for _ in 0..2 {
        let mut client = served.client().await;
        let endless = endless.clone();
        all.spawn(async move {
            let (mut read, mut write) = client.stream.get_mut().split();
            let mut waste = Vec::new();
            // Read, so that it is not for its deafness that it is dropped; it answers no ping.
            let _ =
                tokio::join!(read.read_to_end(&mut waste), async { while write.write_all(&endless).await.is_ok() {} });
        });
    }
    while let Some(ended) = timeout(PATIENCE, all.join_next()).await.expect("each is dropped") {
        ended.unwrap();
    }
    all_are_gone(&served).await;
    beside.missed_nothing(&served).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_message_too_long_is_refused_as_soon_as_that_is_known() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let beside = Beside::start(&served).await;
    let announced = |length: u64| [&[0x81, 0xff][..], &length.to_be_bytes(), &[0; 4]].concat();
    let most = vec![b' '; MAX_MESSAGE_BYTES];
    let parts = [frame(0x01, &most), frame(0x80, b" ")].concat();
    let longer = [frame(0x01, &most[1..]), frame(0x00, b" "), frame(0x89, b""), frame(0x00, b" ")].concat();
    let announced = [MAX_MESSAGE_BYTES as u64 + 1, 1 << 32, (1 << 63) - 1, u64::MAX].map(announced);
    for bytes in announced.iter().chain([&parts, &longer]).cycle().take_while(|_| beside.reads_on()) {
        let mut client = served.client().await;
        client.stream.get_mut().write_all(bytes).await.unwrap();
        assert_eq!(client.closed().await, 1009, "{:?}", &bytes[..14]);
    }
    // One byte less is read, and found to be no message of ours.
    let mut client = served.client().await;
    client.stream.get_mut().write_all(&[frame(0x01, &most[1..]), frame(0x80, b" ")].concat()).await.unwrap();
    assert_eq!(client.text("error").await["code"], "malformed");
    drop(client);
    all_are_gone(&served).await;
    beside.missed_nothing(&served).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_flood_of_subscriptions_costs_others_nothing() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let beside = Beside::start(&served).await;
    let ask = |id: u32| {
        let units: Vec<Value> =
            if id.is_multiple_of(2) { vec![unit(0, "slopes"), unit(0, "foam")] } else { Vec::new() };
        json!({ "type": "subscribe", "id": id, "rate_hz": 60, "units": units }).to_string()
    };
    while beside.reads_on() {
        let mut all = JoinSet::new();
        for _ in 0..4 {
            let mut client = served.client().await;
            all.spawn(async move {
                // A burst that is allowed.
                for id in 0..240 {
                    client.stream.feed(Message::text(ask(id))).await.unwrap();
                    // As fast as they are answered.
                    if id % 30 == 29 {
                        client.stream.flush().await.unwrap();
                        while !matches!(client.next().await, Got::Text(text) if text["id"] == id) {}
                    }
                }
            });
        }
        while let Some(done) = timeout(PATIENCE, all.join_next()).await.expect("each is answered") {
            done.unwrap();
        }
    }
    // Who never reads what it is answered is closed, or cut off.
    let mut client = deaf(&served).await;
    let flood = async {
        for id in 0.. {
            if client.stream.send(Message::text(ask(id))).await.is_err() {
                break;
            }
        }
    };
    timeout(PATIENCE, flood).await.expect("it is closed");
    drop(client);
    all_are_gone(&served).await;
    beside.missed_nothing(&served).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_flood_of_pings_is_answered_as_far_as_it_is_allowed() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let beside = Beside::start(&served).await;
    let ping = |n: u32| Message::ping(Payload::from(Bytes::copy_from_slice(&n.to_be_bytes().repeat(31))));
    while beside.reads_on() {
        let mut all = JoinSet::new();
        for _ in 0..2 {
            let (mut write, mut read) = served.client().await.stream.split();
            all.spawn(async move {
                let count = 240_u32;
                let send = async {
                    for n in 0..count {
                        write.feed(ping(n)).await.unwrap();
                    }
                    write.flush().await.unwrap();
                };
                let hear = async {
                    let mut next = 0;
                    while next < count {
                        let message = read.next().await.unwrap().unwrap();
                        if message.is_pong() {
                            assert_eq!(message.as_payload()[..4], next.to_be_bytes(), "each, in order");
                            next += 1;
                        }
                    }
                };
                tokio::join!(send, hear);
            });
        }
        while let Some(done) = timeout(PATIENCE, all.join_next()).await.expect("each is answered") {
            done.unwrap();
        }
    }
    // Whoever sends more is let go of, read or not.
    let mut client = deaf(&served).await;
    let pings = frame(0x89, &[b'p'; 125]).repeat(1000);
    let mut sent = 0;
    while let Ok(Ok(())) = timeout(Duration::from_secs(1), client.stream.get_mut().write_all(&pings)).await {
        sent += pings.len();
        assert!(sent < 64 << 20, "the server goes on reading");
    }
    drop(client);
    all_are_gone(&served).await;
    beside.missed_nothing(&served).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn caps_in_all_and_an_address_hold_and_say_when_to_come_again() {
    let three =
        |connections, connections_per_address| Settings { connections, connections_per_address, ..Settings::default() };
    for settings in [three(3, 100), three(100, 3)] {
        let served = Served::start(&scene(SMALL), settings).await;
        let beside = Beside::start(&served).await;
        let second = served.client().await;
        let third = TcpStream::connect(served.address).await.unwrap();
        while beside.reads_on() {
            let refusal = served.raw(b"GET /livez HTTP/1.1\r\nhost: x\r\n\r\n").await;
            assert!(refusal.starts_with("HTTP/1.1 503 ") && refusal.contains("\r\nretry-after: 5\r\n"), "{refusal}");
        }
        // A stranger's seat is as good as a client's, once it is free.
        drop((second, third));
        let began = Instant::now();
        while !served.raw(b"GET /livez HTTP/1.1\r\nconnection: close\r\n\r\n").await.starts_with("HTTP/1.1 200") {
            assert!(began.elapsed() < PATIENCE);
            sleep(Duration::from_millis(20)).await;
        }
        all_are_gone(&served).await;
        beside.missed_nothing(&served).await;
        served.stop().await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn foreign_pages_are_refused_beside_one_that_is_allowed() {
    let settings = Settings { allowed_origins: vec!["https://show.example".to_owned()], ..Settings::default() };
    let served = Served::start(&scene(SMALL), settings).await;
    let beside = Beside::start(&served).await;
    for n in (0..).take_while(|_| beside.reads_on()) {
        let foreign = upgrade(&served, &format!("origin: https://{n}.example\r\nconnection: close\r\n"));
        let answer = served.raw(foreign.as_bytes()).await;
        assert!(answer.starts_with("HTTP/1.1 403 ") && answer.contains("foreign-origin"), "{answer}");
    }
    let mut page = TcpStream::connect(served.address).await.unwrap();
    page.write_all(upgrade(&served, "origin: https://show.example\r\n").as_bytes()).await.unwrap();
    let mut status = [0; 12];
    page.read_exact(&mut status).await.unwrap();
    assert_eq!(&status, b"HTTP/1.1 101");
    drop(page);
    all_are_gone(&served).await;
    beside.missed_nothing(&served).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn clients_gone_silent_are_dropped_beside_one_that_is_not() {
    let settings = Settings { ping: Duration::from_secs(1), silence: Duration::from_secs(2), ..Settings::default() };
    let served = Served::start(&scene(SMALL), settings).await;
    let beside = Beside::start(&served).await;
    let mut all = JoinSet::new();
    for _ in 0..10 {
        let mut client = served.client().await;
        client.subscribe(60, &["slopes"]).await;
        // Takes every frame, and answers no ping.
        all.spawn(async move { client.stream.get_mut().read_to_end(&mut Vec::new()).await.map(drop) });
    }
    while let Some(ended) = timeout(PATIENCE, all.join_next()).await.expect("each is dropped") {
        let _ = ended.unwrap();
    }
    all_are_gone(&served).await;
    beside.missed_nothing(&served).await;
    served.stop().await;
}
