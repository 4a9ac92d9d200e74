//! A change of layout cross-fades: energy stays level, no point jumps, and every server agrees on both seas.

use swellcast::backend::{Backend, Cpu};
use swellcast::control::{Epoch, Store};
use swellcast::plan::Field;
use swellcast::scene::{CascadesFile, Change, ChangeKind, KEEP_TICKS, Scene};
use swellcast::sea::{CascadeModes, Timeline};

use crate::support::{plan, scene};

const SECOND: i64 = 7200;
const FRAME: i64 = 240;

pub fn layout(sequence: u64, at: i64, seconds: i64, n: usize, patches_m: &[f64]) -> Change {
    let cascades = CascadesFile { n: Some(n), patches_m: patches_m.to_vec(), ..CascadesFile::default() };
    let kind = ChangeKind::Layout { cascades, wind_range_mps: None };
    Change { sequence, effective_tick: at, transition_ticks: seconds * SECOND, kind }
}

fn wind(sequence: u64, at: i64, seconds: i64, speed_mps: f64) -> Change {
    let kind = ChangeKind::Wind { speed_mps, direction_from_deg: 210.0 };
    Change { sequence, effective_tick: at, transition_ticks: seconds * SECOND, kind }
}

fn water(sequence: u64, at: i64, depth_m: Option<f64>, gravity: Option<f64>) -> Change {
    Change { sequence, effective_tick: at, transition_ticks: 0, kind: ChangeKind::Water { depth_m, gravity } }
}

fn windy(cascades: &str) -> Scene {
    scene(&format!("name = \"t\"\n[wind]\nspeed_mps = 9\nrange_mps = [2.0, 20.0]\n[cascades]\n{cascades}"))
}

fn patched() -> Scene {
    windy("n = 128\npatches_m = [600.0, 90.0]")
}

/// What is part of the sea of a tick: a server may have forgotten what is not.
fn there(timeline: &Timeline, tick: i64) -> Vec<CascadeModes> {
    let lives: Vec<_> = timeline.lives().collect();
    let cascades = timeline.at(tick).cascades.into_iter().zip(lives);
    cascades.filter(|(_, life)| life.contains(tick)).map(|(cascade, _)| cascade).collect()
}

/// Energy of the waves that were drawn, m^2.
fn drawn(cascades: &[CascadeModes]) -> f64 {
    let energy = |cascade: &CascadeModes| -> f64 {
        let modes = cascade.with_wave_vectors();
        modes
            .map(|(kx, _, m)| (if kx == 0.0 { 1.0 } else { 2.0 }) * (m.forward.norm_sqr() + m.backward.norm_sqr()))
            .sum()
    };
    cascades.iter().map(energy).sum()
}

#[test]
fn energy_stays_level_while_one_layout_gives_way_to_another() {
    let at = 100 * SECOND + 77;
    let before = Timeline::new(&patched());
    let timeline = before.with(layout(1, at, 10, 128, &[500.0, 70.0]), at);
    let steady = before.hs_at(at);
    let (old, new) = (drawn(&there(&timeline, at - 1)), drawn(&there(&timeline, at + 20 * SECOND)));
    for tick in (at - SECOND..at + 12 * SECOND).step_by(331) {
        let hs = timeline.hs_at(tick);
        assert!((hs / steady - 1.0).abs() < 0.01, "Hs is {hs} m at {tick}, {steady} m before");
        // The waves themselves: one draw has more or less energy than the other, and nothing between falls below both.
        let energy = drawn(&there(&timeline, tick));
        assert!(energy > 0.9999 * old.min(new) && energy < 1.0001 * old.max(new), "{energy} of {old} and {new} m^2");
    }
    assert_eq!(timeline.hs_at(at), steady, "it begins with nothing of the new one");
}

#[test]
fn cascades_of_two_layouts_have_nothing_in_common_but_their_spectrum() {
    let at = 100 * SECOND;
    // The very same patches again.
    let timeline = Timeline::new(&patched()).with(layout(1, at, 2, 128, &[600.0, 90.0]), at);
    let (old, new) = (there(&timeline, at - 1), there(&timeline, at + 10 * SECOND));
    assert_eq!((old.len(), new.len(), there(&timeline, at + SECOND).len()), (2, 2, 4));
    for (old, new) in old.iter().zip(&new) {
        let product: f64 = old.modes.iter().zip(&new.modes).map(|(a, b)| (a.forward * b.forward.conj()).re).sum();
        let norm = |c: &CascadeModes| c.modes.iter().map(|m| m.forward.norm_sqr()).sum::<f64>().sqrt();
        assert!(product.abs() < 0.2 * norm(old) * norm(new), "correlated by {}", product / norm(old) / norm(new));
        assert!((norm(new) / norm(old) - 1.0).abs() < 0.3);
    }
}

