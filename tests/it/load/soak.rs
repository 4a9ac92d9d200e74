//! Laws of long loads: who leaves is replaced, the wind changes and comes back, and what grows or is skipped is told.

use swellcast::load::growth;
use swellcast::server::Settings;

use super::{load, program};
use crate::served::{SMALL, Served};
use crate::support::scene;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn as_many_come_as_leave_and_nothing_is_missing_or_wrong() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let options =
        "--clients 8 --churn 5 --seconds 4 --ramp 0.2 --rate 30 --groups displacement --decode 1 --tolerate 1";
    let report = load(&served, options).await;
    let (steady, churned) = (&report.load.steady, report.load.churned.unwrap());
    assert!(report.holds, "{:?}", report.why);
    // From up to two rows before the window on.
    assert!((18..=32).contains(&churned.told), "{churned:?}");
    assert_eq!((churned.left, churned.came), (churned.told, churned.told));
    assert_eq!((steady.clients, steady.stayed, steady.faults.total(), &steady.ended[..]), (8, 8, 0, &[][..]));
    let skipped = served.ocean.counters().skipped_frames;
    assert!(steady.gaps <= 8 * skipped, "{} gaps, {skipped} ticks skipped", steady.gaps);
    let without = 8 * 30 * 4;
    assert!((without * 3 / 4..=without + 8 * 4).contains(&(steady.frames + 8 * skipped)), "{} frames", steady.frames);
    assert_eq!(report.load.client_mbps.len(), 8, "a place counts once, whoever had it");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_first_of_each_demand_never_leaves() {
    let output = program("load --url http://127.0.0.1:1 --clients 1 --churn 1".to_owned()).await;
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && said.contains("clients is 1, must be above 1"), "{output:?}");
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let options = "--clients 2 --churn 10 --seconds 2 --ramp 0.1 --groups height --tolerate 1";
    let report = load(&served, options).await;
    assert!(report.holds && report.load.churned.is_some_and(|churned| churned.came > 15), "{report:?}");
    let [least, most] = report.load.client_mbps[..] else { panic!("{report:?}") };
    assert!(least < 0.95 * most, "the second is away now and then: {least} and {most} Mb/s");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_wind_changes_to_and_fro_and_comes_back() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let report = load(&served, "--clients 2 --wind-every 0.8 --seconds 4 --ramp 0.1 --tolerate 1").await;
    assert!(report.holds, "{:?}", report.why);
    let wind = report.load.wind.unwrap();
    assert!((4..=8).contains(&wind.accepted) && wind.failed == 0, "{wind:?}");
    let log = served.get("/v1/scenes/small/log").await.json();
    assert_eq!(log["sequence"], wind.accepted);
    let winds: Vec<_> = log["changes"].as_array().unwrap().iter().map(|change| &change["change"]).collect();
    let (last, others) = winds.split_last().unwrap();
    for (number, wind) in others.iter().enumerate() {
        assert_eq!(wind["speed_mps"], if number % 2 == 0 { 6.0 } else { 10.4 }, "{log}");
        assert_ne!(wind["direction_from_deg"], last["direction_from_deg"]);
    }
    let begun = scene(SMALL).sea.wind.unwrap();
    assert_eq!((&last["speed_mps"], &last["direction_from_deg"]), (&8.0.into(), &begun.direction_from_deg.into()));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_change_of_wind_that_is_refused_is_a_shortcoming_in_the_servers_words() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let body = r#"{"speed_mps": 9, "direction_from_deg": 10, "transition_s": 0}"#;
    while served.http("PUT", "/v1/scenes/small/wind", "", body).await.status == 202 {}
    let report = load(&served, "--clients 1 --wind-every 0.1 --seconds 2 --ramp 0.1 --tolerate 1").await;
    let wind = report.load.wind.unwrap();
    assert!(wind.failed > 0 && wind.accepted > 0, "{wind:?}");
    assert!(!report.holds && report.why.len() == 1, "{:?}", report.why);
    let said = &report.why[0];
    assert!(said.contains("429") && said.contains("more than 64 changes at once, or 2 a second"), "{said}");
    let sequence = served.get("/v1/scenes/small/log").await.json()["sequence"].as_u64().unwrap();
    let last = served.get(&format!("/v1/scenes/small/log?after={}", sequence - 1)).await.json();
    assert_eq!(last["changes"][0]["change"]["speed_mps"], 9.0, "asked for until it was set back");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_comes_coarser_as_the_server_said_is_counted_and_not_wrong() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let options = "--clients 1 --slow 1 --slow-rate 1 --seconds 8 --ramp 0.1 --rate 60 --codec f32 --tolerate 1";
    let report = load(&served, options).await;
    let slow = report.load.slow.as_ref().unwrap();
    assert!(slow.coarser > 0 && slow.faults.total() == 0, "{slow:?}");
    let mut load = report.load;
    assert!(load.steady.coarser == 0 && report.holds, "{:?}", report.why);
    load.steady.coarser_share = 0.5;
    assert!(load.shortcomings(0.4, None).iter().any(|why| why.contains("50.000 % of frames were coarser")));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn memory_that_grows_and_ticks_that_are_skipped_are_shortcomings() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let report = load(&served, "--clients 1 --seconds 4 --ramp 0.1 --flat 1000 --tolerate 1").await;
    assert!(report.holds || cfg!(not(target_os = "linux")), "{:?}", report.why);
    let mut load = report.load;
    assert!(load.server.skipped_share.is_some_and(|share| share < 1.0), "{:?}", load.server);
    assert!(load.server.growth_mib.is_some() || cfg!(not(target_os = "linux")), "{:?}", load.server);
    (load.steady.late_share, load.steady.gap_share) = (0.0, 0.0);
    (load.server.skipped_share, load.server.growth_mib) = (Some(0.02), Some(3.0));
    assert!(load.shortcomings(0.02, Some(3.0)).is_empty());
    let why = load.shortcomings(0.01, Some(2.5));
    assert!(why.len() == 2 && why[0].contains("2.000 % of ticks") && why[1].contains("3.0 MiB"), "{why:?}");
    load.server.growth_mib = None;
    assert!(load.shortcomings(1.0, None).is_empty());
    assert_eq!(load.shortcomings(1.0, Some(5.0)), ["whether the server's memory grows is not known"]);
    served.stop().await;
}

