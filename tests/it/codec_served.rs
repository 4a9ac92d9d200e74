//! Predicted frames over real sockets: whoever joins when reads every frame, all see the same water, and who can't take
//! all is given less.

use std::collections::BTreeMap;

use serde_json::json;
use swellcast::server::Settings;
use swellcast::tile::{DecodeError, DecodedFrame, Decoder};
use swellcast::wire::{BETWEEN, FLAG_KEY, layer_of, split};

use crate::served::{Client, Got, SMALL, Served, header};
use crate::support::scene;

async fn subscribe(client: &mut Client, rate_hz: u32, codec: &str, keys: bool) -> u64 {
    let unit = |group| json!({ "cascade": 0, "level": 0, "class": "1mm", "group": group, "codec": codec });
    let units = [unit("displacement"), unit("slopes")];
    client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": rate_hz, "units": units, "keys": keys })).await;
    client.text("subscribed").await["from_tick"].as_u64().unwrap()
}

/// Frames by tick and group, all of which can be read.
async fn read(client: &mut Client, decoder: &mut Decoder, n: usize) -> BTreeMap<(u64, u8), DecodedFrame> {
    let mut frames = BTreeMap::new();
    while frames.len() < n {
        let decoded = decoder.decode(&client.frame().await).expect("all that comes can be read");
        let key = (decoded.header.tick, decoded.header.group);
        assert!(frames.insert(key, decoded).is_none(), "{key:?} comes once");
    }
    frames
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whoever_joins_when_reads_every_frame_and_sees_the_same_water() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut clients = Vec::new();
    for (rate, codec) in [(60, "rans"), (30, "rans"), (15, "deflate"), (30, "i16")] {
        let (mut client, mut decoder) = (served.client().await, Decoder::new(1 << 16));
        let from_tick = subscribe(&mut client, rate, codec, false).await;
        let first = decoder.decode(&client.frame().await).unwrap().header;
        assert!(first.flags & FLAG_KEY != 0 && (codec == "i16" || first.tick % 480 == 0), "begins with a key frame");
        assert!(first.tick >= from_tick);
        clients.push((client, decoder, rate as usize));
        // The next joins in the middle of it.
        tokio::time::sleep(std::time::Duration::from_millis(130)).await;
    }
    let mut seen = Vec::new();
    for (client, decoder, rate) in &mut clients {
        seen.push(read(client, decoder, 6 * *rate).await);
    }
    let all = &seen[0];
    assert!(all.values().any(|frame| frame.header.depth == 3) && all.values().any(|f| f.header.depth == BETWEEN));
    for other in &seen[1..] {
        let common: Vec<_> = other.keys().filter(|key| all.contains_key(key)).collect();
        assert!(common.len() > 20, "{} in common", common.len());
        for key in common {
            assert_eq!(all[key].planes, other[key].planes, "{key:?}");
        }
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn key_frames_come_each_second_to_who_asks_and_to_nobody_else() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let (mut recorder, mut viewer) = (served.client().await, served.client().await);
    subscribe(&mut viewer, 30, "rans", false).await;
    subscribe(&mut recorder, 30, "rans", true).await;
    for (client, asked) in [(&mut recorder, true), (&mut viewer, false)] {
        let frames = read(client, &mut Decoder::new(1 << 16), 150).await;
        let first = frames.keys().next().unwrap().0;
        let later = frames.values().filter(|frame| frame.header.tick > first + 960);
        let keys: Vec<u64> = later.filter(|frame| frame.header.depth == 0).map(|frame| frame.header.tick).collect();
        let on_seconds = keys.iter().filter(|tick| **tick % 7200 == 0).count();
        // A busy machine passes over ticks: whoever lacks one begins anew.
        let skipped = served.ocean.counters().skipped_frames as usize;
        assert!(keys.len() - on_seconds <= skipped, "{keys:?}, {skipped} ticks skipped");
        assert!((on_seconds > 0) == asked || (!asked && skipped > 0), "{keys:?}, {skipped} ticks skipped");
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_has_lost_its_place_begins_anew() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    subscribe(&mut client, 30, "rans", false).await;
    read(&mut client, &mut Decoder::new(1 << 16), 30).await;
    let mut decoder = Decoder::new(1 << 16);
    assert_eq!(decoder.decode(&client.frame().await), Err(DecodeError::Missing));
    client.send(&json!({ "type": "report", "tick": 0, "decode_ms": 1, "buffer_ms": 100, "lost": true })).await;
    let mut refused = 0;
    while decoder.decode(&client.frame().await).is_err() {
        refused += 1;
    }
    assert!(refused < 20, "{refused} frames until it can read again");
    read(&mut client, &mut decoder, 30).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_falls_behind_is_given_fewer_frames_and_then_coarser_ones() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    subscribe(&mut client, 30, "rans", false).await;
    let mut decoder = Decoder::new(1 << 16);
    let (mut told, mut after) = (Vec::new(), Vec::new());
    let mut reports = tokio::time::interval(std::time::Duration::from_millis(500));
    let going = async {
        while after.len() < 20 {
            tokio::select! {
                _ = reports.tick() => {
                    client.send(&json!({ "type": "report", "tick": 0, "decode_ms": 1, "buffer_ms": -40 })).await;
                }
                got = client.next() => match got {
                    Got::Text(text) if text["type"] == "quality" => {
                        told.push((text["rate_hz"].as_u64().unwrap(), text["coarser"].as_u64().unwrap()));
                    }
                    Got::Frame(frame) => {
                        let decoded = decoder.decode(&frame).expect("all that comes can be read");
                        if told.last() == Some(&(15, 2)) && decoded.header.level == 2 {
                            after.push(decoded.header);
                        }
                    }
                    _ => {}
                }
            }
        }
    };
    tokio::time::timeout(crate::served::PATIENCE, going).await.unwrap();
    assert_eq!(told, [(15, 0), (15, 1), (15, 2)]);
    assert!(after.iter().all(|header| layer_of(header.tick as i64) == 0 && header.level_n == header.n));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_joiner_changes_no_byte_of_those_who_follow() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let (mut a, mut b) = (served.client().await, served.client().await);
    subscribe(&mut a, 30, "rans", false).await;
    subscribe(&mut b, 30, "rans", false).await;
    let mut streams = [BTreeMap::new(), BTreeMap::new()];
    for round in 0..120 {
        for (client, stream) in [&mut a, &mut b].into_iter().zip(&mut streams) {
            let frame = client.frame().await;
            split(&frame).unwrap();
            stream.insert((header(&frame).tick, header(&frame).group), frame);
        }
        if round == 50 {
            let mut late = served.client().await;
            subscribe(&mut late, 30, "rans", false).await;
            read(&mut late, &mut Decoder::new(1 << 16), 10).await;
        }
    }
    let [a, b] = streams;
    let first = [&a, &b].map(|frames| frames.keys().next().unwrap().0).into_iter().max().unwrap();
    let common: Vec<_> = a.keys().filter(|key| key.0 > first + 4 * 480 && b.contains_key(key)).collect();
    assert!(common.len() > 60, "{}", common.len());
    assert!(common.iter().all(|key| a[key] == b[key] && header(&a[key]).depth > 0), "and none is a key frame");
    served.stop().await;
}
