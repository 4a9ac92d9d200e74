//! Laws of the HTTP side: what is asked for happens and is in the log; what can't is refused by name.

use std::time::Duration;

use serde_json::{Value, json};
use swellcast::control::{Epoch, Store};
use swellcast::scene::preset;
use swellcast::server::{Ocean, Settings};

use crate::served::{Answer, SMALL, Served};
use crate::support::scene;

const WIND: &str = "/v1/scenes/small/wind";
const SEA: &str = "/v1/scenes/small/sea";
const LOG: &str = "/v1/scenes/small/log";
const BREEZE: &str = r#"{"speed_mps":10,"direction_from_deg":200}"#;

/// A refusal must be a whole problem document.
#[track_caller]
fn refused(answer: &Answer, status: u16, kind: &str) -> Value {
    assert_eq!(answer.status, status, "{answer:?}");
    assert_eq!(answer.header("content-type"), Some("application/problem+json"), "{answer:?}");
    let problem = answer.json();
    assert_eq!(problem["status"], status);
    assert_eq!(problem["type"], format!("urn:swellcast:problem:{kind}"), "{answer:?}");
    assert!(problem["title"].as_str().is_some_and(|s| !s.is_empty()));
    assert!(problem["detail"].as_str().is_some_and(|s| !s.is_empty()));
    problem
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_wrong_request_is_refused_by_name() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let long = format!("{{\"speed_mps\":{}}}", "1".repeat(70_000));
    let deep = "[".repeat(60_000);
    let wind = |more: &str| format!(r#"{{"speed_mps":10,"direction_from_deg":200{more}}}"#);
    let too_late = (1i64 << 53).to_string();
    let cases: Vec<(&str, &str, String, u16, &str, &str)> = vec![
        ("GET", "/nothing", String::new(), 404, "not-found", ""),
        ("GET", "/v1/scenes/%ff", String::new(), 404, "not-found", ""),
        ("GET", "/v1/scenes/other", String::new(), 404, "not-found", ""),
        ("PUT", "/v1/scenes/other/wind", BREEZE.to_owned(), 404, "not-found", ""),
        ("GET", "/../Cargo.toml", String::new(), 404, "not-found", ""),
        ("POST", "/nothing", String::new(), 404, "not-found", ""),
        ("POST", "/v1/time", String::new(), 405, "wrong-method", ""),
        ("DELETE", "/v1/scenes/small", String::new(), 405, "wrong-method", ""),
        ("PUT", "/v1/scenes/new", "{}".to_owned(), 405, "wrong-method", ""),
        ("GET", WIND, String::new(), 405, "wrong-method", ""),
        ("PUT", WIND, String::new(), 400, "not-json", ""),
        ("PUT", WIND, "speed".to_owned(), 400, "not-json", ""),
        ("PUT", WIND, "{\"speed_mps\":NaN}".to_owned(), 400, "not-json", ""),
        ("PUT", WIND, "{\"speed_mps\":1e999}".to_owned(), 400, "not-json", ""),
        ("PUT", WIND, deep, 400, "not-json", ""),
        ("PUT", WIND, "\u{0}".to_owned(), 400, "not-json", ""),
        ("PUT", WIND, long, 413, "body-too-large", ""),
        ("PUT", WIND, "[1]".to_owned(), 422, "invalid-value", ""),
        ("PUT", WIND, "{}".to_owned(), 422, "missing-field", "speed_mps"),
        ("PUT", WIND, r#"{"speed_mps":10}"#.to_owned(), 422, "missing-field", "direction_from_deg"),
        ("PUT", WIND, wind(r#","fetch_m":1"#), 422, "unknown-field", "fetch_m"),
        ("PUT", WIND, r#"{"speed_mps":"10","direction_from_deg":0}"#.to_owned(), 422, "invalid-value", "speed_mps"),
        ("PUT", WIND, r#"{"speed_mps":null,"direction_from_deg":0}"#.to_owned(), 422, "invalid-value", "speed_mps"),
        ("PUT", WIND, r#"{"speed_mps":1e308,"direction_from_deg":0}"#.to_owned(), 422, "invalid-value", "speed_mps"),
        ("PUT", WIND, r#"{"speed_mps":20.01,"direction_from_deg":0}"#.to_owned(), 422, "invalid-value", "speed_mps"),
        ("PUT", WIND, r#"{"speed_mps":-1,"direction_from_deg":0}"#.to_owned(), 422, "invalid-value", "speed_mps"),
        (
            "PUT",
            WIND,
            r#"{"speed_mps":9,"direction_from_deg":1e9}"#.to_owned(),
            422,
            "invalid-value",
            "direction_from_deg",
        ),
        ("PUT", WIND, wind(r#","transition_s":-1"#), 422, "invalid-value", "transition_s"),
        ("PUT", WIND, wind(r#","transition_s":3601"#), 422, "invalid-value", "transition_s"),
        ("PUT", WIND, wind(r#","effective_tick":1.5"#), 422, "invalid-value", "effective_tick"),
        ("PUT", WIND, wind(r#","effective_tick":-1"#), 422, "invalid-value", "effective_tick"),
        ("PUT", WIND, wind(&format!(",\"effective_tick\":{too_late}")), 422, "invalid-value", "effective_tick"),
        ("PUT", WIND, wind(r#","effective_tick":1e300"#), 422, "invalid-value", "effective_tick"),
        ("PUT", WIND, wind(r#","effective_tick":0"#), 422, "too-early", "effective_tick"),
        ("PUT", WIND, wind(r#","in_seconds":0"#), 422, "too-early", "in_seconds"),
        ("PUT", WIND, wind(r#","in_seconds":-1e300"#), 422, "invalid-value", "effective_tick"),
        ("PUT", WIND, wind(r#","in_seconds":1e300"#), 422, "invalid-value", "effective_tick"),
        ("PUT", WIND, wind(r#","in_seconds":1,"effective_tick":1"#), 422, "invalid-value", "in_seconds"),
        ("PATCH", SEA, "{}".to_owned(), 422, "missing-field", "depth_m"),
        ("PATCH", SEA, r#"{"depth_m":0}"#.to_owned(), 422, "invalid-value", "depth_m"),
        ("PATCH", SEA, r#"{"depth_m":true}"#.to_owned(), 422, "invalid-value", "depth_m"),
        ("GET", "/v1/scenes/small/log?limit=0", String::new(), 422, "invalid-value", "limit"),
        ("GET", "/v1/scenes/small/log?limit=1001", String::new(), 422, "invalid-value", "limit"),
        ("GET", "/v1/scenes/small/log?after=-1", String::new(), 422, "invalid-value", "after"),
        ("GET", "/v1/scenes/small/log?before=1", String::new(), 422, "invalid-value", "before"),
        ("GET", "/v1/stream", String::new(), 426, "upgrade-required", ""),
    ];
    for (method, path, body, status, kind, field) in cases {
        let answer = served.http(method, path, "", &body).await;
        let problem = refused(&answer, status, kind);
        assert_eq!(problem["field"].as_str().unwrap_or_default(), field, "{answer:?}");
        if kind == "invalid-value" && !field.is_empty() {
            assert!(!problem["value"].is_null() || body.contains("null"), "{answer:?}");
            assert!(problem["bound"].is_string(), "{answer:?}");
        }
        if status == 405 {
            assert!(answer.header("allow").is_some(), "{answer:?}");
        }
    }
    assert_eq!(served.get(LOG).await.json()["changes"], json!([]), "a refusal changes nothing");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_accepted_change_is_in_the_log_and_in_force() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let before = served.get("/v1/time").await.json();
    let accepted =
        served.http("PUT", WIND, "", r#"{"speed_mps":12.5,"direction_from_deg":-90,"transition_s":0}"#).await;
    assert_eq!((accepted.status, accepted.header("etag")), (202, Some("\"1\"")), "{accepted:?}");
    let body = accepted.json();
    assert_eq!(body["sequence"], 1);
    let effective = body["effective_tick"].as_i64().unwrap();
    let waited = effective - before["tick"].as_i64().unwrap();
    assert!((1680 + 720..7200 * 5).contains(&waited), "as soon as frames allow: {waited}");
    let deep = served.http("PATCH", SEA, "", r#"{"depth_m":null,"in_seconds":3,"transition_s":2}"#).await;
    assert_eq!(deep.status, 202, "{deep:?}");
    let log = served.get(LOG).await;
    assert_eq!(log.header("etag"), Some("\"2\""));
    let log = log.json();
    let wind = json!({ "kind": "wind", "speed_mps": 12.5, "direction_from_deg": 270.0 });
    let first = json!({ "sequence": 1, "effective_tick": effective, "transition_ticks": 0, "change": wind });
    assert_eq!(log["changes"][0], first);
    assert_eq!(log["changes"][1]["change"], json!({ "kind": "water", "depth_m": null }));
    assert_eq!(log["changes"][1]["transition_ticks"], 14_400);
    assert_eq!(log["next_after"], Value::Null);
    let page = served.get("/v1/scenes/small/log?after=0&limit=1").await.json();
    assert_eq!((&page["changes"], &page["next_after"]), (&json!([first]), &json!(1)));
    // The state of the scene follows.
    for _ in 0..100 {
        if served.get("/v1/time").await.json()["tick"].as_i64().unwrap() > effective + 9000 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let scene = served.get("/v1/scenes/small").await;
    assert_eq!(scene.header("etag"), Some("\"2\""));
    let scene = scene.json();
    assert_eq!(scene["sequence"], 2);
    assert_eq!(scene["state"]["wind"]["speed_mps"], 12.5);
    assert_eq!(scene["scene"]["wind"]["speed_mps"], 8.0, "the scene itself is what the log began with");
    assert_eq!(scene["layout"]["cascades"].as_array().unwrap().len(), 1);
    assert!(scene["state"]["hs_m"].as_f64() > Some(0.0));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_tick_too_early_is_refused_with_the_earliest() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let tick = served.get("/v1/time").await.json()["tick"].as_i64().unwrap();
    let body = |tick: i64| format!(r#"{{"speed_mps":9,"direction_from_deg":0,"effective_tick":{tick}}}"#);
    let problem = refused(&served.http("PUT", WIND, "", &body(tick)).await, 422, "too-early");
    let earliest = problem["bound"].as_i64().unwrap();
    assert!(earliest >= tick + 1680 + 720, "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains(&earliest.to_string()), "{problem}");
    let accepted = served.http("PUT", WIND, "", &body(earliest + 3600)).await;
    assert_eq!(accepted.json()["effective_tick"], earliest + 3600, "a tick that is asked for is kept");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn if_match_lets_one_of_two_operators_through() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let tag = served.get("/v1/scenes/small").await.header("etag").unwrap().to_owned();
    let header = format!("if-match: {tag}\r\n");
    let (a, b) = tokio::join!(served.http("PUT", WIND, &header, BREEZE), served.http("PUT", WIND, &header, BREEZE));
    let (won, lost) = if a.status == 202 { (a, b) } else { (b, a) };
    assert_eq!(won.status, 202, "{won:?}");
    let problem = refused(&lost, 412, "changed-meanwhile");
    assert_eq!((&problem["field"], &problem["bound"]), (&json!("If-Match"), &json!("\"1\"")));
    for header in ["if-match: *\r\n", "if-match: \"9\", \"2\"\r\n"] {
        assert_eq!(served.http("PUT", WIND, header, BREEZE).await.status, 202, "{header}");
    }
    for header in ["if-match: W/\"3\"\r\n", "if-match: nonsense\r\n", "if-match: \r\n"] {
        refused(&served.http("PUT", WIND, header, BREEZE).await, 412, "changed-meanwhile");
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_request_that_is_repeated_with_its_key_happens_once() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let header = "idempotency-key: show-7\r\n";
    let (a, b) = tokio::join!(served.http("PUT", WIND, header, BREEZE), served.http("PUT", WIND, header, BREEZE));
    assert_eq!((a.status, b.status), (202, 202));
    assert_eq!(a.json(), b.json());
    let same = r#"{ "direction_from_deg": 200.0, "speed_mps": 10, "transition_s": 5 }"#;
    assert_eq!(served.http("PUT", WIND, header, same).await.json(), a.json(), "the meaning counts, not the spelling");
    let other = r#"{"speed_mps":11,"direction_from_deg":200}"#;
    refused(&served.http("PUT", WIND, header, other).await, 422, "key-reused");
    refused(&served.http("PATCH", SEA, header, r#"{"depth_m":9}"#).await, 422, "key-reused");
    let long = format!("idempotency-key: {}\r\n", "k".repeat(129));
    refused(&served.http("PUT", WIND, &long, BREEZE).await, 422, "invalid-value");
    assert_eq!(served.get(LOG).await.json()["changes"].as_array().unwrap().len(), 1);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn transitions_may_overlap_only_so_far() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let start = served.get("/v1/time").await.json()["tick"].as_i64().unwrap() + 7200 * 60;
    // Backwards in time: each new one begins before all the others.
    for n in 0..16 {
        let tick = start - n * 240;
        let body = format!(r#"{{"speed_mps":9,"direction_from_deg":0,"effective_tick":{tick},"transition_s":600}}"#);
        assert_eq!(served.http("PUT", WIND, "", &body).await.status, 202, "{n}");
    }
    for tick in [start - 16 * 240, start + 240] {
        let body = format!(r#"{{"speed_mps":9,"direction_from_deg":0,"effective_tick":{tick},"transition_s":600}}"#);
        refused(&served.http("PUT", WIND, "", &body).await, 409, "too-many-transitions");
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn changes_can_not_come_faster_than_the_sea_can_be_built_for_ever() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let body = r#"{"speed_mps":9,"direction_from_deg":0,"transition_s":0}"#;
    let begun = served.ocean.tick();
    for n in 0.. {
        let answer = served.http("PUT", WIND, "", body).await;
        if answer.status != 202 {
            // The allowance grows back while a slow machine asks.
            let seconds = (served.ocean.tick() - begun) / 7200 + 1;
            assert!((16..=64 + 2 * seconds).contains(&n), "refused after {n} in {seconds} s: {answer:?}");
            match answer.status {
                409 => refused(&answer, 409, "too-many-changes"),
                _ => refused(&answer, 429, "too-fast"),
            };
            break;
        }
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_sea_without_wind_has_no_wind_to_set() {
    let swell = scene("name = \"small\"\n[[swell]]\nhs_m = 1\n[cascades]\nn = 32\npatches_m = [200]\n");
    let served = Served::start(&swell, Settings::default()).await;
    refused(&served.http("PUT", WIND, "", BREEZE).await, 409, "not-wind-driven");
    assert_eq!(served.http("PATCH", SEA, "", r#"{"depth_m":12}"#).await.status, 202);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_server_tells_how_it_is() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let list = served.get("/v1/scenes").await.json();
    assert_eq!(list["scenes"][0]["name"], "small");
    let time = served.get("/v1/time").await.json();
    let (tick, us) = (time["tick"].as_i64().unwrap(), time["time_us"].as_i64().unwrap());
    assert_eq!(tick, us * 9 / 1250, "7200 ticks a second");
    assert!((3600.0..3700.0).contains(&(us as f64 / 1e6)), "an hour after tick 0");
    assert_eq!(time["epoch"].as_str().unwrap().len(), 16);
    assert!(time["unix_ns_of_tick_0"].as_i64().unwrap() > 1_600_000_000_000_000_000);
    assert_eq!(served.get("/livez").await.status, 200);
    assert_eq!(served.get("/readyz").await.status, 200);
    let metrics = served.get("/metrics").await;
    assert_eq!(metrics.status, 200);
    for line in ["swellcast_clients 0", "swellcast_log_sequence 0", "# TYPE swellcast_steps_total counter"] {
        assert!(metrics.body.contains(line), "{line} in {}", metrics.body);
    }
    let head = served.http("HEAD", "/livez", "", "").await;
    assert_eq!((head.status, head.body.as_str()), (200, ""));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_restarted_server_goes_on_with_the_same_sea() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, mut seen) = (scene(SMALL), Vec::new());
    for _ in 0..2 {
        let store = Store::open(folder.path()).unwrap();
        let epoch = Epoch::begin(swellcast::engine::Clock::unix_now_ns());
        let begun = store.begin(&scene, epoch).unwrap();
        let served = Served::of(Ocean::start(store, begun, Settings::default())).await;
        served.http("PUT", WIND, "idempotency-key: once\r\n", BREEZE).await;
        let log = served.get(LOG).await.json();
        seen.push((served.get("/v1/time").await.json()["epoch"].clone(), log));
        served.stop().await;
    }
    assert_eq!(seen[0], seen[1]);
    let store = Store::open(folder.path()).unwrap();
    assert!(store.begin(&preset("beaufort-3").unwrap(), Epoch::begin(0)).is_err());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn statistics_and_warnings_are_told_of_the_sea_that_is_served() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let answer = served.get("/v1/scenes/small/statistics").await;
    assert_eq!(answer.status, 200, "{answer:?}");
    let told = answer.json();
    let timeline = served.ocean.current().timeline;
    let known = serde_json::to_value(timeline.statistics_at(told["tick"].as_i64().unwrap())).unwrap();
    for (field, value) in known.as_object().unwrap() {
        assert_eq!(told[field], *value, "{field}");
    }
    assert!(told["tp_s"].as_f64().unwrap() > told["tz_s"].as_f64().unwrap());
    assert_eq!(served.get("/v1/scenes/other/statistics").await.status, 404);
    // A patch of 60 m holds little of an ocean's waves, and the operator is told.
    let scene = served.get("/v1/scenes/small").await.json();
    assert!(
        scene["warnings"][0].as_str().is_some_and(|text| text.contains("% of the energy")),
        "{}",
        scene["warnings"]
    );
    served.stop().await;
}