#[test]
fn growth_is_told_from_the_second_quarter_to_the_last() {
    let rows = |of: fn(usize) -> f64| (0..40).map(|row| Some(of(row))).collect::<Vec<_>>();
    assert_eq!(growth(&rows(|_| 7.0)), Some(0.0));
    assert_eq!(growth(&rows(|row| row as f64)), Some(20.0));
    assert_eq!(growth(&rows(|row| -(row as f64))), Some(-20.0));
    assert_eq!(growth(&rows(|row| if row < 10 { row as f64 } else { 9.0 })), Some(0.0), "taken once at the beginning");
    assert_eq!(growth(&rows(|row| if row % 10 < 4 { 100.0 } else { 1.0 })), Some(0.0), "now and then is no growth");
    assert_eq!(growth(&rows(|row| if row < 20 { 1.0 } else { 4.0 })), Some(3.0));
    // Rows of which nothing is known count for nothing.
    let mut rows = rows(|row| row as f64 / 5.0);
    (12..18).for_each(|row| rows[row] = None);
    assert_eq!(growth(&rows), Some(4.0));
    rows[30..].fill(None);
    assert_eq!(growth(&rows), None);
    assert_eq!(growth(&[Some(1.0), Some(2.0), Some(3.0), Some(5.0)]), Some(3.0));
    assert_eq!(growth(&[Some(1.0); 3]), None, "no quarters");
    assert_eq!(growth(&[]), None);
}
