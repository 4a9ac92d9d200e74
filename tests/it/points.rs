//! Laws of points that stream clients follow: the water of each tick at each point, on time, and nothing queued.

use std::time::Duration;

use bytes::Bytes;
use serde_json::{Value, json};
use swellcast::engine::fields_of_points;
use swellcast::reference;
use swellcast::scene::preset;
use swellcast::server::Settings;
use swellcast::wire::{PointRecord, PointsHeader, read_points};
use tokio::net::TcpSocket;

use crate::served::{Client, Got, SMALL, Served};
use crate::support::scene;

fn points(id: u64, rate_hz: u32, points: &[[f64; 2]]) -> Value {
    json!({ "type": "points", "id": id, "rate_hz": rate_hz, "points": points })
}

async fn follow(client: &mut Client, message: &Value) -> Value {
    client.send(message).await;
    client.text("points_subscribed").await
}

/// The next message of points, frames of units apart.
async fn water(client: &mut Client) -> (PointsHeader, Vec<PointRecord>) {
    loop {
        let message: Bytes = client.frame().await;
        if message.starts_with(b"SWP1") {
            return read_points(&message).unwrap();
        }
    }
}

fn line(n: usize) -> Vec<[f64; 2]> {
    (0..n).map(|i| [i as f64 * 1.37, i as f64 * -0.73]).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_message_is_the_water_of_its_tick() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    let hello = client.text("hello").await;
    let at = line(5);
    let told = follow(&mut client, &points(9, 30, &at)).await;
    let from = told["from_tick"].as_u64().unwrap();
    assert_eq!(told, json!({ "type": "points_subscribed", "id": 9, "rate_hz": 30, "from_tick": from, "count": 5 }));
    let timeline = served.ocean.current().timeline;
    let mut next = from;
    for _ in 0..4 {
        let (header, records) = water(&mut client).await;
        assert_eq!((header.id, header.flags), (9, 7));
        // A busy machine passes over ticks, and the newest message replaces the one before.
        assert!(header.tick >= next && (header.tick - from) % 240 == 0, "{} is no tick after {next}", header.tick);
        next = header.tick + 240;
        assert_eq!(format!("{:016x}", header.epoch), hello["epoch"].as_str().unwrap());
        let (tick, sea) = (header.tick as i64, timeline.at(header.tick as i64));
        for (record, [x, z]) in records.iter().zip(&at) {
            let told = reference::probe(&sea, tick, *x, *z);
            assert!(f64::from(record.height - told.height as f32).abs() < 5e-3, "{record:?} is not {told:?}");
            let apart = |a: [f32; 3], b: [f64; 3]| (0..3).map(|i| (f64::from(a[i]) - b[i]).abs()).fold(0.0, f64::max);
            assert!(apart(record.normal, told.normal) < 0.02 && apart(record.velocity, told.velocity) < 0.03);
            assert!((f64::from(record.jacobian) - told.jacobian).abs() < 0.02 && record.residual < 1e-3);
            assert!(!record.folded);
        }
    }

    // Other points under another id, at another rate; then beside units; then none.
    let told = follow(&mut client, &points(10, 15, &at[..2])).await;
    let (mut header, mut records) = water(&mut client).await;
    while header.id == 9 {
        // What was on its way.
        (header, records) = water(&mut client).await;
    }
    let from = told["from_tick"].as_u64().unwrap();
    assert_eq!((header.id, records.len()), (10, 2));
    assert!(header.tick >= from && (header.tick - from) % 480 == 0, "{} of {from}", header.tick);
    let after = water(&mut client).await.0.tick;
    assert!(after > header.tick && (after - from) % 480 == 0, "{after} of {from}");
    client.subscribe(15, &["slopes"]).await;
    water(&mut client).await;
    assert_eq!(follow(&mut client, &points(11, 15, &[])).await["count"], 0);
    client.send(&json!({ "type": "subscribe", "id": 2, "rate_hz": 15, "units": [] })).await;
    client.text("subscribed").await;
    tokio::time::sleep(Duration::from_millis(2500)).await;
    let steps = served.ocean.counters().steps;
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert_eq!(served.ocean.counters().steps, steps, "nobody follows anything: no work");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_stream_says_what_a_probe_says_of_the_same_tick() {
    for scene in [scene(SMALL), preset("trochoid").unwrap()] {
        let served = Served::start(&scene, Settings::default()).await;
        let mut client = served.client().await;
        // More than one thread takes at a time, and of two clients.
        let at = line(700);
        follow(&mut client, &points(1, 15, &at)).await;
        let mut other = served.client().await;
        follow(&mut other, &points(2, 15, &at[300..310])).await;
        for (client, at) in [(&mut client, &at[..]), (&mut other, &at[300..310])] {
            let (header, records) = water(client).await;
            let asked = json!({ "points": at, "tick": header.tick });
            let path = format!("/v1/scenes/{}/probe", scene.name);
            let told = served.http("POST", &path, "", &asked.to_string()).await.json();
            let told = told["points"].as_array().unwrap();
            assert_eq!((records.len(), told.len()), (at.len(), at.len()));
            // The probe's digits end at a tenth of a micrometre, the stream's with an f32.
            let same =
                |a: f32, b: &Value| (f64::from(a) - b.as_f64().unwrap()).abs() < 1e-6 * (1.0 + f64::from(a.abs()));
            for (record, told) in records.iter().zip(told) {
                let vectors = (0..3).all(|i| {
                    same(record.normal[i], &told["normal"][i]) && same(record.velocity[i], &told["velocity"][i])
                });
                assert!(vectors && same(record.height, &told["height"]), "{record:?} is not {told}");
                assert!(same(record.jacobian, &told["jacobian"]) && told["folded"] == record.folded, "{told}");
            }
        }
        served.stop().await;
    }
    assert!(fields_of_points(&preset("trochoid").unwrap()).is_empty(), "no grid is made for points");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_most_points_fit_a_message_whatever_their_digits() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    let message = points(1, 15, &vec![[-1.234_567_890_123_456_7e-300; 2]; 2000]);
    assert!(message.to_string().len() > 100_000, "as long as numbers get");
    assert_eq!(follow(&mut client, &message).await["count"], 2000);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn points_are_made_once_with_what_tiles_need_and_end_with_their_client() {
    let bare = format!("{SMALL}[effects]\nvelocity = false\njacobian = false\nnormals = \"none\"\nfoam = false\n");
    let served = Served::start(&scene(&bare), Settings::default()).await;
    let mut tiles = served.client().await;
    tiles.subscribe(15, &["displacement"]).await;
    tiles.frame().await;
    let mut client = served.client().await;
    follow(&mut client, &points(1, 15, &line(3))).await;
    let (header, records) = water(&mut client).await;
    assert_eq!(header.flags, 0);
    assert!(records.iter().all(|r| r.normal == [0.0; 3] && r.velocity == [0.0; 3] && r.jacobian == 0.0));
    let before = served.ocean.counters();
    for _ in 0..5 {
        water(&mut client).await;
    }
    let after = served.ocean.counters();
    let transforms = after.work.transforms - before.work.transforms;
    assert_eq!(transforms, 3 * (after.steps - before.steps), "height and displacement serve both");
    drop((client, tiles));
    tokio::time::sleep(Duration::from_millis(2800)).await;
    let steps = served.ocean.counters().steps;
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert_eq!(served.ocean.counters().steps, steps);
    assert!(served.get("/metrics").await.body.contains("swellcast_live_points 0\n"));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn points_beyond_the_limits_are_refused_by_name() {
    let settings = Settings { live_points: 3000, ..Settings::default() };
    let served = Served::start(&scene(SMALL), settings).await;
    let (mut one, mut two) = (served.client().await, served.client().await);
    for (message, code, field) in [
        (points(1, 20, &line(1)), "invalid", "rate_hz"),
        (points(2, 15, &line(2001)), "invalid", "points"),
        (points(3, 15, &[[0.0, 1.5e9]]), "invalid", "points[0][1]"),
    ] {
        one.send(&message).await;
        let error = one.text("error").await;
        assert_eq!((&error["code"], &error["field"], &error["id"]), (&json!(code), &json!(field), &message["id"]));
    }
    assert_eq!(follow(&mut one, &points(4, 15, &line(2000))).await["count"], 2000);
    two.send(&points(5, 15, &line(1001))).await;
    let error = two.text("error").await;
    assert_eq!((&error["code"], &error["field"], &error["id"]), (&json!("unavailable"), &json!("points"), &json!(5)));
    assert_eq!(follow(&mut two, &points(6, 60, &line(1000))).await["count"], 1000);
    assert_eq!(water(&mut one).await.1.len(), 2000);
    assert_eq!(water(&mut two).await.1.len(), 1000);
    drop(one);
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert_eq!(follow(&mut two, &points(7, 15, &line(2000))).await["count"], 2000, "who leaves makes room");

    // Wishes without pause are refused, and the last good one goes on.
    let mut refusals = 0;
    for id in 100..160 {
        two.send(&points(id, 15, &line(1))).await;
        loop {
            match two.next().await {
                Got::Text(text) if text["type"] == "error" => refusals += 1,
                Got::Text(text) if text["type"] == "points_subscribed" => {}
                Got::Closed(code) => panic!("closed with {code}"),
                _ => continue,
            }
            break;
        }
    }
    assert!((20..=30).contains(&refusals), "{refusals} of 60 were refused");
    water(&mut two).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_does_not_read_gets_the_newest_and_nothing_is_queued() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    let mut client = Client::on(socket.connect(served.address).await.unwrap()).await;
    let told = follow(&mut client, &points(1, 60, &line(2000))).await;
    let from = told["from_tick"].as_u64().unwrap();
    // Four seconds are 19 MB of points: more than the sockets hold.
    tokio::time::sleep(Duration::from_secs(4)).await;
    let mut last = water(&mut client).await.0.tick;
    assert!((from..from + 7200).contains(&last), "the oldest that the sockets hold, {last} of {from}");
    for read in 1.. {
        let tick = water(&mut client).await.0.tick;
        assert!(tick > last && read < 220, "{read} messages of 240 were queued");
        if tick - last > 7200 {
            break;
        }
        last = tick;
    }
    served.stop().await;
}
