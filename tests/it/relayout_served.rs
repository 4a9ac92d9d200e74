//! A change of layout over real sockets: a client that stays connected sees the old cascades, both, then the new alone.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};
use swellcast::client::{Connection, Event, Footing, Patch, Playback, Point};
use swellcast::engine::Clock;
use swellcast::server::Settings;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

use crate::served::{Answer, Client, Got, PATIENCE, SMALL, Served, header};
use crate::support::scene;

const LAYOUT: &str = "/v1/scenes/small/layout";
const WIND: &str = "/v1/scenes/small/wind";
const SEA: &str = "/v1/scenes/small/sea";
const NEW: &str = r#"{"n":32,"patches_m":[45,12],"transition_s":1,"wind_range_mps":[4,12]}"#;
/// Ticks between the frames that the thin client asks for.
const INTERVAL: i64 = 480;
const GROUPS: [&str; 4] = ["displacement", "slopes", "derivatives", "foam"];

async fn subscribe(client: &mut Client, id: u32, cascades: &[u64]) -> Value {
    let unit = |cascade, group| json!({ "cascade": cascade, "level": 0, "class": "1mm", "group": group });
    let units: Vec<Value> = cascades.iter().flat_map(|c| GROUPS.map(|group| unit(c, group))).collect();
    client.send(&json!({ "type": "subscribe", "id": id, "rate_hz": 30, "units": units })).await;
    loop {
        let answer = client.text("subscribed").await;
        if answer["id"] == id {
            return answer;
        }
    }
}

fn indices(hello: &Value) -> Vec<u64> {
    hello["layout"]["cascades"].as_array().unwrap().iter().map(|c| c["index"].as_u64().unwrap()).collect()
}

