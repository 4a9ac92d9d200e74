//! Laws of the control log: what was acknowledged is kept, in order, whatever happens to the process or the file.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use swellcast::control::{Answer, Epoch, Key, Store, StoreError};
use swellcast::scene::{Change, ChangeKind, Scene, SeaState, preset};

fn change(sequence: u64) -> Change {
    let kind = match sequence % 3 {
        0 => ChangeKind::Water { depth_m: Some(f64::INFINITY), gravity: Some(9.0 + sequence as f64 / 7.0) },
        1 => ChangeKind::Water { depth_m: Some(0.1 + sequence as f64 / 3.0), gravity: None },
        _ => ChangeKind::Wind { speed_mps: 16.0 / 3.0, direction_from_deg: 359.9 },
    };
    Change { sequence, effective_tick: 7200 * sequence as i64, transition_ticks: 3600, kind }
}

fn key(id: &str, request: &str) -> Key {
    Key { id: id.to_owned(), request: request.to_owned() }
}

/// A scene with everything that a file can hold.
fn measured_and_windy() -> Scene {
    let (windy, measured) = (preset("beaufort-3").unwrap(), preset("ndbc-41010").unwrap());
    Scene { sea: SeaState { measured: measured.sea.measured, ..windy.sea.clone() }, ..windy }
}

/// A log in `folder` with `n` changes.
fn written(folder: &Path, n: u64) -> Store {
    let store = Store::open(folder).unwrap();
    store.begin(&measured_and_windy(), Epoch { id: 7, unix_ns: 1_700_000_000_123_456_789 }).unwrap();
    for sequence in 1..=n {
        store.append(&change(sequence), None).unwrap();
    }
    store
}

#[test]
fn a_log_that_is_opened_again_holds_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let before = written(folder.path(), 10).begun().unwrap().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let after = store.begun().unwrap().unwrap();
    assert_eq!(before, after);
    assert_eq!(after.scene, measured_and_windy(), "to the last bit of every number");
    assert_eq!(after.changes, (1..=10).map(change).collect::<Vec<_>>());
    let again = store.begin(&after.scene, Epoch::begin(5)).unwrap();
    assert_eq!(again, after, "the epoch of the first start stands");
    assert_eq!(store.page(3, 4).unwrap(), (4..=7).map(change).collect::<Vec<_>>());
    assert_eq!(store.page(u64::MAX, 4).unwrap(), []);
}

#[test]
fn the_log_of_another_scene_is_not_taken_for_this_one() {
    let folder = tempfile::tempdir().unwrap();
    let store = written(folder.path(), 1);
    let mut other = measured_and_windy();
    other.seed += 1;
    let error = store.begin(&other, Epoch::begin(0)).unwrap_err();
    assert!(error.to_string().contains("to start afresh"), "{error}");
    assert!(matches!(error, StoreError::OtherScene { .. }));
}

#[test]
fn entries_count_from_one_without_a_gap() {
    let store = Store::in_memory().unwrap();
    assert!(matches!(store.append(&change(1), None), Err(StoreError::NotBegun)));
    assert_eq!(store.begun().unwrap(), None);
    store.begin(&preset("beaufort-3").unwrap(), Epoch::begin(0)).unwrap();
    for wrong in [0, 2, u64::MAX] {
        assert!(matches!(store.append(&change(wrong), None), Err(StoreError::OutOfOrder { next: 1, .. })));
    }
    store.append(&change(1), None).unwrap();
    assert!(matches!(store.append(&change(1), None), Err(StoreError::OutOfOrder { got: 1, next: 2 })));
}

#[test]
fn a_request_with_the_same_key_is_answered_once_and_for_all() {
    let folder = tempfile::tempdir().unwrap();
    let store = written(folder.path(), 2);
    let first = store.append(&change(3), Some(&key("a", "x"))).unwrap();
    assert_eq!(first, Answer { sequence: 3, effective_tick: 21_600 });
    assert_eq!(store.append(&change(4), Some(&key("a", "x"))).unwrap(), first);
    drop(store);
    let store = Store::open(folder.path()).unwrap();
    assert_eq!(store.answer(&key("a", "x")).unwrap(), Some(first));
    assert_eq!(store.answer(&key("b", "x")).unwrap(), None);
    assert!(matches!(store.answer(&key("a", "y")), Err(StoreError::KeyReused { .. })));
    assert!(matches!(store.append(&change(4), Some(&key("a", "y"))), Err(StoreError::KeyReused { .. })));
    assert_eq!(store.begun().unwrap().unwrap().changes.len(), 3);
}

