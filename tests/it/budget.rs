//! A budget of milliseconds: the settings that there are, what they err, what is picked of them, and how a served sea gets
//! there. Times are this machine's, and nothing here depends on them.

use std::collections::BTreeSet;
use std::time::Duration;

use serde_json::{Value, json};
use swellcast::accuracy::serving::{Measuring, Setting, Unmeasured, errors, measure, settings};
use swellcast::accuracy::{Axis, Cost, Errors, Measure, Point};
use swellcast::backend::{Backend, Cpu};
use swellcast::control::{Epoch, Store};
use swellcast::engine::{Clock, Times, lost_between};
use swellcast::scene::{Model, PRESETS, Scene, preset};
use swellcast::sea::{Layout, Timeline};
use swellcast::server::{Ocean, Settings};

use crate::served::{PATIENCE, Served};
use crate::support::scene;

const BUDGET: &str = "/v1/scenes/tiny/budget";
const LAYOUT: &str = "/v1/scenes/tiny/layout";
/// A sea of which a frame takes next to nothing.
const TINY: &str = "name = \"tiny\"\n[wind]\nspeed_mps = 8\n[cascades]\nn = 32\npatches_m = [60]\n\
                    [effects]\nslopes = false\nnormals = \"none\"\njacobian = false\nvelocity = false\nfoam = false\n";
/// More than any setting of it can take.
const AMPLE: f64 = 1000.0;

fn of(settings: &[Setting], patches: usize, n: usize) -> Option<&Setting> {
    settings.iter().find(|setting| setting.cascades.patches_m.len() == patches && setting.cascades.n == Some(n))
}

#[test]
fn every_setting_of_every_preset_can_be_a_change() {
    for (name, _) in PRESETS {
        let scene = preset(name).unwrap();
        let settings = settings(&scene);
        assert!(settings.len() >= 6, "{name}: {}", settings.len());
        let names: BTreeSet<&str> = settings.iter().map(|setting| setting.name.as_str()).collect();
        assert_eq!(names.len(), settings.len(), "{name}: no two have one name");
        let own = Layout::of(&scene).cascades;
        for setting in &settings {
            let change = setting.change().check().unwrap_or_else(|error| panic!("{name}, {}: {error}", setting.name));
            change.fits(&scene).unwrap();
            let cascades = Layout::of(&setting.of(&scene)).cascades;
            assert_eq!(cascades.len(), setting.cascades.patches_m.len());
            assert!(cascades.last().unwrap().shortest_m() >= setting.finest_m * 0.999_999, "{name}, {}", setting.name);
            assert!(scene.model == Model::Fft || cascades.len() == 1, "{name}: trochoids have one patch");
        }
        // The layout that the scene asks for is among them.
        let mut layouts = settings.iter().map(|setting| Layout::of(&setting.of(&scene)).cascades);
        assert!(layouts.any(|cascades| cascades == own), "{name}");
    }
}

#[test]
fn waves_that_are_added_take_error_away_and_every_run_finds_the_same() {
    let scene = preset("beaufort-5").unwrap();
    let settings = settings(&scene);
    let mut last = Errors { height_rms: Some(1.0), ..Errors::default() };
    for patches in 1..=5 {
        let setting = of(&settings, patches, 64).unwrap();
        let found = errors(&scene, setting, 7200);
        assert_eq!(found, errors(&scene, setting, 7200), "{}", setting.name);
        assert!(found.height_rms < last.height_rms, "{}: {found:?} after {last:?}", setting.name);
        assert!(patches == 1 || found.position_mm < last.position_mm, "{}: {found:?} after {last:?}", setting.name);
        assert!(patches == 1 || found.normal_deg < last.normal_deg, "{}: {found:?} after {last:?}", setting.name);
        last = found;
    }
    // What a layout leaves out is the energy that its modes lack: nearly all that one patch of this many samples errs.
    let one = of(&settings, 1, 128).unwrap();
    let timeline = Timeline::uncalibrated(&one.of(&scene));
    let lacks = 1.0 - (timeline.hs_at(7200) / timeline.wanted_hs_at(7200)).powi(2);
    let (law, found) = (0.25 * lacks.sqrt(), errors(&scene, one, 7200).height_rms.unwrap());
    assert!((found / law - 1.0).abs() < 0.1, "{found} beside {law}");
    // Nearly all of the sea, on a sixteenth of the samples that the scene asks for.
    assert!(last.height_rms.unwrap() < 0.002, "{last:?}");
    let finer = errors(&scene, of(&settings, 5, 128).unwrap(), 7200);
    assert!(finer.height_rms < last.height_rms && finer.normal_deg < last.normal_deg, "{finer:?} after {last:?}");
}

