//! Laws against clients that are broken, slow or hostile: each ends by itself, alone, and is told why.

use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde_json::json;
use swellcast::server::Settings;
use swellcast::wire::MAX_MESSAGE_BYTES;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio_websockets::Message;

use crate::served::{ALL, Client, Got, SMALL, Served, frames, unit};
use crate::support::scene;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn wrong_messages_end_with_the_code_that_says_why() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut watcher = served.client().await;
    watcher.subscribe(15, &["displacement"]).await;

    let mut client = served.client().await;
    client.stream.send(Message::binary(vec![0; 8])).await.unwrap();
    assert_eq!(client.closed().await, 1003);

    let mut client = served.client().await;
    client.stream.send(Message::text("x".repeat(MAX_MESSAGE_BYTES + 1))).await.unwrap();
    assert_eq!(client.closed().await, 1009);

    let mut client = served.client().await;
    for _ in 0..15 {
        client.stream.send(Message::text("{")).await.unwrap();
        assert_eq!(client.text("error").await["code"], "malformed");
    }
    client.send(&json!({ "type": "nonsense" })).await;
    assert_eq!(client.text("error").await["code"], "unknown_type");
    assert_eq!(client.closed().await, 1008);

    // Bytes that are no WebSocket, and texts that are no UTF-8, on the raw connection: the last one is cut short by an
    // empty frame.
    let (noise, broken) = ([0xff, 0xff, 0, 0, 0, 0, 0, 0], [0x81, 0x82, 0, 0, 0, 0, 0xff, 0xff]);
    let cut = [0x01, 0x81, 0, 0, 0, 0, 0xce, 0x80, 0x80, 0, 0, 0, 0];
    for (bytes, code) in [(&noise[..], 1002), (&broken, 1007), (&cut, 1007)] {
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
async fn every_invalid_vector_gets_a_clean_error_from_a_live_server() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/proto/vectors/invalid");
    let messages = std::fs::read_to_string(format!("{folder}/messages.json")).unwrap();
    let messages: Vec<serde_json::Value> = serde_json::from_str(&messages).unwrap();
    assert!(messages.len() > 20);
    for message in messages {
        let text = message["text"].as_str().unwrap();
        // A client each, so that none is closed for sending too many.
        let mut client = served.client().await;
        client.stream.send(Message::text(text.to_owned())).await.unwrap();
        if text.len() > MAX_MESSAGE_BYTES {
            assert_eq!(client.closed().await, 1009, "{message}");
            continue;
        }
        let error = client.text("error").await;
        assert_eq!((&error["code"], &error["field"]), (&message["code"], &message["field"]), "{message}: {error}");
        // The connection goes on.
        client.subscribe(15, &["slopes"]).await;
    }
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "bin") {
            let mut bytes = std::fs::read(&path).unwrap();
            bytes.truncate(4096);
            let mut client = served.client().await;
            client.stream.send(Message::binary(bytes)).await.unwrap();
            assert_eq!(client.closed().await, 1003, "{}", path.display());
        }
    }
    assert_eq!(served.get("/readyz").await.status, 200);
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
async fn a_flood_of_subscriptions_is_refused_and_the_last_good_one_stays() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    let (mut granted, mut refused) = (0, 0);
    for id in 0..60 {
        let units = if id % 2 == 0 { vec![unit(0, "slopes")] } else { vec![unit(0, "displacement")] };
        client.send(&json!({ "type": "subscribe", "id": id, "rate_hz": 30, "units": units })).await;
        loop {
            match client.next().await {
                Got::Text(text) if text["type"] == "subscribed" => granted += 1,
                Got::Text(text) if text["type"] == "error" => {
                    assert_eq!((&text["code"], &text["id"]), (&json!("unavailable"), &json!(id)));
                    refused += 1;
                }
                Got::Closed(code) => panic!("closed with {code}"),
                _ => continue,
            }
            break;
        }
    }
    assert!(granted >= 32 && refused > 0, "{granted} granted, {refused} refused");
    frames(&mut client, 3).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_flood_of_messages_that_are_each_right_ends_alone() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut watcher = served.client().await;
    watcher.subscribe(15, &["displacement"]).await;
    let mut client = served.client().await;
    client.text("hello").await;
    let mut answered = 0;
    // One after the other, so that no answer waits.
    let code = loop {
        let time = json!({ "type": "time", "t0": answered }).to_string();
        if client.stream.send(Message::text(time)).await.is_err() {
            break client.closed().await;
        }
        match client.next().await {
            Got::Text(text) if text["type"] == "time" => answered += 1,
            Got::Closed(code) => break code,
            _ => {}
        }
        assert!(answered < 20_000);
    };
    assert_eq!(code, 1008);
    assert!(answered >= 250, "{answered}: a burst is allowed");
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
        let mut client = Client::on(socket.connect(served.address).await.unwrap()).await;
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
    // Who wakes now still reads why; those that were let go of first may be too late.
    let mut codes = Vec::new();
    for mut client in stalled {
        codes.push(client.closed().await);
    }
    assert!(codes.contains(&4001), "{codes:?}");
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
    // The server sees the end of the second in its own time.
    while !served.raw(b"GET /livez HTTP/1.1\r\nconnection: close\r\n\r\n").await.starts_with("HTTP/1.1 200") {
        first.text("status").await;
    }
    served.stop().await;
}