#[test]
fn one_folder_serves_one_server() {
    let folder = tempfile::tempdir().unwrap();
    let _store = written(folder.path(), 0);
    let error = Store::open(folder.path()).unwrap_err();
    assert!(matches!(error, StoreError::InUse { .. }), "{error}");
}

#[test]
fn foreign_and_damaged_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    drop(written(folder.path(), 5));
    let path = folder.path().join("swellcast.redb");
    let good = fs::read(&path).unwrap();
    let foreign: [&[u8]; 4] = [b"x", b"SQLite format 3\0", &[0; 8192], &good[..100]];
    for bytes in foreign {
        fs::write(&path, bytes).unwrap();
        let error = Store::open(folder.path()).unwrap_err();
        assert!(error.to_string().contains("swellcast.redb"), "{error}");
    }
    // Cut short or overwritten anywhere: an error, or everything that was acknowledged, but no panic and no guess.
    let mut refused = 0;
    for place in 0..64 {
        let at = good.len() * place / 64;
        let cut = good[..at.max(1)].to_vec();
        let mut overwritten = good.clone();
        overwritten[at..(at + 300).min(good.len())].fill(0xa5);
        for bytes in [cut, overwritten] {
            fs::write(&path, bytes).unwrap();
            match Store::open(folder.path()).and_then(|store| store.begun()) {
                Ok(begun) => assert_eq!(begun.map(|begun| begun.changes.len()), Some(5)),
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > 64, "{refused} of 128");
}

/// Not a test of its own: the process that the test below kills.
#[test]
#[ignore = "runs inside killed_at_any_moment"]
fn writes_until_killed() {
    let Ok(folder) = std::env::var("SWELLCAST_TEST_FOLDER") else { return };
    let store = Store::open(Path::new(&folder)).unwrap();
    let begun = store.begin(&preset("beaufort-3").unwrap(), Epoch::begin(0)).unwrap();
    for sequence in begun.changes.len() as u64 + 1.. {
        store.append(&change(sequence), None).unwrap();
        println!("acknowledged {sequence}");
    }
}

#[test]
fn killed_at_any_moment_the_log_keeps_what_it_acknowledged() {
    let folder = tempfile::tempdir().unwrap();
    let mut acknowledged = 0;
    for lines in [1, 2, 5, 17] {
        let mut writer = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "control::writes_until_killed", "--ignored", "--nocapture"])
            .env("SWELLCAST_TEST_FOLDER", folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let output = BufReader::new(writer.stdout.take().unwrap()).lines();
        let said = output.map_while(Result::ok).filter_map(|line| {
            line.split_once("acknowledged ").and_then(|(_, sequence)| sequence.trim().parse::<u64>().ok())
        });
        acknowledged = said.take(lines).last().unwrap();
        writer.kill().unwrap();
        writer.wait().unwrap();
        let kept = Store::open(folder.path()).unwrap().begun().unwrap().unwrap().changes;
        assert!(kept.len() as u64 >= acknowledged, "{} kept, {acknowledged} acknowledged", kept.len());
        assert_eq!(kept, (1..=kept.len() as u64).map(change).collect::<Vec<_>>());
    }
    assert!(acknowledged >= 25);
}

#[test]
fn time_that_was_reached_is_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let store = written(folder.path(), 1);
    assert_eq!(store.begun().unwrap().unwrap().reached_tick, 0);
    store.reach(4711).unwrap();
    drop(store);
    assert_eq!(Store::open(folder.path()).unwrap().begun().unwrap().unwrap().reached_tick, 4711);
}

#[test]
fn an_entry_that_no_server_would_have_accepted_is_damage() {
    let folder = tempfile::tempdir().unwrap();
    let store = written(folder.path(), 2);
    let kind = ChangeKind::Water { depth_m: Some(-1.0), gravity: None };
    store.append(&Change { sequence: 3, effective_tick: 1, transition_ticks: 0, kind }, None).unwrap();
    assert!(store.begun().unwrap_err().to_string().contains("entry 3"));
}