#[test]
fn trochoids_are_held_to_themselves_and_a_sea_without_normals_has_no_error_of_them() {
    let (scene, bare) = (preset("trochoid").unwrap(), scene(TINY));
    let (coarse, fine) = (settings(&scene), settings(&bare));
    let height = |n: usize| errors(&scene, of(&coarse, 1, n).unwrap(), 0).height_rms.unwrap();
    assert!(height(128) < height(64) && height(256) < height(128));
    let found = errors(&bare, of(&fine, 1, 32).unwrap(), 0);
    assert!(found.normal_deg.is_none() && found.height_rms.is_some(), "{found:?}");
}

#[test]
fn what_is_lost_between_samples_grows_with_the_phase_from_one_to_the_next() {
    let lost: Vec<f64> = (0..=32).map(|i| lost_between([std::f64::consts::PI * f64::from(i) / 32.0, 0.0])).collect();
    // The kernel is best about nine samples a wave, better than a little longer: by a millionth.
    assert!(lost[0].abs() < 1e-12 && lost.windows(2).all(|pair| pair[0] <= pair[1] + 1e-6), "{lost:?}");
    // Six samples a wave: a percent of the amplitude; two: no less than half of the energy.
    assert!(lost_between([std::f64::consts::PI / 3.0, 0.0]).sqrt() < 0.02, "{lost:?}");
    assert!(lost[32] > 0.4, "{lost:?}");
    let (x, z) = (lost_between([2.0, 1.5]), lost_between([1.5, 2.0]));
    assert!((x - z).abs() < 1e-12 && x > lost_between([2.0, 0.0]));
}

#[test]
fn a_larger_budget_is_never_less_accurate_and_no_budget_is_overdrawn() {
    let point = |(i, p95_ms): (usize, &f64)| Point {
        setting: i.to_string(),
        // Every third is worse than the one before, and dearer: not on the front.
        errors: Errors { height_rms: Some(0.5_f64.powi(if i % 3 == 2 { 0 } else { i as i32 })), ..Errors::default() },
        time: Some(Times { median_ms: *p95_ms, lower_ms: *p95_ms, upper_ms: *p95_ms, p95_ms: *p95_ms }),
        bytes_per_s: None,
        memory_bytes: None,
        front: false,
    };
    let points = [0.1, 0.3, 0.4, 0.7, 1.5, 1.6, 2.9, 6.3, 30.0].iter().enumerate().map(point).collect();
    let mut axis =
        Axis { name: String::new(), about: String::new(), measure: Measure::Height, cost: Cost::Time, points };
    axis.mark_front();
    let front: Vec<bool> = axis.points.iter().map(|point| point.front).collect();
    assert_eq!(front, [true, true, false, true, true, false, true, true, false], "what another beats is not on it");
    let mut last = f64::INFINITY;
    for budget in [0.5, 1.0, 2.0, 4.0, 8.0] {
        let picked = axis.best_within(budget).unwrap();
        assert!(picked.front && picked.time.unwrap().p95_ms <= 0.8 * budget, "{budget}: {picked:?}");
        let error = picked.errors.height_rms.unwrap();
        assert!(error < last, "{budget}: {error} after {last}");
        last = error;
    }
    assert_eq!(axis.best_within(0.1), None);
}

fn measured(scene: &Scene, most_ms: f64, goes_on: &mut dyn FnMut(usize, usize) -> bool) -> Result<Axis, Unmeasured> {
    let clock = Clock::start(Clock::unix_now_ns());
    let open = || Ok(Box::new(Cpu::new(Some(1))) as Box<dyn Backend>);
    let mut measuring = Measuring { clock: &clock, open: &open, most_backends: usize::MAX, most_ms, goes_on };
    measure(scene, &settings(scene), 0, &mut measuring)
}

