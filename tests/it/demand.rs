//! The server computes what its clients name, and nothing else: counted in the running server.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytes::Bytes;
use serde_json::{Value, json};
use swellcast::backend::Cpu;
use swellcast::engine::{Stepper, Work};
use swellcast::plan::Demand;
use swellcast::server::Settings;
use swellcast::tile::SentFrame;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName, split};

use crate::served::{Client, Served, header};
use crate::support::scene;

/// Three cascades of 32 x 32.
const THREE: &str =
    "name = \"three\"\n[wind]\nspeed_mps = 8\nrange_mps = [2.0, 20.0]\n[cascades]\nn = 32\npatches_m = [300, 60, 13]\n";

fn units(cascades: &[u8], level: u8, groups: &[Group]) -> Value {
    let unit = |cascade: &u8, group: &Group| json!({ "cascade": cascade, "level": level, "class": "1mm", "group": group.name() });
    cascades.iter().flat_map(|cascade| groups.iter().map(move |group| unit(cascade, group))).collect()
}

/// Transforms and samples of a frame while the client has this subscription; foam is warm, nothing else lingers.
async fn cost(served: &Served, client: &mut Client, units: &Value) -> Work {
    client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 30, "units": units })).await;
    client.text("subscribed").await;
    // Until what was wanted before is let go of.
    for _ in 0..4 {
        client.text("status").await;
    }
    for _ in 0..20 {
        let before = served.ocean.counters();
        for _ in 0..2 {
            client.text("status").await;
        }
        let after = served.ocean.counters();
        let steps = after.steps - before.steps;
        let (transforms, samples) =
            (after.work.transforms - before.work.transforms, after.work.samples - before.work.samples);
        if steps == 0 {
            return Work { transforms, samples };
        }
        // A skipped frame leaves a step of foam to be run by itself.
        if after.skipped_frames == before.skipped_frames && transforms % steps == 0 && samples % steps == 0 {
            return Work { transforms: transforms / steps, samples: samples / steps };
        }
    }
    panic!("no two seconds without a skipped frame");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_frame_costs_what_is_asked_of_it() {
    use Group::{Derivatives, Displacement, Foam, Height, Slopes};
    let served = Served::start(&scene(THREE), Settings::default()).await;
    let mut client = served.client().await;
    let all = [0, 1, 2];
    let waves: Vec<Group> = Group::ALL.into_iter().filter(|group| *group != Foam).collect();
    let mut costs = BTreeMap::new();
    for (name, wanted, fields, samples_a_field) in [
        ("everything", units(&all, 0, &Group::ALL), 3 * 11, 32 * 32),
        ("nobody", json!([]), 0, 0),
        ("height only", units(&all, 0, &[Height]), 3, 32 * 32),
        ("height and chop", units(&all, 0, &[Displacement]), 3 * 3, 32 * 32),
        ("displacement and normals", units(&all, 0, &[Displacement, Slopes, Derivatives]), 3 * 8, 32 * 32),
        ("everything at half resolution", units(&all, 1, &waves), 3 * 11, 16 * 16),
        ("one cascade of three", units(&[1], 0, &Group::ALL), 11, 32 * 32),
    ] {
        let cost = cost(&served, &mut client, &wanted).await;
        println!("{name}: {cost:?}");
        assert_eq!(cost, Work { transforms: fields, samples: fields * samples_a_field }, "{name}");
        costs.insert(name, cost);
    }
    let all = costs["everything"];
    assert!(6 * costs["height only"].samples <= all.samples);
    assert!(3 * costs["everything at half resolution"].samples <= all.samples);
    assert_eq!(costs["nobody"], Work::default());
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_unit_comes_at_its_own_rate_within_what_the_scene_allows() {
    let limits = "\
        [[detail]]\ncascade = 2\ngroup = \"displacement\"\nfinest_level = 1\nrate_hz = 15\n\
        [[detail]]\ncascade = 1\ngroup = \"foam\"\nrate_hz = 0\n";
    let served = Served::start(&scene(&format!("{THREE}{limits}")), Settings::default()).await;
    let mut client = served.client().await;
    let hello = client.text("hello").await;
    let detail = |cascade: usize| hello["layout"]["cascades"][cascade]["detail"].clone();
    assert_eq!(detail(2), json!([{ "group": "displacement", "finest_level": 1, "rate_hz": 15 }]));
    assert_eq!(detail(0), Value::Null);

    let unit = |cascade: u8, level: u8, group: &str, rate: Option<u32>| {
        let mut unit = json!({ "cascade": cascade, "level": level, "class": "1mm", "group": group });
        if let Some(rate) = rate {
            unit["rate_hz"] = json!(rate);
        }
        unit
    };
    let mut ask = async |units: Value, answer: &str| {
        client.send(&json!({ "type": "subscribe", "id": 5, "rate_hz": 30, "units": units })).await;
        client.text(answer).await
    };
    for (wrong, field, code) in [
        (unit(0, 0, "slopes", Some(25)), "units[0].rate_hz", "invalid"),
        (unit(2, 0, "displacement", None), "units[0].level", "invalid"),
        (unit(2, 1, "displacement", Some(30)), "units[0].rate_hz", "invalid"),
        (unit(1, 0, "foam", None), "units[0].group", "invalid"),
    ] {
        let refusal = ask(json!([wrong]), "error").await;
        assert_eq!((&refusal["field"], &refusal["code"]), (&json!(field), &json!(code)), "{refusal}");
    }
    // Who names no rate for it gets the highest that there is.
    let wanted = json!([unit(2, 1, "displacement", None), unit(0, 0, "slopes", Some(60)), unit(0, 0, "height", None),]);
    let answer = ask(wanted, "subscribed").await;
    let rates: Vec<&Value> = answer["units"].as_array().unwrap().iter().map(|unit| &unit["rate_hz"]).collect();
    assert_eq!(rates, [&json!(15), &json!(60), &Value::Null]);
    let mut ticks: BTreeMap<(u8, u8), Vec<u64>> = BTreeMap::new();
    for _ in 0..70 {
        let header = header(&client.frame().await);
        ticks.entry((header.cascade, header.group)).or_default().push(header.tick);
    }
    for (unit, interval) in [((2, Group::Displacement), 480), ((0, Group::Slopes), 120), ((0, Group::Height), 240)] {
        let ticks = &ticks[&(unit.0, unit.1.id())];
        let gaps = ticks.windows(2).filter(|pair| pair[1] - pair[0] != interval).count() as u64;
        assert!(ticks.iter().all(|tick| tick % interval == 0), "{unit:?} at {ticks:?}");
        assert!(gaps <= served.ocean.counters().skipped_frames, "{unit:?} at {ticks:?}");
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_limit_finer_than_a_cascade_has_levels_leaves_the_coarsest() {
    let limit = "[[detail]]\ncascade = 0\ngroup = \"slopes\"\nfinest_level = 7\n";
    let served = Served::start(&scene(&format!("{THREE}{limit}")), Settings::default()).await;
    let mut client = served.client().await;
    let first = client.text("hello").await["layout"]["cascades"][0].clone();
    let coarsest = first["levels"].as_u64().unwrap() - 1;
    assert_eq!(first["detail"], json!([{ "group": "slopes", "finest_level": coarsest }]));
    let units = units(&[0], coarsest as u8, &[Group::Slopes]);
    client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 15, "units": units })).await;
    client.text("subscribed").await;
    assert_eq!(u64::from(header(&client.frame().await).level), coarsest);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn effects_that_a_scene_switches_off_can_not_be_had() {
    for (effects, gone) in [
        ("normals = \"none\"", &["derivatives", "stretch", "normals"][..]),
        ("normals = \"diagonal\"", &["derivatives"]),
        ("normals = \"sobel\"\nslopes = false", &["slopes", "derivatives", "stretch"]),
        ("jacobian = false\nvelocity = false\nfoam = false", &["jacobian", "velocity", "foam"]),
    ] {
        let served = Served::start(&scene(&format!("{THREE}[effects]\n{effects}\n")), Settings::default()).await;
        let mut client = served.client().await;
        let hello = client.text("hello").await;
        let had: Vec<&str> = hello["groups"].as_array().unwrap().iter().map(|g| g["name"].as_str().unwrap()).collect();
        for group in Group::ALL {
            let there = !gone.contains(&group.name());
            assert_eq!(had.contains(&group.name()), there, "{} with {effects}", group.name());
            let units = units(&[0], 0, &[group]);
            client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 15, "units": units })).await;
            let answer = client.text(if there { "subscribed" } else { "error" }).await;
            assert!(there || answer["field"] == "units[0].group", "{answer}");
        }
        served.stop().await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whoever_joins_an_idle_sea_gets_the_foam_of_one_that_never_rested() {
    let windy = THREE.replace("speed_mps = 8", "speed_mps = 18");
    let served = Served::start(&scene(&windy), Settings::default()).await;
    let mut client = served.client().await;
    assert_eq!(served.ocean.counters().work, Work::default(), "nobody has asked for anything");
    let wanted = units(&[0, 1, 2], 0, &[Group::Foam]);
    client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 15, "units": wanted })).await;
    let mut frames: BTreeMap<u64, BTreeMap<u8, Bytes>> = BTreeMap::new();
    while frames.len() < 8 {
        let frame = client.frame().await;
        let header = header(&frame);
        frames.entry(header.tick).or_default().insert(header.cascade, frame);
    }
    let timeline = served.ocean.current().timeline;
    let epoch = header(frames.values().next().unwrap().values().next().unwrap()).epoch;
    let unit =
        |cascade| UnitName { cascade, level: 0, class: ErrorClass::Millimetre, group: Group::Foam, codec: Codec::I16 };
    let demand: Demand = [0, 1, 2].map(|cascade| (unit(cascade), 480)).into();
    let mut old = Stepper::new(Box::new(Cpu::new(Some(1))), Arc::clone(&timeline), epoch);
    old.set_demand(&demand);
    let first = *frames.keys().next().unwrap() as i64;
    let mut covered = 0;
    for tick in (first - 30 * 7200..).step_by(480).take_while(|tick| *tick <= *frames.keys().last().unwrap() as i64) {
        while old.warm_foam(tick).unwrap() {}
        for SentFrame { unit, bytes: frame, .. } in old.frames(tick, &demand).unwrap().frames {
            let Some(streamed) = frames.get(&(tick as u64)).and_then(|frames| frames.get(&unit.cascade)) else {
                continue;
            };
            assert!(*streamed == frame, "foam of cascade {} at tick {tick}", unit.cascade);
            covered += split(&frame).unwrap().1.iter().filter(|byte| **byte != 0).count();
        }
    }
    assert!(covered > 50, "the test must see foam, it saw {covered} bytes of it");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_plan_that_is_served_says_what_is_live_and_what_effects_cost() {
    let served = Served::start(&scene(THREE), Settings::default()).await;
    let path = "/v1/scenes/three/plan";
    let idle = served.http("GET", path, "", "").await.json();
    assert_eq!((&idle["transforms"], &idle["units"]), (&json!(0), &json!([])));
    let effects = idle["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 14);
    assert!(effects.iter().all(|effect| effect["step"]["median_ms"].as_f64().unwrap() > 0.0), "{effects:?}");
    let mut client = served.client().await;
    let wanted = units(&[0, 2], 0, &[Group::Displacement, Group::Foam]);
    client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 30, "units": wanted })).await;
    client.text("subscribed").await;
    let live = served.http("GET", path, "", "").await.json();
    // Three of the displacement, three of foam, of each cascade and frame; foam's own steps fall on frames.
    assert_eq!((&live["transforms"], &live["transforms_per_second"]), (&json!(2 * 6), &json!(2.0 * 6.0 * 30.0)));
    let rates: Vec<&Value> = live["units"].as_array().unwrap().iter().map(|unit| &unit["rate_hz"]).collect();
    assert_eq!(rates, vec![&json!(30); 4]);
    assert_eq!(served.http("GET", "/v1/scenes/other/plan", "", "").await.status, 404);
    served.stop().await;
}
