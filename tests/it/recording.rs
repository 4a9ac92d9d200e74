//! What was recorded is served again: the same bytes, the same changes, and in a sea that repeats without a seam.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::json;
use swellcast::client::{Choice, Connection, Event, RecordArguments, Recorded, record};
use swellcast::control::{Epoch, Store};
use swellcast::engine::Clock;
use swellcast::recording::{Block, Preface, Recording, RecordingError, RecordingWriter, Taken};
use swellcast::scene::SceneFile;
use swellcast::server::{Ocean, ReplaySettings, Settings};
use swellcast::tile::{DecodedFrame, SentFrame};
use swellcast::wire::{Codec, ErrorClass, Group};

use crate::served::{Got, PATIENCE, SMALL, Served, header};
use crate::support::scene;

/// Ticks that a busy machine may pass over, of more than a hundred.
const SKIPPED: i64 = 4;
const GROUPS: [Group; 2] = [Group::Displacement, Group::Foam];

fn now() -> impl Fn() -> i64 + Copy {
    let clock = Clock::start(Clock::unix_now_ns());
    move || clock.now_us()
}

fn choice(rate: u32) -> Choice {
    let (class, groups) = (ErrorClass::Millimetre, GROUPS.to_vec());
    Choice { rate: Some(rate), class, groups, cascades: usize::MAX, level: 0, codec: Codec::Rans }
}

async fn recorded(served: &Served, out: &Path, seconds: f64) -> Recorded {
    let arguments = RecordArguments {
        url: format!("http://{}", served.address),
        out: out.to_owned(),
        seconds: Some(seconds),
        choice: choice(30),
    };
    let recorded = record(&arguments, now(), |_| {}).await.unwrap();
    assert_eq!(recorded.bytes, std::fs::metadata(out).unwrap().len());
    recorded
}

async fn replayed(path: &Path, replay: ReplaySettings) -> Served {
    let recording = Recording::open(path).unwrap();
    Served::of(Ocean::replay(recording, replay, Settings::default()).unwrap()).await
}

/// Every frame of a file, by tick and group.
fn frames_of(path: &Path) -> BTreeMap<(i64, Group), SentFrame> {
    let mut recording = Recording::open(path).unwrap();
    let mut frames = BTreeMap::new();
    for at in 0..recording.len() {
        if let Block::Frames { bytes, frames: places, .. } = recording.block(at).unwrap() {
            for (begin, end) in places {
                let frame = SentFrame::read(bytes[begin..end].to_vec().into()).unwrap();
                frames.insert((frame.tick, frame.unit.group), frame);
            }
        }
    }
    frames
}

/// What a client that asks for `rate` sees until `enough`.
async fn seen(served: &Served, rate: u32, enough: usize) -> BTreeMap<(i64, Group), (DecodedFrame, Vec<u8>)> {
    let mut connection = Connection::open(&format!("http://{}", served.address), now()).await.unwrap();
    let mut frames = BTreeMap::new();
    while frames.len() < enough {
        match tokio::time::timeout(PATIENCE, connection.next()).await.unwrap() {
            Event::Hello(hello) => drop(connection.subscribe(rate, choice(rate).units(&hello), false).await),
            Event::Frame(frame, bytes) => {
                let key = (i64::try_from(frame.header.tick).unwrap(), frame.unit().group);
                assert!(frames.insert(key, (frame, bytes.to_vec())).is_none(), "{key:?} comes twice");
            }
            Event::Status(_) | Event::Subscribed(_) => {}
            other => panic!("{other:?}"),
        }
    }
    frames
}

/// Ticks of the grid that are not there, between those that are.
fn missing(ticks: &[i64]) -> i64 {
    ticks.windows(2).map(|pair| (pair[1] - pair[0]) / 240 - 1).sum()
}

