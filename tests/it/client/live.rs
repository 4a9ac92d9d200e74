//! The thin client against a real server: what `watch` reports, and that two clients see one sea.

use std::collections::BTreeMap;

use swellcast::client::{Choice, Connection, Event, WatchArguments, watch};
use swellcast::engine::Clock;
use swellcast::server::Settings;
use swellcast::tile::DecodedFrame;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

use crate::served::{PATIENCE, SMALL, Served};
use crate::support::scene;

fn now() -> impl Fn() -> i64 + Copy {
    let clock = Clock::start(Clock::unix_now_ns());
    move || clock.now_us()
}

fn choice(rate: Option<u32>) -> Choice {
    let groups = vec![Group::Displacement, Group::Slopes, Group::Foam];
    Choice { rate, class: ErrorClass::Millimetre, groups, cascades: usize::MAX, level: 0, codec: Codec::Rans }
}

#[tokio::test(flavor = "multi_thread")]
async fn watch_reports_the_sea_that_is_served() {
    // Also where not all can be had as fine and often as any.
    let detail = "[[detail]]\ncascade = 0\ngroup = \"slopes\"\nfinest_level = 1\nrate_hz = 15\n";
    let served = Served::start(&scene(&format!("{SMALL}{detail}")), Settings::default()).await;
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("sea.png");
    let arguments = WatchArguments {
        url: format!("http://{}", served.address),
        seconds: Some(2.0),
        choice: choice(None),
        png: Some(png.clone()),
        json: true,
    };
    let report = tokio::time::timeout(PATIENCE, watch(&arguments, now())).await.unwrap().unwrap();
    assert_eq!((report.scene.as_str(), report.bad_messages, report.stray_frames), ("small", 0, 0));
    let (told, seen) = (report.hs_m.unwrap(), report.hs_received_m.unwrap());
    // A patch at one moment is not the mean over all moments.
    assert!((seen / told - 1.0).abs() < 0.3, "told {told} m, received {seen} m");
    assert!(report.newest_frame_ahead_ms.unwrap() > 0.0, "frames come before their time");
    assert!(report.clock_error_bound_ms.unwrap() < 100.0);
    assert!(std::fs::metadata(png).unwrap().len() > 10_000);
    let wrong = WatchArguments { choice: choice(Some(7)), ..arguments };
    assert!(watch(&wrong, now()).await.unwrap_err().to_string().contains("rate_hz"));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn two_clients_agree_on_time_and_water() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let url = format!("http://{}", served.address);
    let unit =
        UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group: Group::Displacement, codec: Codec::I16 };
    let listen = async |url: String| {
        let mut connection = Connection::open(&url, now()).await.unwrap();
        let mut frames = BTreeMap::<u64, DecodedFrame>::new();
        while frames.len() < 25 {
            match connection.next().await {
                Event::Hello(_) => drop(connection.subscribe(15, vec![unit], false).await),
                Event::Frame(frame, _) => drop(frames.insert(frame.header.tick, frame)),
                Event::Closed(closed) => panic!("{closed}"),
                _ => {}
            }
        }
        (frames, connection)
    };
    let both = async { tokio::join!(listen(url.clone()), listen(url)) };
    let ((a, first), (b, second)) = tokio::time::timeout(PATIENCE, both).await.unwrap();
    let apart = (first.server_us().unwrap() - second.server_us().unwrap()).abs();
    let bounds = first.error_bound_us().unwrap() + second.error_bound_us().unwrap();
    assert!(apart <= bounds + 1000, "{apart} us apart, bounds {bounds} us");
    let common: Vec<u64> = a.keys().copied().filter(|tick| b.contains_key(tick)).collect();
    assert!(common.len() > 10, "{} ticks in common", common.len());
    common.iter().for_each(|tick| assert_eq!(a[tick], b[tick]));
    served.stop().await;
}
