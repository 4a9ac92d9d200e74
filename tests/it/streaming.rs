//! Laws of the stream: everybody gets the same bytes, and nobody can spoil it for others.

use std::collections::BTreeMap;

use bytes::Bytes;
use serde_json::{Value, json};
use swellcast::server::Settings;
use tokio::net::TcpStream;

use crate::served::{ALL, Got, SMALL, Served, frames, header, unit};
use crate::support::scene;

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
    assert_eq!(hello["limits"], json!({ "message_bytes": 131_072, "units": 64, "live_units": 64, "points": 2000 }));
    let subscribed = a.subscribe(30, &ALL).await;
    assert_eq!(subscribed["units"].as_array().unwrap().len(), 3);
    b.subscribe(30, &ALL).await;
    let (of_a, of_b) = tokio::join!(frames(&mut a, 60), frames(&mut b, 60));
    same_where_both(&of_a, &of_b, 50);
    let from = subscribed["from_tick"].as_u64().unwrap();
    let first = of_a.keys().next().unwrap().0;
    let skipped = served.ocean.counters().skipped_frames;
    assert!((from..=from + 240 * skipped).contains(&first), "{first} is the tick that was announced, {from}");
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
        let skipped = served.ocean.counters().skipped_frames;
        assert!(gaps as u64 <= skipped, "skips are for machines that are too slow: {ticks:?}");
    }
    same_where_both(&of_slow, &of_fast, 6);
    // Another rate, another unit: what goes on flows without a gap.
    let last = of_fast.keys().last().unwrap().0;
    fast.send(&json!({ "type": "subscribe", "id": 2, "rate_hz": 60,
        "units": [unit(0, "displacement"), unit(0, "slopes")] }))
        .await;
    let more = frames(&mut fast, 24).await;
    let displacement: Vec<u64> = more.keys().filter(|(_, group)| *group == 0).map(|(tick, _)| *tick).collect();
    let skipped = served.ocean.counters().skipped_frames;
    assert!((last + 120..=last + 120 * (1 + skipped)).contains(&displacement[0]), "{last}, {displacement:?}");
    assert!(more.keys().any(|(_, group)| *group == 1));
    // None at all: the flow stops.
    fast.send(&json!({ "type": "subscribe", "id": 3, "rate_hz": 60, "units": [] })).await;
    while fast.text("subscribed").await["id"] != 3 {}
    slow.send(&json!({ "type": "subscribe", "id": 3, "rate_hz": 15, "units": [] })).await;
    slow.text("subscribed").await;
    // What nobody wants any more is made for two seconds still.
    for _ in 0..4 {
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
    let mut unknown = unit(0, "slopes");
    unknown["class"] = json!("2mm");
    client.send(&ask(15, vec![unknown])).await;
    let error = client.text("error").await;
    assert_eq!((&error["field"], &error["id"]), (&json!("units[0].class"), &json!(77)));
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
async fn a_change_is_told_to_all_and_shows_in_the_frames_of_its_tick() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let (mut a, mut b) = (served.client().await, served.client().await);
    a.subscribe(30, &["displacement"]).await;
    b.subscribe(60, &["displacement"]).await;
    let body = r#"{"speed_mps":15,"direction_from_deg":10,"in_seconds":2,"transition_s":0.5}"#;
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
async fn a_server_that_shuts_down_tells_its_clients() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let mut client = served.client().await;
    client.subscribe(30, &["displacement"]).await;
    let address = served.address;
    let (code, ()) = tokio::join!(client.closed(), served.stop());
    assert_eq!(code, 1001);
    assert!(TcpStream::connect(address).await.is_err(), "nobody listens any more");
}