/// Largest change of the summed height of any grid point from one frame to the next, over some frames.
fn largest_step(timeline: &Timeline, from: i64, frames: i64) -> f32 {
    let (mut cpu, mut before, mut largest) = (Cpu::new(Some(2)), Vec::<f32>::new(), 0.0_f32);
    for tick in (0..=frames).map(|frame| from + frame * FRAME) {
        let sea = timeline.at(tick);
        cpu.load(&sea).unwrap();
        let surface = cpu.step(tick, &plan(&sea, &[Field::Height])).unwrap();
        let mut height = vec![0.0; 128 * 128];
        for cascade in &surface.cascades {
            height.iter_mut().zip(cascade.plane(Field::Height).unwrap()).for_each(|(sum, h)| *sum += h);
        }
        let moved = before.iter().zip(&height).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        (before, largest) = (height, largest.max(moved));
    }
    largest
}

#[test]
fn a_change_of_layout_moves_no_point_faster_than_a_steady_sea_does() {
    let at = 100 * SECOND;
    let timeline = Timeline::new(&patched()).with(layout(1, at, 5, 128, &[500.0, 70.0]), at);
    let steady = largest_step(&timeline, at - 200 * FRAME, 190).max(largest_step(&timeline, at + 6 * SECOND, 190));
    let changing = largest_step(&timeline, at - 5 * FRAME, 175);
    println!("{changing:.4} m a frame, steady {steady:.4}");
    assert!(changing <= 1.2 * steady, "{changing} m a frame while the layout changes, {steady} m before and after");
}

#[track_caller]
fn same(a: &Timeline, b: &Timeline, seconds: impl IntoIterator<Item = i64>) {
    for second in seconds {
        let tick = second * SECOND;
        assert!(there(a, tick) == there(b, tick), "the seas differ after {second} s");
        assert_eq!(a.scene_at(tick), b.scene_at(tick));
        let (of_a, of_b) = (a.sequence_at(tick), b.sequence_at(tick));
        assert_eq!((a.generation_at(tick), of_a), (b.generation_at(tick), of_b), "after {second} s");
        assert_eq!(a.hs_at(tick), b.hs_at(tick));
    }
}

#[test]
fn both_seas_are_the_same_on_every_server_whenever_it_read_the_log() {
    let scene = windy("n = 64");
    let log = [
        wind(1, 95 * SECOND, 20, 14.0),
        water(2, 20 * SECOND, Some(18.0), None),
        layout(3, 100 * SECOND, 10, 64, &[]),
        // Accepted after the layout, one to act before it and others in the midst of the cross-fade.
        water(4, 50 * SECOND, None, Some(9.0)),
        water(5, 104 * SECOND, Some(25.0), None),
        wind(6, 105 * SECOND, 60, 11.0),
        water(7, 139 * SECOND, Some(f64::INFINITY), Some(9.81)),
        layout(8, 160 * SECOND, 5, 64, &[300.0, 40.0]),
        water(9, 170 * SECOND, Some(12.0), None),
    ];
    let all = log.iter().fold(Timeline::new(&scene), |timeline, change| timeline.with(change.clone(), 0));
    let mut shuffled = log.clone();
    shuffled.reverse();
    same(&all, &Timeline::replay(&scene, &shuffled, 0), [0, 49, 50, 99, 100, 104, 107, 120, 159, 162, 170, 200]);
    // One that lived through it all, forgetting on the way; changes become known before they act.
    let mut lived = Timeline::replay(&scene, &log[..3], 10 * SECOND);
    for (change, accepted) in log[3..].iter().zip([48, 103, 104, 138, 158, 169]) {
        lived = lived.with(change.clone(), accepted * SECOND);
    }
    // Late servers, which forgot what was over before they began.
    for now in [0, 103, 129, 138, 163, 169, 185, 205, 230, 400] {
        let late = Timeline::replay(&scene, &log, now * SECOND);
        let after = [0, 1, 2, 5, 30, 60, 400].map(|later| now + later).into_iter();
        same(&all, &late, after.clone().chain([now - 10]));
        same(&lived, &late, after.filter(|second| *second >= 169));
    }
    let kept = Timeline::replay(&scene, &log, 400 * SECOND);
    assert_eq!((kept.lives().count(), kept.layout().generation), (2, 2), "one layout is left");
}

#[test]
fn a_layout_that_ended_is_forgotten_when_foam_has() {
    let (at, fade) = (100 * SECOND, 2);
    let timeline = Timeline::new(&patched()).with(layout(1, at, fade, 128, &[500.0, 70.0]), at);
    let over = at + fade * SECOND + 1440 + KEEP_TICKS;
    assert!(timeline.without_ended(over - 1).is_none(), "foam may remember it");
    let later = timeline.without_ended(over).unwrap();
    assert_eq!((timeline.lives().count(), later.lives().count(), later.layout().generation), (4, 2, 1));
    assert!(there(&timeline, over) == there(&later, over));
    assert_eq!(later.layout_settled(), over, "from then on another can come");
}

#[test]
fn what_is_accepted_later_does_not_change_an_automatic_layout() {
    let scene = windy("n = 64");
    let automatic = layout(1, 100 * SECOND, 10, 64, &[]);
    let timeline = Timeline::new(&scene).with(automatic.clone(), 0);
    // Shallow water has shorter waves: a layout made for it would be another.
    let shallow = water(2, 50 * SECOND, Some(2.0), None);
    let later = timeline.with(shallow.clone(), 0);
    assert_eq!(timeline.layout(), later.layout());
    let before = Timeline::new(&scene).with(Change { sequence: 1, ..shallow }, 0);
    assert_ne!(before.with(Change { sequence: 2, ..automatic }, 0).layout(), later.layout());
}