fn file() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sea.swr");
    (folder, path)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_recording_is_served_as_it_was() {
    let (_folder, path) = file();
    let live = Served::start(&scene(SMALL), Settings::default()).await;
    recorded(&live, &path, 4.0).await;
    let epoch = live.ocean.hello().epoch;
    live.stop().await;
    let kept = frames_of(&path);
    let again = replayed(&path, ReplaySettings::default()).await;
    let hello = again.ocean.hello();
    assert_eq!(hello.epoch, epoch);
    assert_eq!(
        hello.groups.iter().map(|group| group.name).collect::<Vec<_>>(),
        GROUPS,
        "what was not recorded is absent"
    );
    assert_eq!(hello.rates_hz, [15, 30]);
    let shown = seen(&again, 30, 60).await;
    for (key, (_, bytes)) in &shown {
        assert!(*bytes == kept[key].bytes, "{key:?}");
    }
    // No tick is missing from the first key frame on.
    let ticks: Vec<i64> = shown.keys().filter(|(_, group)| *group == Group::Foam).map(|(tick, _)| *tick).collect();
    // The newest may come before what lies between it and the one before.
    assert!(missing(&ticks[..ticks.len() - 4]) <= SKIPPED, "{ticks:?}");
    let refused = again.http("PUT", "/v1/scenes/small/wind", "", r#"{"speed_mps": 5, "direction_from_deg": 0}"#).await;
    assert_eq!(
        (refused.status, &refused.json()["type"]),
        (409, &json!("urn:swellcast:problem:recorded")),
        "{refused:?}"
    );
    let refused = again.http("PUT", "/v1/scenes/small/budget", "", r#"{"budget_ms": 4}"#).await;
    assert_eq!((refused.status, &refused.json()["type"]), (409, &json!("urn:swellcast:problem:recorded")));
    again.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_was_not_recorded_is_refused_by_name() {
    let (_folder, path) = file();
    let live = Served::start(&scene(SMALL), Settings::default()).await;
    recorded(&live, &path, 2.0).await;
    live.stop().await;
    let again = replayed(&path, ReplaySettings::default()).await;
    let mut client = again.client().await;
    for (unit, field) in [
        (json!({ "cascade": 0, "level": 1, "class": "1mm", "group": "foam", "codec": "rans" }), "units[0]"),
        (json!({ "cascade": 0, "level": 0, "class": "0.5mm", "group": "foam", "codec": "rans" }), "units[0]"),
        (json!({ "cascade": 0, "level": 0, "class": "1mm", "group": "foam" }), "units[0]"),
    ] {
        client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 15, "units": [unit] })).await;
        let refusal = client.text("error").await;
        assert_eq!((&refusal["code"], &refusal["field"]), (&json!("unavailable"), &json!(field)), "{refusal}");
        assert!(refusal["detail"].as_str().unwrap().contains("0/0/foam/1mm/rans"), "{refusal}");
    }
    client.send(&json!({ "type": "points", "id": 2, "rate_hz": 15, "points": [[0.0, 0.0]] })).await;
    assert_eq!(client.text("error").await["field"], "points");
    again.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn changes_come_again_when_they_came() {
    let (_folder, path) = file();
    let live = Served::start(&scene(SMALL), Settings::default()).await;
    assert_eq!(
        live.http("PUT", "/v1/scenes/small/wind", "", r#"{"speed_mps": 9, "direction_from_deg": 0}"#).await.status,
        202
    );
    let change = async {
        tokio::time::sleep(std::time::Duration::from_millis(2500)).await;
        live.http(
            "PUT",
            "/v1/scenes/small/wind",
            "",
            r#"{"speed_mps": 14, "direction_from_deg": 0, "transition_s": 0}"#,
        )
        .await
    };
    let (kept, answer) = tokio::join!(recorded(&live, &path, 6.0), change);
    assert_eq!((kept.changes, answer.status), (1, 202), "{answer:?}");
    let effective = answer.json()["effective_tick"].as_i64().unwrap();
    live.stop().await;
    // A machine that is so busy that the change was announced before anybody could join begins anew.
    let (again, mut client) = loop {
        let again = replayed(&path, ReplaySettings::default()).await;
        let mut client = again.client().await;
        let sequence = client.text("hello").await["sequence"].as_u64();
        if sequence == Some(1) {
            break (again, client);
        }
        assert_eq!(sequence, Some(2), "what came before is there at once");
        again.stop().await;
    };
    let unit = json!({ "cascade": 0, "level": 0, "class": "1mm", "group": "displacement", "codec": "rans" });
    client.send(&json!({ "type": "subscribe", "id": 1, "rate_hz": 15, "units": [unit] })).await;
    let told = loop {
        match client.next().await {
            Got::Text(text) if text["type"] == "change" => break text,
            Got::Frame(frame) => assert!((header(&frame).tick as i64) < effective, "it is announced before it acts"),
            Got::Closed(code) => panic!("closed with {code}"),
            Got::Text(_) => {}
        }
    };
    assert_eq!((&told["sequence"], &told["effective_tick"]), (&json!(2), &json!(effective)), "{told}");
    let log = again.get("/v1/scenes/small/log").await.json();
    assert_eq!(log["changes"][1]["change"]["speed_mps"], 14.0, "{log}");
    again.stop().await;
    // Who begins behind it has it in force at once.
    let later = replayed(&path, ReplaySettings { from_s: 5.0, repeat: false }).await;
    assert_eq!(later.ocean.current().sequence, 2);
    let log = later.get("/v1/scenes/small/log").await.json();
    assert_eq!(log["changes"][1]["effective_tick"], json!(effective), "{log}");
    later.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_change_of_layout_comes_again_with_its_units() {
    let (_folder, path) = file();
    let live = Served::start(&scene(SMALL), Settings::default()).await;
    let change = async {
        tokio::time::sleep(std::time::Duration::from_millis(500)).await;
        let layout = r#"{"n": 16, "patches_m": [40], "transition_s": 1}"#;
        live.http("PUT", "/v1/scenes/small/layout", "", layout).await
    };
    let (kept, answer) = tokio::join!(recorded(&live, &path, 6.0), change);
    assert_eq!((kept.changes, answer.status), (1, 202), "{answer:?}");
    live.stop().await;
    let mut recording = Recording::open(&path).unwrap();
    let kinds: Vec<bool> = (0..recording.len())
        .filter(|block| !recording.is_of_frames(*block))
        .collect::<Vec<_>>()
        .into_iter()
        .map(|block| matches!(recording.block(block).unwrap(), Block::Taken(_)))
        .collect();
    assert_eq!(kinds, [true, false], "its units are known before it is announced");
    let again = replayed(&path, ReplaySettings::default()).await;
    let mut connection = Connection::open(&format!("http://{}", again.address), now()).await.unwrap();
    let mut cascades = std::collections::BTreeSet::new();
    while cascades.len() < 2 {
        match tokio::time::timeout(PATIENCE, connection.next()).await.unwrap() {
            Event::Hello(hello) => drop(connection.subscribe(30, choice(30).units(&hello), false).await),
            Event::Frame(frame, _) => drop(cascades.insert(frame.header.cascade)),
            Event::Error { detail, .. } => panic!("{detail}"),
            _ => {}
        }
    }
    again.stop().await;
    // Behind the change its cascade is there from the first frame on.
    let later = replayed(&path, ReplaySettings { from_s: 4.0, repeat: false }).await;
    let shown = seen(&later, 30, 20).await;
    assert!(shown.values().any(|(frame, _)| frame.header.n == 16));
    later.stop().await;
}

#[test]
fn what_comes_before_the_first_frame_is_kept() {
    let (_folder, path) = file();
    let store = Store::in_memory().unwrap();
    let begun = store.begin(&scene(SMALL), Epoch::begin(Clock::unix_now_ns())).unwrap();
    let hello = Ocean::start(store, begun, Settings::default()).hello();
    let taken = Taken { rate_hz: 15, units: Vec::new() };
    let scene = serde_json::to_value(SceneFile::from(&scene(SMALL))).unwrap();
    let preface = Preface { hello, scene, changes: Vec::new(), taken: taken.clone() };
    let mut writer = RecordingWriter::create(&path, &preface).unwrap();
    writer.taken(&taken).unwrap();
    writer.finish().unwrap();
    let recording = Recording::open(&path).unwrap();
    assert!(recording.is_whole() && recording.len() == 1 && recording.leaves(0).unwrap() >= 0);
    let exists = RecordingWriter::create(&path, &preface).unwrap_err();
    assert!(matches!(exists, RecordingError::Io { .. }), "{exists}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sea_that_repeats_is_played_again_and_again_without_a_seam() {
    let (_folder, path) = file();
    let toml = format!("loop_s = 2\n{SMALL}");
    let live = Served::start(&scene(&toml), Settings::default()).await;
    recorded(&live, &path, 5.5).await;
    live.stop().await;
    let again = replayed(&path, ReplaySettings { repeat: true, ..ReplaySettings::default() }).await;
    // Six seconds: three rounds.
    let shown = seen(&again, 30, 360).await;
    let ticks: Vec<i64> = shown.keys().filter(|(_, group)| *group == Group::Foam).map(|(tick, _)| *tick).collect();
    let (mut compared, span) = (0, 2 * 7200);
    // A busy machine may leave its client behind for a while, but a round and more without a gap has a seam within.
    let whole = ticks.chunk_by(|a, b| b - a == 240).map(|run| run[run.len() - 1] - run[0]).max();
    assert!(whole > Some(span), "{ticks:?}");
    for ((tick, group), (frame, _)) in &shown {
        if let Some((next, _)) = shown.get(&(tick + span, *group)) {
            assert!(frame.planes == next.planes, "tick {tick}, {group:?}");
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
    again.stop().await;
    let endless = scene(SMALL);
    let live = Served::start(&endless, Settings::default()).await;
    let (_folder, path) = file();
    recorded(&live, &path, 2.0).await;
    live.stop().await;
    let repeat = ReplaySettings { repeat: true, ..ReplaySettings::default() };
    let refused =
        Ocean::replay(Recording::open(&path).unwrap(), repeat, Settings::default()).err().unwrap().to_string();
    assert!(refused.contains("loop_s"), "{refused}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_recording_ends_and_says_so() {
    let (_folder, path) = file();
    let live = Served::start(&scene(SMALL), Settings::default()).await;
    recorded(&live, &path, 3.0).await;
    live.stop().await;
    let again = replayed(&path, ReplaySettings { from_s: 2.0, repeat: false }).await;
    tokio::time::timeout(PATIENCE, again.ocean.over()).await.expect("it ends");
    let ready = again.get("/readyz").await;
    assert_eq!(ready.status, 503, "{ready:?}");
    again.stop().await;
    let late = ReplaySettings { from_s: 20.0, repeat: false };
    let refused = Ocean::replay(Recording::open(&path).unwrap(), late, Settings::default()).err().unwrap();
    assert!(matches!(refused, RecordingError::Field { field: "beginning", .. }), "{refused}");
}

#[tokio::test(flavor = "multi_thread")]
async fn files_that_are_cut_or_damaged_give_what_is_whole_or_an_error() {
    let (_folder, path) = file();
    let live = Served::start(&scene(SMALL), Settings::default()).await;
    recorded(&live, &path, 2.0).await;
    live.stop().await;
    let bytes = std::fs::read(&path).unwrap();
    let whole = Recording::open(&path).unwrap();
    assert!(whole.is_whole());
    // A recorder that was killed: no index, and half a block at the end.
    std::fs::write(&path, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let mut cut = Recording::open(&path).unwrap();
    assert!(!cut.is_whole() && cut.len() > whole.len() / 2 && cut.len() < whole.len());
    assert!((0..cut.len()).all(|at| cut.block(at).is_ok()));
    // Any byte changed, and any length: an error or what is whole, and never more memory than the file has.
    let mut random = crate::random::Random(7);
    for _ in 0..400 {
        let mut damaged = bytes.clone();
        damaged.truncate(bytes.len() - random.below(200));
        for _ in 0..1 + random.below(8) {
            // Most of what can go wrong stands at the beginning and at the end.
            let near = random.below(64);
            let at = match random.below(3) {
                0 => near,
                1 => damaged.len() - 1 - near,
                _ => random.below(damaged.len()),
            };
            damaged[at] = random.bits() as u8;
        }
        std::fs::write(&path, &damaged).unwrap();
        let Ok(mut recording) = Recording::open(&path) else { continue };
        for at in 0..recording.len() {
            if let Ok(Block::Frames { bytes, frames, .. }) = recording.block(at) {
                frames.iter().for_each(|(begin, end)| drop(SentFrame::read(bytes[*begin..*end].to_vec().into())));
            }
        }
    }
}
