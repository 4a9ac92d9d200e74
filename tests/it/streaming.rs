//! Laws of the stream: everybody gets the same bytes, and nobody can spoil it for others.

use std::collections::BTreeMap;
use std::time::Duration;

use bytes::Bytes;
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use swellcast::server::Settings;
use swellcast::wire::{FrameHeader, split};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio_websockets::Message;

use crate::served::{Client, Got, SMALL, Served, unit};
use crate::support::scene;

const ALL: [&str; 3] = ["displacement", "slopes", "derivatives"];

fn header(frame: &Bytes) -> FrameHeader {
    split(frame).expect("every frame is whole").0
}

/// `n` frames by (tick, group).
async fn frames(client: &mut Client, n: usize) -> BTreeMap<(u64, u8), Bytes> {
    let mut got = BTreeMap::new();
    while got.len() < n {
        let frame = client.frame().await;
        let header = header(&frame);
        assert!(got.insert((header.tick, header.group), frame).is_none(), "a frame comes once");
    }
    got
}

#[track_caller]
fn same_where_both(a: &BTreeMap<(u64, u8), Bytes>, b: &BTreeMap<(u64, u8), Bytes>, at_least: usize) {
    let both: Vec<_> = a.keys().filter(|key| b.contains_key(key)).collect();
    assert!(both.len() >= at_least, "{} in common", both.len());
    assert!(both.iter().all(|key| a[key] == b[key]), "same unit, same tick, same bytes");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn hello_comes_first_and_all_clients_get_the_same_bytes() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let (mut a, mut b) = (served.client().await, served.client().await);
    let Got::Text(hello) = a.next().await else { panic!("hello is a text") };
    assert_eq!((&hello["type"], &hello["protocol"], &hello["scene"]), (&json!("hello"), &json!(1), &json!("small")));
    assert_eq!(hello["lead_ticks"], 1680);
    assert_eq!(hello["limits"], json!({ "message_bytes": 4096, "units": 64, "live_units": 64 }));
    let subscribed = a.subscribe(30, &ALL).await;
    assert_eq!(subscribed["units"].as_array().unwrap().len(), 3);
    b.subscribe(30, &ALL).await;
    let (of_a, of_b) = tokio::join!(frames(&mut a, 60), frames(&mut b, 60));
    same_where_both(&of_a, &of_b, 50);
    let from = subscribed["from_tick"].as_u64().unwrap();
    assert_eq!(of_a.keys().next().unwrap().0, from, "the first tick is the one that was announced");
    let epoch = u64::from_str_radix(hello["epoch"].as_str().unwrap(), 16).unwrap();
    assert!(of_a.values().all(|frame| header(frame).epoch == epoch));
    // One that joins while others watch.
    let mut late = served.client().await;
    late.subscribe(30, &ALL).await;
    let (of_late, of_b) = tokio::join!(frames(&mut late, 30), frames(&mut b, 60));
    same_where_both(&of_late, &of_b, 20);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_rate_gives_every_tick_of_its_absolute_grid_and_no_other() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let (mut slow, mut fast) = (served.client().await, served.client().await);
    slow.subscribe(15, &["displacement"]).await;
    fast.subscribe(60, &["displacement"]).await;
    let (of_slow, of_fast) = tokio::join!(frames(&mut slow, 12), frames(&mut fast, 48));
    for (got, interval) in [(&of_slow, 480), (&of_fast, 120)] {
        let ticks: Vec<u64> = got.keys().map(|(tick, _)| *tick).collect();
        assert!(ticks.iter().all(|tick| tick % interval == 0), "{ticks:?}");
        let gaps = ticks.windows(2).filter(|pair| pair[1] != pair[0] + interval).count();
        assert!(gaps <= 3, "skips are for machines that are too slow: {ticks:?}");
    }
    same_where_both(&of_slow, &of_fast, 6);
    // Another rate, another unit: what goes on flows without a gap.
    let last = of_fast.keys().last().unwrap().0;
    fast.send(&json!({ "type": "subscribe", "id": 2, "rate_hz": 60,
        "units": [unit(0, "displacement"), unit(0, "slopes")] }))
        .await;
    let more = frames(&mut fast, 24).await;
    let displacement: Vec<u64> = more.keys().filter(|(_, group)| *group == 0).map(|(tick, _)| *tick).collect();
    assert_eq!(displacement[0], last + 120, "{displacement:?}");
    assert!(more.keys().any(|(_, group)| *group == 1));
    // None at all: the flow stops.
    fast.send(&json!({ "type": "subscribe", "id": 3, "rate_hz": 60, "units": [] })).await;
    while fast.text("subscribed").await["id"] != 3 {}
    slow.send(&json!({ "type": "subscribe", "id": 3, "rate_hz": 15, "units": [] })).await;
    slow.text("subscribed").await;
    for _ in 0..2 {
        slow.text("status").await;
    }
    let steps = served.ocean.counters().steps;
    slow.text("status").await;
    assert_eq!(served.ocean.counters().steps, steps, "an idle sea makes no step");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn wrong_subscriptions_are_refused_by_field_and_leave_the_old_one() {
    let settings = Settings { live_units: 3, ..Settings::default() };
    let no_foam = format!("{SMALL}[effects]\nfoam = false\n");
    let served = Served::start(&scene(&no_foam), settings).await;
    let mut client = served.client().await;
    client.subscribe(15, &["displacement"]).await;
    let ask = |rate: u32, units: Vec<Value>| json!({ "type": "subscribe", "id": 77, "rate_hz": rate, "units": units });
    let mut elsewhere = unit(0, "slopes");
    elsewhere["cascade"] = json!(1);
    let cases = [
        (ask(25, vec![]), "invalid", "rate_hz"),
        (ask(15, vec![unit(0, "slopes"), elsewhere]), "invalid", "units[1].cascade"),
        (ask(15, vec![unit(0, "slopes"), unit(0, "slopes"), unit(9, "slopes")]), "invalid", "units[2].level"),
        (ask(15, vec![unit(0, "foam")]), "invalid", "units[0].group"),
    ];
    for (request, code, field) in cases {
        client.send(&request).await;
        let error = client.text("error").await;
        assert_eq!((&error["code"], &error["field"], &error["id"]), (&json!(code), &json!(field), &json!(77)));
    }
    let mut other = served.client().await;
    let mut four = ALL.map(|group| unit(0, group)).to_vec();
    four[2]["class"] = json!("5mm");
    four.push(unit(0, "derivatives"));
    other.send(&ask(15, four.clone())).await;
    let error = other.text("error").await;
    assert_eq!(
        (&error["code"], &error["field"], &error["id"]),
        (&json!("unavailable"), &json!("units[3]"), &json!(77))
    );
    four.truncate(3);
    other.send(&ask(15, four)).await;
    other.text("subscribed").await;
    let mut third = served.client().await;
    let mut coarse = unit(0, "slopes");
    coarse["class"] = json!("20mm");
    third.send(&ask(15, vec![coarse])).await;
    assert_eq!(third.text("subscribed").await["units"][0], unit(0, "slopes"), "the next finer one that is live");
    assert_eq!(header(&third.frame().await).class, 1);
    client.frame().await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn time_is_answered_and_status_comes_each_second() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    for t0 in [0.0, -1.5, 1e300] {
        client.send(&json!({ "type": "time", "t0": t0 })).await;
        let time = client.text("time").await;
        assert_eq!(time["t0"], t0);
        let (t1, t2) = (time["t1_us"].as_i64().unwrap(), time["t2_us"].as_i64().unwrap());
        assert!(t1 <= t2 && t2 - t1 < 1_000_000);
    }
    let (first, second) = (client.text("status").await, client.text("status").await);
    let elapsed = second["tick"].as_i64().unwrap() - first["tick"].as_i64().unwrap();
    assert!((100..=14_400).contains(&elapsed), "{elapsed}");
    assert_eq!((&second["clients"], &second["sequence"]), (&json!(1), &json!(0)));
    assert_eq!(second["wind"], json!({ "speed_mps": 8.0, "direction_from_deg": 270.0 }));
    assert!(second["hs_m"].as_f64().unwrap() > 0.1);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn wrong_messages_end_with_the_code_that_says_why() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut watcher = served.client().await;
    watcher.subscribe(15, &["displacement"]).await;

    let mut client = served.client().await;
    client.stream.send(Message::binary(vec![0; 8])).await.unwrap();
    assert_eq!(client.closed().await, 1003);

    let mut client = served.client().await;
    client.stream.send(Message::text("x".repeat(100_000))).await.unwrap();
    assert_eq!(client.closed().await, 1009);

    let mut client = served.client().await;
    for _ in 0..15 {
        client.stream.send(Message::text("{")).await.unwrap();
        assert_eq!(client.text("error").await["code"], "malformed");
    }
    client.send(&json!({ "type": "nonsense" })).await;
    assert_eq!(client.text("error").await["code"], "unknown_type");
    assert_eq!(client.closed().await, 1008);

    // Bytes that are no WebSocket, and a text that is no UTF-8, on the raw connection.
    for (bytes, code) in [(&[0xff, 0xff, 0, 0, 0, 0, 0, 0][..], 1002), (&[0x81, 0x82, 0, 0, 0, 0, 0xff, 0xff], 1007)] {
        let mut client = served.client().await;
        client.text("hello").await;
        client.stream.get_mut().write_all(bytes).await.unwrap();
        assert_eq!(client.closed().await, code);
    }
    let mut client = served.client().await;
    client.stream.send(Message::close(None, "")).await.unwrap();
    client.closed().await;
    frames(&mut watcher, 5).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ten_thousand_random_messages_harm_nobody() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut watcher = served.client().await;
    watcher.subscribe(15, &["displacement"]).await;
    let good = json!({ "type": "subscribe", "id": 1, "rate_hz": 30, "units": [unit(0, "slopes")] }).to_string();
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = move |below: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % below
    };
    let (mut sent, mut answered) = (0, 0);
    while sent < 10_000 {
        let mut client = served.client().await;
        for _ in 0..100 {
            let mut text = good.clone().into_bytes();
            for _ in 0..next(4) {
                let at = next(text.len());
                match next(3) {
                    0 => text[at] = next(128) as u8,
                    1 => text.truncate(at.max(1)),
                    _ => text.insert(at, b"0123456789-.eE[]{}\",:"[next(21)]),
                }
            }
            let text = String::from_utf8(text).unwrap();
            let message =
                if next(50) == 0 { Message::ping(text[..text.len().min(99)].to_owned()) } else { Message::text(text) };
            if client.stream.send(message).await.is_err() {
                break;
            }
            sent += 1;
        }
        let _ = client.stream.send(Message::close(None, "")).await;
        while let Some(Ok(message)) = client.stream.next().await {
            answered += usize::from(message.is_text());
        }
    }
    assert!(answered > 1000, "{answered}");
    frames(&mut watcher, 5).await;
    assert_eq!(served.get("/readyz").await.status, 200);
    // Noise on the bare connection, before any HTTP.
    for n in 0..50 {
        let noise: Vec<u8> = (0..n * 40).map(|_| next(256) as u8).collect();
        let mut stream = TcpStream::connect(served.address).await.unwrap();
        let _ = stream.write_all(&noise).await;
        let _ = stream.shutdown().await;
        let _ = stream.read_to_end(&mut Vec::new()).await;
    }
    frames(&mut watcher, 5).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_does_not_read_costs_others_nothing() {
    let big = "name = \"small\"\n[wind]\nspeed_mps = 8\n[cascades]\nn = 128\npatches_m = [100]\n";
    let served = Served::start(&scene(big), Settings { ring_bytes: 8 << 20, ..Settings::default() }).await;
    let mut stalled = Vec::new();
    for _ in 0..5 {
        let socket = TcpSocket::new_v4().unwrap();
        socket.set_recv_buffer_size(4096).unwrap();
        let mut client = served.client_on(socket.connect(served.address).await.unwrap()).await;
        client.subscribe(60, &ALL).await;
        stalled.push(client);
    }
    let mut reader = served.client().await;
    reader.subscribe(60, &ALL).await;
    let got = frames(&mut reader, 3 * 60 * 3).await;
    let (first, last) = (got.keys().next().unwrap().0, got.keys().last().unwrap().0);
    let ticks = (last - first) / 120 + 1;
    let skipped = served.ocean.counters().skipped_frames;
    assert!(
        got.len() as u64 + 3 * skipped + 6 >= 3 * ticks,
        "{} frames of {ticks} ticks, {skipped} skipped",
        got.len()
    );
    // After a while the silent are dropped, and what they held is given back.
    let mut dropped = false;
    for _ in 0..200 {
        dropped = served.get("/metrics").await.body.contains("swellcast_clients 1\n");
        if dropped {
            break;
        }
        frames(&mut reader, 10).await;
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert!(dropped, "a flush without progress ends a session within 15 s");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_silent_client_is_pinged_and_then_dropped() {
    let settings = Settings { ping: Duration::from_secs(1), silence: Duration::from_secs(2), ..Settings::default() };
    let served = Served::start(&scene(SMALL), settings).await;
    let mut lively = served.client().await;
    let mut silent = served.client().await;
    silent.text("hello").await;
    // Reads the raw bytes and answers no ping.
    let mut waste = Vec::new();
    let read = tokio::time::timeout(Duration::from_secs(15), silent.stream.get_mut().read_to_end(&mut waste));
    let (ended, ()) = tokio::join!(read, async {
        for _ in 0..4 {
            lively.text("status").await;
        }
    });
    assert!(ended.is_ok(), "the silent one is dropped");
    assert!(waste.windows(2).any(|bytes| bytes == [0x89, 0]), "it was pinged");
    lively.text("status").await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_change_is_told_to_all_and_shows_in_the_frames_of_its_tick() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let (mut a, mut b) = (served.client().await, served.client().await);
    a.subscribe(30, &["displacement"]).await;
    b.subscribe(60, &["displacement"]).await;
    let body = r#"{"speed_mps":15,"direction_from_deg":10,"in_seconds":1,"transition_s":0.5}"#;
    let accepted = served.http("PUT", "/v1/scenes/small/wind", "", body).await.json();
    let effective = accepted["effective_tick"].as_i64().unwrap() as u64;
    for client in [&mut a, &mut b] {
        let change = client.text("change").await;
        assert_eq!((&change["sequence"], &change["effective_tick"]), (&json!(1), &accepted["effective_tick"]));
        assert_eq!(change["change"], json!({ "kind": "wind", "speed_mps": 15.0, "direction_from_deg": 10.0 }));
        assert_eq!(change["transition_ticks"], 3600);
        let (mut before, mut after) = (0, 0);
        while after < 10 {
            let header = header(&client.frame().await);
            assert_eq!(header.sequence, u64::from(header.tick >= effective), "at tick {}", header.tick);
            *(if header.sequence == 0 { &mut before } else { &mut after }) += 1;
        }
        assert!(before > 0);
    }
    let mut late = served.client().await;
    assert_eq!(late.text("hello").await["sequence"], 1);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_upgrade_needs_the_subprotocol_and_an_origin_of_ours() {
    let settings = Settings { allowed_origins: vec!["https://show.example".to_owned()], ..Settings::default() };
    let served = Served::start(&scene(SMALL), settings).await;
    let handshake = "connection: Upgrade\r\nupgrade: websocket\r\n";
    let ask = async |more: &str| {
        let request = format!("GET /v1/stream HTTP/1.1\r\nhost: {}\r\n{handshake}{more}\r\n", served.address);
        let mut stream = TcpStream::connect(served.address).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut status = [0; 12];
        stream.read_exact(&mut status).await.unwrap();
        String::from_utf8_lossy(&status[9..]).parse::<u16>().unwrap()
    };
    let version = "sec-websocket-version: 13\r\n";
    let key = "sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let ours = format!("{version}{key}sec-websocket-protocol: other, swellcast.v1\r\n");
    assert_eq!(ask(&ours).await, 101);
    assert_eq!(ask(&format!("{ours}origin: http://{}\r\n", served.address)).await, 101);
    assert_eq!(ask(&format!("{ours}origin: https://show.example\r\n")).await, 101);
    for foreign in ["https://evil.example", "null", "http://", "https://show.example.evil"] {
        assert_eq!(ask(&format!("{ours}origin: {foreign}\r\n")).await, 403, "{foreign}");
    }
    assert_eq!(ask(&format!("{version}{key}")).await, 400);
    assert_eq!(ask(&format!("{version}{key}sec-websocket-protocol: swellcast.v2\r\n")).await, 400);
    assert_eq!(ask(&format!("{key}sec-websocket-protocol: swellcast.v1\r\n")).await, 426);
    assert_eq!(
        ask(&format!("{version}sec-websocket-key: AAAA\r\nsec-websocket-protocol: swellcast.v1\r\n")).await,
        400
    );
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_house_says_so() {
    let served = Served::start(&scene(SMALL), Settings { clients: 1, ..Settings::default() }).await;
    let _first = served.client().await;
    assert_eq!(served.client().await.closed().await, 1013);
    served.stop().await;

    let served = Served::start(&scene(SMALL), Settings { connections_per_address: 2, ..Settings::default() }).await;
    let mut first = served.client().await;
    let second = served.client().await;
    let refusal = served.raw(b"").await;
    assert!(refusal.starts_with("HTTP/1.1 503") && refusal.contains("\"status\":503"), "{refusal}");
    drop(second);
    first.text("status").await;
    assert_eq!(served.get("/livez").await.status, 200, "a seat is given back");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_that_shuts_down_tells_its_clients() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    client.subscribe(30, &["displacement"]).await;
    let address = served.address;
    let (code, ()) = tokio::join!(client.closed(), served.stop());
    assert_eq!(code, 1001);
    assert!(TcpStream::connect(address).await.is_err(), "nobody listens any more");
}