#[test]
fn each_entry_is_checked_against_what_is_in_effect_at_its_tick() {
    let scene = patched();
    let narrow = Change {
        kind: ChangeKind::Layout { cascades: CascadesFile::default(), wind_range_mps: Some([5.0, 10.0]) },
        ..layout(1, 100 * SECOND, 10, 64, &[])
    };
    let timeline = Timeline::new(&scene).with(narrow.clone(), 0);
    let fault = |change: &Change| timeline.check(change).map_err(|(sequence, error)| (sequence, error.to_string()));
    assert_eq!(fault(&wind(2, 50 * SECOND, 0, 6.0)), Ok(()));
    assert_eq!(fault(&wind(2, 150 * SECOND, 0, 6.0)), Ok(()));
    let (at, why) = fault(&wind(2, 150 * SECOND, 0, 15.0)).unwrap_err();
    assert!(at == 2 && why.contains("from 5 to 10"), "{at}: {why}");
    let (at, why) = fault(&wind(2, 50 * SECOND, 0, 15.0)).unwrap_err();
    assert!(at == 1 && why.contains("15 m/s"), "the layout could no longer come: {at}: {why}");
    let again = timeline.with(wind(2, 80 * SECOND, 0, 7.0), 0);
    assert!(again.check(&wind(3, 50 * SECOND, 0, 15.0)).is_ok(), "the wind is back in time");
    // In a log, layouts stand apart; and what it says of winds holds for the whole of it.
    let near = layout(2, 110 * SECOND + 1440 + KEEP_TICKS - 1, 1, 64, &[]);
    assert!(Change::check_course(&scene, [&narrow, &near]).unwrap_err().1.to_string().contains("effective_tick"));
    let apart = Change { effective_tick: near.effective_tick + 1, ..near };
    assert_eq!(Change::check_course(&scene, [&narrow, &apart]), Ok(()));
    let strong = wind(3, 500 * SECOND, 0, 15.0);
    assert_eq!(Change::check_course(&scene, [&strong, &narrow, &apart]).unwrap_err().0, 3);
    let cut = Change { transition_ticks: 7199, ..layout(1, 0, 1, 64, &[]) };
    assert!(Change::check_course(&scene, [&cut]).is_err(), "no fade is shorter than a second");
}

#[test]
fn a_log_is_read_in_the_order_in_which_it_acts() {
    let narrow = |sequence, at| {
        let kind = ChangeKind::Layout { cascades: CascadesFile::default(), wind_range_mps: Some([5.0, 10.0]) };
        Change { kind, ..layout(sequence, at, 10, 64, &[]) }
    };
    let written = |log: &[Change]| {
        let store = Store::in_memory().unwrap();
        store.begin(&patched(), Epoch::begin(0)).unwrap();
        for change in log {
            store.append(change, None).unwrap();
        }
        store.begun().map(|begun| begun.unwrap().changes)
    };
    // Accepted after the layout, but to act before it, when stronger winds could still be; and calm again in time.
    let good = [narrow(1, 100 * SECOND), wind(2, 50 * SECOND, 0, 15.0), wind(3, 90 * SECOND, 0, 8.0)];
    assert_eq!(written(&good).unwrap(), good);
    assert!(written(&good[..2]).unwrap_err().to_string().contains("entry 1"));
    let late = [narrow(1, 100 * SECOND), wind(2, 150 * SECOND, 0, 15.0)];
    assert!(written(&late).unwrap_err().to_string().contains("entry 2"));
}

#[test]
fn an_entry_of_an_older_version_means_what_it_meant() {
    let read = |text: &str| serde_json::from_str::<ChangeKind>(text).unwrap();
    for (text, depth_m, gravity) in [
        (r#"{"kind":"water","depth_m":15}"#, Some(15.0), None),
        (r#"{"kind":"water","depth_m":null}"#, Some(f64::INFINITY), None),
        (r#"{"kind":"water","gravity":3.7}"#, None, Some(3.7)),
        (r#"{"kind":"water","depth_m":null,"gravity":3.7}"#, Some(f64::INFINITY), Some(3.7)),
    ] {
        let kind = read(text);
        assert_eq!(kind, ChangeKind::Water { depth_m, gravity }, "{text}");
        assert_eq!(read(&serde_json::to_string(&kind).unwrap()), kind);
    }
    assert!(read(r#"{"kind":"water"}"#).check().is_err(), "it sets nothing");
    for gravity in [0.09, 100.1, f64::NAN] {
        assert!(ChangeKind::Water { depth_m: None, gravity: Some(gravity) }.check().is_err());
    }
    let log = layout(1, 0, 1, 64, &[300.0, 40.1]);
    assert_eq!(read(&serde_json::to_string(&log.kind).unwrap()), log.kind);
    assert!(serde_json::from_str::<ChangeKind>(r#"{"kind":"layout","cascades":{"m":64}}"#).is_err());
}
