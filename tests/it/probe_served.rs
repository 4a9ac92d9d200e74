//! Laws of point queries over HTTP: answered beside the engine, refused by name, bounded whatever is sent.

use std::time::Duration;

use serde_json::{Value, json};
use swellcast::control::{Epoch, Store};
use swellcast::engine::Clock;
use swellcast::scene::{Change, ChangeKind, preset};
use swellcast::sea::Timeline;
use swellcast::server::{Ocean, Settings};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::served::{Answer, SMALL, Served};
use crate::support::scene;

const PROBE: &str = "/v1/scenes/small/probe";

async fn probe(served: &Served, body: &Value) -> Answer {
    served.http("POST", PROBE, "", &body.to_string()).await
}

/// A figure of the metrics.
async fn figure(served: &Served, name: &str) -> f64 {
    let page = served.get("/metrics").await.body;
    let line = page.lines().find_map(|line| line.strip_prefix(&format!("swellcast_{name} ")));
    line.unwrap_or_else(|| panic!("no {name} in {page}")).parse().unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn points_are_answered_and_the_engine_rests() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let before = served.get("/v1/time").await.json()["tick"].as_i64().unwrap();
    let answer = probe(&served, &json!({ "points": [[1, 2], [-1e9, 12.5]] })).await;
    assert_eq!((answer.status, answer.header("content-type")), (200, Some("application/json")), "{answer:?}");
    let first = answer.json();
    assert!(first["tick"].as_i64().unwrap() >= before, "now unless said otherwise");
    assert_eq!((&first["method"], &first["sequence"], &first["transforms"]), (&json!("grid"), &json!(0), &json!(11)));
    assert!(first["iterations"]["mean"].as_f64().unwrap() <= first["iterations"]["most"].as_f64().unwrap());
    let points = first["points"].as_array().unwrap();
    assert_eq!((points.len(), &points[1]["x"], &points[1]["z"]), (2, &json!(-1e9), &json!(12.5)));
    for point in points {
        assert_eq!((point["normal"].as_array().unwrap().len(), point["velocity"].as_array().unwrap().len()), (3, 3));
        assert!(point["folded"] == json!(false) && point["residual"].as_f64().unwrap() < 1e-3, "{point}");
        assert!(point["height"].is_f64() && point["jacobian"].is_f64() && point["iterations"].is_u64(), "{point}");
    }

    let at = |fields: &[&str], method: &str| json!({ "points": [[1, 2]], "tick": before, "fields": fields, "method": method });
    let height = probe(&served, &at(&["height"], "grid")).await.json();
    let keys: Vec<&String> = height["points"][0].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["folded", "height", "iterations", "residual", "rest", "x", "z"]);
    assert_eq!((&height["tick"], &height["transforms"]), (&json!(before), &json!(3)));
    let again = probe(&served, &at(&[], "grid")).await.json();
    assert_eq!((&again["transforms"], &again["points"]), (&json!(0), &height["points"]), "nothing is made twice");
    let direct = probe(&served, &at(&["height"], "direct")).await.json();
    assert_eq!((&direct["omitted_rms_m"], &direct["transforms"]), (&json!(0.0), &json!(0)));
    let [a, b] = [&direct, &height].map(|told| told["points"][0]["height"].as_f64().unwrap());
    assert!((a - b).abs() < 5e-3, "{a} and {b}");
    let mut some = at(&["height"], "direct");
    some["share"] = json!(0.9);
    assert!(probe(&served, &some).await.json()["omitted_rms_m"].as_f64().unwrap() > 0.0);

    // A change acts on what is probed after it, at its own tick.
    let wind = r#"{"speed_mps":15,"direction_from_deg":0,"transition_s":0}"#;
    let accepted = served.http("PUT", "/v1/scenes/small/wind", "", wind).await.json();
    let effective = accepted["effective_tick"].as_i64().unwrap();
    for (tick, sequence) in [(effective - 1, 0), (effective, 1)] {
        let told = probe(&served, &json!({ "points": [[1, 2]], "tick": tick })).await.json();
        assert_eq!((&told["tick"], &told["sequence"]), (&json!(tick), &json!(sequence)));
    }

    assert_eq!(figure(&served, "transforms_total").await, 0.0, "the engine has no subscriber");
    assert_eq!(figure(&served, "probes_total").await, 7.0);
    assert_eq!(figure(&served, "probe_points_total").await, 8.0);
    assert_eq!(figure(&served, "probe_transforms_total").await, 11.0 + 3.0 + 2.0 * 11.0);
    assert!(figure(&served, "probe_seconds_total").await > 0.0);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_wrong_probe_is_refused_by_name() {
    let bare = format!("{SMALL}[effects]\nvelocity = false\njacobian = false\nnormals = \"none\"\n");
    let served = Served::start(&scene(&bare), Settings::default()).await;
    let many = json!({ "points": vec![[0, 0]; 10_001] }).to_string();
    let with = |more: &str| format!(r#"{{"points":[[0,0]],{more}}}"#);
    let cases: Vec<(String, u16, &str, &str)> = vec![
        (String::new(), 400, "not-json", ""),
        ("[".repeat(500_000), 400, "not-json", ""),
        ("{\"points\":[[NaN,0]]}".to_owned(), 400, "not-json", ""),
        ("{\"points\":[[1e999,0]]}".to_owned(), 400, "not-json", ""),
        ("x".repeat((1 << 20) + 1), 413, "body-too-large", ""),
        ("[]".to_owned(), 422, "invalid-value", ""),
        ("{}".to_owned(), 422, "missing-field", "points"),
        (r#"{"points":[]}"#.to_owned(), 422, "invalid-value", "points"),
        (r#"{"points":{"0":1}}"#.to_owned(), 422, "invalid-value", "points"),
        (many, 422, "invalid-value", "points"),
        (r#"{"points":[[0,0],[0]]}"#.to_owned(), 422, "invalid-value", "points[1]"),
        (r#"{"points":[[0,0,0]]}"#.to_owned(), 422, "invalid-value", "points[0]"),
        (format!(r#"{{"points":["{}"]}}"#, "x".repeat(900_000)), 422, "invalid-value", "points[0]"),
        (r#"{"points":[[0,"1"]]}"#.to_owned(), 422, "invalid-value", "points[0][1]"),
        (r#"{"points":[[1.1e9,0]]}"#.to_owned(), 422, "invalid-value", "points[0][0]"),
        (r#"{"points":[[0,-1e308]]}"#.to_owned(), 422, "invalid-value", "points[0][1]"),
        (with(r#""tick":-1"#), 422, "invalid-value", "tick"),
        (with(r#""tick":1.5"#), 422, "invalid-value", "tick"),
        (with(r#""tick":9007199254740992"#), 422, "invalid-value", "tick"),
        (with(r#""fields":"height""#), 422, "invalid-value", "fields"),
        (with(r#""fields":["height","colour"]"#), 422, "invalid-value", "fields[1]"),
        (with(r#""fields":["velocity"]"#), 422, "invalid-value", "fields[0]"),
        (with(r#""fields":["jacobian"]"#), 422, "invalid-value", "fields[0]"),
        (with(r#""fields":["normal"]"#), 422, "invalid-value", "fields[0]"),
        (with(r#""method":"magic""#), 422, "invalid-value", "method"),
        (with(r#""method":1"#), 422, "invalid-value", "method"),
        (with(r#""share":0.5"#), 422, "invalid-value", "share"),
        (with(r#""method":"direct","share":0"#), 422, "invalid-value", "share"),
        (with(r#""method":"direct","share":1.01"#), 422, "invalid-value", "share"),
        (with(r#""point":1"#), 422, "unknown-field", "point"),
        (with(&format!(r#""{}":[{{}}]"#, "n".repeat(900_000))), 422, "unknown-field", "a string of 900000 bytes"),
        (with(r#""points":[[0,0]]"#), 422, "invalid-value", "points"),
        (with(r#""tick":1,"tick":1"#), 422, "invalid-value", "tick"),
        (with(r#""tick":1}}"#), 400, "not-json", ""),
        (format!(r#"{{"points":[{}0]}}"#, r#"{"":0},"#.repeat(140_000)), 422, "invalid-value", "points"),
        (format!(r#"{{"points":[[0,{}0]]}}"#, "[],".repeat(300_000)), 422, "invalid-value", "points[0]"),
        (format!(r#"{{"points":[{{{}"z":0}}]}}"#, r#""":[],"#.repeat(140_000)), 422, "invalid-value", "points[0]"),
        (with(&format!(r#""fields":[{}0]"#, r#""height","#.repeat(100_000))), 422, "invalid-value", "fields[100000]"),
    ];
    for (body, status, kind, field) in cases {
        let answer = served.http("POST", PROBE, "", &body).await;
        assert_eq!((answer.status, answer.header("content-type")), (status, Some("application/problem+json")));
        let problem = answer.json();
        assert_eq!(problem["type"], format!("urn:swellcast:problem:{kind}"), "{answer:?}");
        assert_eq!(problem["field"].as_str().unwrap_or_default(), field, "{answer:?}");
        assert!(answer.body.len() < 1000, "what was sent is not sent back: {} bytes", answer.body.len());
        if kind == "invalid-value" && !field.is_empty() {
            assert!(!problem["value"].is_null() && problem["bound"].is_string(), "{answer:?}");
        }
    }
    assert_eq!(served.http("GET", PROBE, "", "").await.status, 405);
    assert_eq!(served.http("POST", "/v1/scenes/other/probe", "", "{}").await.status, 404);
    let told = probe(&served, &json!({ "points": [[0, 0]] })).await.json();
    let keys: Vec<&String> = told["points"][0].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["folded", "height", "iterations", "residual", "rest", "x", "z"], "what the scene has");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ticks_that_are_forgotten_are_refused() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let at = |tick: i64| json!({ "points": [[0, 0]], "tick": tick });
    assert_eq!(probe(&served, &at(0)).await.status, 200, "a sea that never changed is known for ever");
    assert_eq!(probe(&served, &at((1 << 53) - 1)).await.status, 200);
    served.stop().await;

    // An hour after a change of its second second.
    let store = Store::in_memory().unwrap();
    let mut begun = store.begin(&scene(SMALL), Epoch::begin(Clock::unix_now_ns() - 3_600_000_000_000)).unwrap();
    let kind = ChangeKind::Wind { speed_mps: 15.0, direction_from_deg: 0.0 };
    begun.changes = vec![Change { sequence: 1, effective_tick: 7200, transition_ticks: 0, kind }];
    let fresh = Timeline::replay(&begun.scene, &begun.changes, 7200);
    let served = Served::of(Ocean::start(store, begun, Settings::default())).await;
    let timeline = served.ocean.current().timeline;
    let since = timeline.since();
    assert!((7200..7200 * 3600).contains(&since) && fresh.since() == i64::MIN, "{since}");
    assert_eq!(timeline.at(since), fresh.at(since), "what is said to be known is known");
    for tick in [0, 7199, since - 1] {
        let refused = probe(&served, &at(tick)).await;
        let told = refused.json();
        assert_eq!((refused.status, &told["type"]), (422, &json!("urn:swellcast:problem:too-early")), "{refused:?}");
        assert_eq!((&told["field"], &told["value"], &told["bound"]), (&json!("tick"), &json!(tick), &json!(since)));
    }
    let known = probe(&served, &at(since)).await.json();
    assert_eq!((&known["tick"], &known["sequence"]), (&json!(since), &json!(1)));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn ten_thousand_points_are_one_request_and_a_crowd_is_told_to_wait() {
    let served = Served::start(&preset("beaufort-5").unwrap(), Settings::default()).await;
    let path = "/v1/scenes/beaufort-5/probe";
    let points: Vec<[f64; 2]> = (0..10_000).map(|i| [f64::from(i) * 7.31, f64::from(i % 97) * -3.7]).collect();
    let body = json!({ "points": points, "tick": 7200 });
    let told = served.http("POST", path, "", &body.to_string()).await.json();
    let answers = told["points"].as_array().unwrap();
    assert_eq!((answers.len(), &told["transforms"]), (10_000, &json!(44)));
    assert!(answers.iter().zip(&points).all(|(a, p)| a["x"] == json!(p[0]) && a["z"] == json!(p[1])), "in order");

    let direct = json!({ "points": points, "method": "direct" }).to_string();
    let refused = served.http("POST", path, "", &direct).await;
    assert_eq!((refused.status, refused.json()["field"].as_str()), (422, Some("points")), "{}", refused.body);

    // Each takes a good part of a second; the one under way and seven more may wait, the others come again.
    let slow = json!({ "points": points[..1000], "method": "direct" }).to_string();
    let all = futures_util::future::join_all((0..24).map(|_| served.http("POST", path, "", &slow))).await;
    let (ok, busy): (Vec<_>, Vec<_>) = all.iter().partition(|answer| answer.status == 200);
    assert!(ok.len() >= 8 && !busy.is_empty(), "{} answered, {} not", ok.len(), busy.len());
    for answer in busy {
        assert_eq!((answer.status, answer.header("retry-after")), (503, Some("1")), "{answer:?}");
        let told = answer.json();
        assert_eq!(told["type"], "urn:swellcast:problem:busy");
        assert!(told["detail"].as_str().unwrap().starts_with("8 probes are waiting"), "{told}");
    }
    assert_eq!(figure(&served, "transforms_total").await, 0.0);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn bodies_that_never_end_keep_nobody_out() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let begin = async |text: &str| {
        let mut stream = TcpStream::connect(served.address).await.unwrap();
        let head = format!("POST {PROBE} HTTP/1.1\r\nhost: x\r\ncontent-length: 1000000\r\n\r\n{text}");
        stream.write_all(head.as_bytes()).await.unwrap();
        stream
    };
    // Each sends a head and one byte.
    let mut held = Vec::new();
    for _ in 0..200 {
        held.push(begin("{").await);
    }
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(probe(&served, &json!({ "points": [[0, 0]] })).await.status, 200);
    drop(held);

    // Each sends all but the last byte: together more than is held at a time.
    let most = " ".repeat(999_999);
    let mut held = Vec::new();
    for _ in 0..72 {
        held.push(begin(&most).await);
    }
    let mut busy = 0;
    for stream in &mut held {
        let mut answer = vec![0; 1000];
        if let Ok(read) = timeout(Duration::from_millis(100), stream.read(&mut answer)).await {
            let answer = String::from_utf8_lossy(&answer[..read.unwrap()]).into_owned();
            assert!(answer.contains(" 503 ") && answer.contains("65536 KiB of probes are being read"), "{answer}");
            busy += 1;
        }
    }
    assert!((3..10).contains(&busy), "{busy} of 72 were told to come again");
    // The connections go, and their room with them.
    drop(held);
    tokio::time::sleep(Duration::from_millis(200)).await;
    let padded = format!("{{\"points\":[[0,0]]{}}}", " ".repeat(900_000));
    assert_eq!(served.http("POST", PROBE, "", &padded).await.status, 200);
    assert_eq!(served.get("/readyz").await.status, 200);
    served.stop().await;
}