#[test]
fn what_is_measured_of_a_setting_is_its_own_but_for_the_times() {
    let scene = scene(&TINY.replace("foam = false", "foam = true").replace("n = 32", "n = 16"));
    let mut told = Vec::new();
    let axis = measured(&scene, AMPLE, &mut |done, of| {
        told.push((done, of));
        true
    });
    let axis = axis.unwrap();
    let known = settings(&scene);
    assert!(axis.points.iter().map(|point| &point.setting).eq(known.iter().map(|setting| &setting.name)));
    assert!(told.iter().is_sorted() && told.iter().all(|(done, of)| done < of && *of == known.len()));
    for (point, setting) in axis.points.iter().zip(&known) {
        assert_eq!(point.errors, errors(&scene, setting, 0), "{}", setting.name);
        assert!(point.time.is_some_and(|time| time.p95_ms >= time.median_ms && time.median_ms > 0.0));
        assert!(point.memory_bytes > Some(0));
    }
    // More samples are more bytes.
    let bytes = |patches, n| {
        let name = &of(&known, patches, n).unwrap().name;
        axis.points.iter().find(|point| point.setting == *name).unwrap().bytes_per_s.unwrap()
    };
    assert!(bytes(1, 64) > bytes(1, 32) && bytes(2, 64) > bytes(1, 64));
    // Where nothing may take any time the cheapest is still there to be had.
    let least = measured(&scene, 0.0, &mut |_, _| true).unwrap();
    assert_eq!(least.points.iter().filter(|point| point.time.is_some()).count(), 1);
    assert!(least.points.iter().zip(&axis.points).all(|(least, point)| least.errors == point.errors));
    assert_eq!(measured(&scene, AMPLE, &mut |done, _| done < 3), Err(Unmeasured::Stopped));
}

fn settings_with(budget_ms: Option<f64>) -> Settings {
    Settings { budget_ms, ..Settings::default() }
}