#[track_caller]
fn conflict(answer: &Answer, kind: &str) {
    assert_eq!(answer.status, 409, "{answer:?}");
    assert_eq!(answer.json()["type"], format!("urn:swellcast:problem:{kind}"), "{answer:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_stays_sees_the_old_sea_both_and_then_the_new() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let (mut client, mut stubborn) = (served.client().await, served.client().await);
    let hello = client.text("hello").await;
    let first = &hello["layout"]["cascades"][0];
    assert_eq!((&first["index"], &first["from_tick"], &first["until_tick"]), (&json!(0), &json!(0), &Value::Null));
    subscribe(&mut client, 1, &[0]).await;
    subscribe(&mut stubborn, 1, &[0]).await;
    client.frame().await;

    let accepted = served.http("PUT", LAYOUT, "", NEW).await;
    assert_eq!(accepted.status, 202, "{accepted:?}");
    let from = accepted.json()["effective_tick"].as_u64().unwrap();
    // Both messages come in this order, on the same connection.
    let told = client.text("change").await;
    let what = json!({ "kind": "layout", "n": 32, "band_limit": 1.0 / 3.0, "finest_wavelength_m": 0.3,
        "patches_m": [45.0, 12.0], "wind_range_mps": [4.0, 12.0] });
    assert_eq!((&told["change"], &told["transition_ticks"]), (&what, &json!(7200)));
    let further = client.text("hello").await;
    assert_eq!((&further["epoch"], &further["sequence"]), (&hello["epoch"], &json!(1)));
    assert_eq!(indices(&further), [0, 8, 9]);
    let (old, new) = (&further["layout"]["cascades"][0], &further["layout"]["cascades"][2]);
    assert_eq!((&new["from_tick"], &new["until_tick"], &new["patch_m"]), (&json!(from), &Value::Null, &json!(12.0)));
    let until = old["until_tick"].as_u64().unwrap();
    assert!((from + 7200 + 1440..from + 7200 + 1440 + 480).contains(&until), "{from} to {until}");

    let answer = subscribe(&mut client, 2, &[0, 8, 9]).await;
    assert_eq!(answer["units"].as_array().unwrap().len(), 12, "of all of them at once");
    let mut seen: BTreeMap<u64, BTreeSet<u8>> = BTreeMap::new();
    let mut foam = BTreeSet::new();
    while seen.keys().next_back().is_none_or(|tick| *tick < until + 3600) {
        let header = header(&client.frame().await);
        assert_eq!(u64::from(header.layout), u64::from(header.tick >= from));
        if header.group == Group::Displacement.id() {
            seen.entry(header.tick).or_default().insert(header.cascade);
        } else if header.group == Group::Foam.id() {
            foam.insert(header.cascade);
        }
    }
    seen.pop_last();
    for (tick, cascades) in &seen {
        let want: &[u8] = match *tick {
            tick if tick < from => &[0],
            tick if tick < until => &[0, 8, 9],
            _ => &[8, 9],
        };
        assert!(cascades.iter().eq(want), "{cascades:?} at {tick}, from {from} until {until}");
    }
    let gaps: Vec<u64> = seen.keys().zip(seen.keys().skip(1)).map(|(a, b)| (b - a) / 240 - 1).collect();
    let skipped = served.ocean.counters().skipped_frames;
    assert!(gaps.iter().sum::<u64>() <= 2 * skipped, "no gap: {seen:?}, {skipped} skipped");
    assert!(seen.keys().filter(|tick| (from..until).contains(tick)).count() > 20);
    assert!(foam.contains(&8), "foam of the new cascades is warm when they begin");

    // One that asks for what has ended gets what there is; one that joins now is told of nothing else.
    let answer = subscribe(&mut client, 3, &[0, 8]).await;
    assert!(answer["units"].as_array().unwrap().iter().all(|unit| unit["cascade"] == 8), "{answer}");
    let late = served.client().await.text("hello").await;
    assert_eq!((indices(&late), &late["layout"]["generation"]), (vec![8, 9], &json!(1)));
    let mut newest = 0;
    while let Ok(Got::Frame(frame)) = tokio::time::timeout(std::time::Duration::from_millis(300), stubborn.next()).await
    {
        newest = newest.max(header(&frame).tick);
    }
    assert!(newest < until, "who asked for the old alone gets no more");
    // What has ended doesn't count against the limit of live units, even if nobody says that he needs it no more.
    client.text("status").await;
    client.text("status").await;
    assert_eq!(served.ocean.demand().len(), 4);
    // The rest of what the change set.
    let state = served.get("/v1/scenes/small").await.json();
    assert_eq!((&state["state"]["wind_range_mps"], &state["layout"]["generation"]), (&json!([4.0, 12.0]), &json!(1)));
    assert_eq!(state["state"]["cascades"]["patches_m"], json!([45.0, 12.0]));
    assert_eq!(client.text("status").await["wind_range_mps"], json!([4.0, 12.0]));
    let strong = served.http("PUT", WIND, "", r#"{"speed_mps":15,"direction_from_deg":0}"#).await;
    assert_eq!((strong.status, strong.json()["field"].as_str()), (422, Some("speed_mps")), "{strong:?}");
    conflict(&served.http("PUT", LAYOUT, "", r#"{"n":32}"#).await, "layout-under-way");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_layout_that_can_not_be_is_refused_by_name() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    for (body, field) in [
        (r#"{"n":33}"#, "n"),
        (r#"{"n":"32"}"#, "n"),
        (r#"{"n":-1}"#, "n"),
        (r#"{"n":1e9}"#, "n"),
        (r#"{"n":2048,"band_limit":1}"#, "n"),
        (r#"{"band_limit":2}"#, "band_limit"),
        (r#"{"finest_wavelength_m":0}"#, "finest_wavelength_m"),
        (r#"{"patches_m":7}"#, "patches_m"),
        (r#"{"patches_m":[1,null]}"#, "patches_m"),
        (r#"{"patches_m":[10,9]}"#, "patches_m"),
        (r#"{"patches_m":[1e9]}"#, "patches_m"),
        (r#"{"wind_range_mps":[1]}"#, "wind_range_mps"),
        (r#"{"wind_range_mps":[9,12]}"#, "wind_range_mps"),
        (r#"{"wind_range_mps":[8,7]}"#, "wind_range_mps"),
        (r#"{"wind_range_mps":[0,101]}"#, "wind_range_mps"),
        (r#"{"transition_s":0.9}"#, "transition_s"),
        (r#"{"transition_s":3601}"#, "transition_s"),
        (r#"{"effective_tick":7200}"#, "effective_tick"),
        (r#"{"patch_m":[100]}"#, "patch_m"),
    ] {
        let answer = served.http("PUT", LAYOUT, "", body).await;
        assert_eq!((answer.status, answer.json()["field"].as_str()), (422, Some(field)), "{body}: {answer:?}");
    }
    for (body, field) in [(r#"{"gravity":0.05}"#, "gravity"), (r#"{"gravity":null}"#, "gravity"), ("{}", "depth_m")] {
        let answer = served.http("PATCH", SEA, "", body).await;
        assert_eq!((answer.status, answer.json()["field"].as_str()), (422, Some(field)), "{body}: {answer:?}");
    }
    assert_eq!(served.get("/v1/scenes/small/log").await.json()["changes"], json!([]), "a refusal changes nothing");
    served.stop().await;
    let swell = scene("name = \"small\"\n[[swell]]\nhs_m = 1\n[cascades]\nn = 32\npatches_m = [200]\n");
    let served = Served::start(&swell, Settings::default()).await;
    let answer = served.http("PUT", LAYOUT, "", NEW).await;
    assert_eq!((answer.status, answer.json()["field"].as_str()), (422, Some("wind_range_mps")), "no wind: {answer:?}");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn layouts_and_winds_that_were_accepted_stand() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let wind = |speed: f64, seconds: f64| {
        json!({ "speed_mps": speed, "direction_from_deg": 0, "in_seconds": seconds, "transition_s": 0 }).to_string()
    };
    assert_eq!(served.http("PUT", WIND, "", &wind(15.0, 100.0)).await.status, 202);
    let later = r#"{"n":32,"patches_m":[45],"transition_s":1,"in_seconds":60,"wind_range_mps":[4,12]}"#;
    conflict(&served.http("PUT", LAYOUT, "", later).await, "against-accepted");
    let wide = later.replace("[4,12]", "[4,16]");
    assert_eq!(served.http("PUT", LAYOUT, "", &wide).await.status, 202);
    conflict(&served.http("PUT", LAYOUT, "", r#"{"n":32}"#).await, "layout-under-way");
    conflict(&served.http("PUT", WIND, "", &wind(18.0, 30.0)).await, "against-accepted");
    assert_eq!(served.http("PUT", WIND, "", &wind(16.0, 90.0)).await.status, 202);
    assert_eq!(served.http("PUT", WIND, "", &wind(18.0, 90.0)).await.status, 422);
    let gravity = served.http("PATCH", SEA, "", r#"{"gravity":3.7,"in_seconds":10}"#).await;
    assert_eq!(gravity.status, 202, "{gravity:?}");
    let log = served.get("/v1/scenes/small/log").await.json();
    assert_eq!(log["changes"][3]["change"], json!({ "kind": "water", "gravity": 3.7 }));
    served.stop().await;
}

/// The client of the house: at every moment it has water, which goes on from the old cascades to the new.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_thin_client_goes_from_one_layout_to_the_next_without_a_gap() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let clock = Clock::start(Clock::unix_now_ns());
    let url = format!("http://{}", served.address);
    let mut connection = Connection::open(&url, move || clock.now_us()).await.unwrap();
    let (mut playback, mut hellos, mut asked) = (Playback::default(), Vec::new(), false);
    let mut heights = Vec::new();
    let going = async {
        loop {
            match connection.next().await {
                Event::Hello(hello) => {
                    let unit = |c: &swellcast::wire::HelloCascade| UnitName {
                        cascade: c.index,
                        level: 0,
                        class: ErrorClass::HalfMillimetre,
                        group: Group::Displacement,
                        codec: Codec::Rans,
                    };
                    connection.subscribe(15, hello.layout.cascades.iter().map(unit).collect(), false).await;
                    hellos.push(*hello);
                }
                Event::Subscribed(subscribed) => {
                    let units: Vec<_> = subscribed.units.iter().map(|granted| granted.unit).collect();
                    playback = std::mem::take(&mut playback).renewed(hellos.last().unwrap(), &units);
                }
                Event::Frame(frame, _) => {
                    // Seen two frames behind the newest by the frames' own times: how busy the machine is plays no part.
                    let seen = (frame.header.tick as i64 - 2 * INTERVAL) * 1250 / 9;
                    playback.insert(frame).unwrap();
                    if seen <= heights.last().map_or(0, |(at, _, _)| *at) {
                        continue;
                    }
                    let patches = Patch::all(&playback, &hellos.last().unwrap().layout, seen);
                    let held = playback.keys().any(|key| playback.footing(key, seen) == Some(Footing::Between));
                    if held || !heights.is_empty() {
                        heights.push((seen, held, Point::at(&patches, 3.0, 4.0).displacement[1]));
                    }
                    if heights.len() == 30 && !asked {
                        asked = true;
                        assert_eq!(served.http("PUT", LAYOUT, "", NEW).await.status, 202);
                    }
                    let until = hellos.last().unwrap().layout.cascades[0].until_tick;
                    if until.is_some_and(|until| seen * 9 / 1250 > until + 3600) {
                        return;
                    }
                    playback.forget_before(seen);
                }
                Event::Closed(closed) => panic!("{closed}"),
                _ => {}
            }
        }
    };
    tokio::time::timeout(PATIENCE, going).await.unwrap();
    assert_eq!(hellos.len(), 2);
    assert!(heights.iter().all(|(_, held, _)| *held), "there is water at every moment");
    // 8 m/s of wind moves the water by less than 3 m/s; a scramble would be a jump of decimetres in no time.
    for ((at, _, from), (then, _, to)) in heights.iter().zip(&heights[1..]) {
        let seconds = (then - at) as f32 / 1e6;
        assert!((to - from).abs() < 0.02 + 3.0 * seconds, "{from} m to {to} m in {seconds} s");
    }
    assert!(playback.keys().all(|key| key.cascade >= 8), "what ended is let go of");
    served.stop().await;
}