/// The budget's state when it is no longer being measured, and what was picked is in force.
async fn settled(served: &Served) -> Value {
    let wait = async {
        loop {
            let told = served.get(BUDGET).await.json();
            if told["state"] != "measuring" && told["in_force"] != false {
                return told;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    tokio::time::timeout(4 * PATIENCE, wait).await.expect("something is picked")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_budget_brings_the_sea_to_what_it_picks_through_the_log() {
    let served = Served::start(&scene(TINY), settings_with(Some(AMPLE))).await;
    let mut client = served.client().await;
    assert_eq!(client.text("hello").await["layout"]["generation"], 0);
    // In the order in which they come: the change, then a hello with the cascades that are to be.
    let wait = async {
        let change = client.text("change").await;
        (change, client.text("hello").await)
    };
    let told = settled(&served).await;
    let (change, hello) = tokio::time::timeout(4 * PATIENCE, wait).await.expect("clients are told");
    assert_eq!((&told["state"], &told["budget_ms"]), (&json!("picked"), &json!(AMPLE)), "{told}");
    assert_eq!((&told["sequence"], &told["effective_tick"]), (&change["sequence"], &change["effective_tick"]));
    assert_eq!((&change["change"]["kind"], &change["change"]["n"]), (&json!("layout"), &told["cascades"]["n"]));
    assert_eq!(change["change"]["patches_m"], told["cascades"]["patches_m"]);
    assert_eq!(hello["layout"]["generation"], 1);
    assert_eq!(
        hello["layout"]["cascades"].as_array().unwrap().len(),
        1 + told["cascades"]["patches_m"].as_array().unwrap().len()
    );
    // With so much time it gives nothing up.
    assert_eq!(told["gives_up"], Value::Null, "{told}");
    assert!(told["p95_ms"].as_f64() > Some(0.0) && told["errors"]["height_rms"].is_number(), "{told}");
    let log = served.get("/v1/scenes/tiny/log").await.json();
    assert_eq!(log["changes"].as_array().unwrap().len(), 1, "{log}");

    // What was measured serves another budget at once.
    let other = served.http("PUT", BUDGET, "", r#"{"budget_ms":900}"#).await;
    assert_eq!(
        (other.status, &other.json()["state"], &other.json()["in_force"]),
        (202, &json!("picked"), &json!(true))
    );
    let off = served.http("PUT", BUDGET, "", r#"{"budget_ms":null}"#).await;
    assert_eq!((off.status, off.json()), (202, json!({ "budget_ms": null, "state": "off" })), "{off:?}");
    assert_eq!(served.get("/v1/scenes/tiny/log").await.json()["changes"].as_array().unwrap().len(), 1, "it stays");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_budget_that_can_not_be_is_refused_by_name() {
    let served = Served::start(&scene(TINY), settings_with(None)).await;
    for (body, status, kind, field) in [
        ("", 400, "not-json", ""),
        ("[4]", 422, "invalid-value", ""),
        ("{}", 422, "missing-field", "budget_ms"),
        (r#"{"budget_ms":"4"}"#, 422, "invalid-value", "budget_ms"),
        (r#"{"budget_ms":0.09}"#, 422, "invalid-value", "budget_ms"),
        (r#"{"budget_ms":-1}"#, 422, "invalid-value", "budget_ms"),
        (r#"{"budget_ms":1000.1}"#, 422, "invalid-value", "budget_ms"),
        (r#"{"budget_ms":1e300}"#, 422, "invalid-value", "budget_ms"),
        (r#"{"budget_ms":4,"slower":2}"#, 422, "unknown-field", "slower"),
    ] {
        let answer = served.http("PUT", BUDGET, "", body).await;
        let problem = answer.json();
        assert_eq!(answer.status, status, "{body}: {answer:?}");
        assert_eq!(problem["type"], format!("urn:swellcast:problem:{kind}"), "{body}: {answer:?}");
        assert_eq!(problem["field"].as_str().unwrap_or_default(), field, "{body}: {answer:?}");
    }
    assert_eq!(served.http("POST", BUDGET, "", "{}").await.status, 405);
    assert_eq!(served.get("/v1/scenes/other/budget").await.status, 404);
    assert_eq!(served.get(BUDGET).await.json(), json!({ "budget_ms": null, "state": "off" }), "nothing was begun");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_operator_has_the_last_word() {
    let served = Served::start(&scene(TINY), settings_with(None)).await;
    let wish = r#"{"budget_ms":1000}"#;
    let asked = served.http("PUT", BUDGET, "", wish).await;
    assert_eq!((asked.status, &asked.json()["state"]), (202, &json!("measuring")), "{asked:?}");
    // Before anything is picked: the layout is the operator's from here on.
    let by_hand = served.http("PUT", LAYOUT, "", r#"{"n":16,"patches_m":[50],"transition_s":1}"#).await;
    assert_eq!(by_hand.status, 202, "{by_hand:?}");
    let told = settled(&served).await;
    assert_eq!((&told["state"], &told["budget_ms"]), (&json!("overridden"), &json!(1000.0)), "{told}");
    // Set again, it counts again, and waits until the layout has settled. Set for something unmeasured, it is too soon.
    let mut again = served.http("PUT", BUDGET, "", wish).await;
    while again.status == 429 {
        assert_eq!(again.json()["type"], "urn:swellcast:problem:too-fast", "{again:?}");
        assert_eq!(again.header("retry-after"), Some("10"));
        tokio::time::sleep(Duration::from_millis(500)).await;
        again = served.http("PUT", BUDGET, "", wish).await;
    }
    assert_eq!(again.status, 202, "{again:?}");
    let mut state = again.json();
    while state["state"] == "measuring" {
        tokio::time::sleep(Duration::from_millis(100)).await;
        state = served.get(BUDGET).await.json();
    }
    assert_eq!((&state["state"], &state["in_force"]), (&json!("picked"), &json!(false)), "{state}");
    assert_eq!(served.get("/v1/scenes/tiny/log").await.json()["changes"].as_array().unwrap().len(), 1);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_restarted_server_finds_its_pick_in_force() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = Vec::new();
    for _ in 0..2 {
        let store = Store::open(folder.path()).unwrap();
        let begun = store.begin(&scene(TINY), Epoch::begin(Clock::unix_now_ns())).unwrap();
        let served = Served::of(Ocean::start(store, begun, settings_with(Some(AMPLE)))).await;
        let told = settled(&served).await;
        assert_eq!(told["state"], "picked", "{told}");
        let changes = served.get("/v1/scenes/tiny/log").await.json()["changes"].as_array().unwrap().len();
        seen.push((told["setting"].clone(), told["errors"].clone(), changes));
        served.stop().await;
    }
    assert_eq!((&seen[0].0, seen[0].2), (&seen[1].0, 1));
    assert_eq!(seen[1].2, 1, "nothing was to be changed");
}
