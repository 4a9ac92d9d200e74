//! Every number of a scene, in turn, as anything that a file can say.

use serde_json::Value;
use swellcast::scene::{Detail, MeasuredFile, PRESETS, ReplayFile, SceneFile, Swell, WindFile};
use swellcast::wire::Group;

use super::{build, holds};
use crate::support::DAY;

/// What a number may turn out to be.
const ANYTHING: [f64; 12] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 0.0, 5e-324, -5e-324, f64::MIN_POSITIVE, 1e308, -1.0, 1e-9, 3.5];

/// A scene in which every field is there.
fn whole() -> SceneFile {
    let bins = vec![vec![0.1, 2.0, 90.0, 95.0, 0.8, 0.5], vec![0.2, 1.0]];
    let mut file = SceneFile {
        name: "anything".to_owned(),
        loop_s: Some(600.0),
        wind: Some(WindFile { hs_m: Some(2.0), spreading: Some(Default::default()), ..WindFile::default() }),
        swell: vec![Swell::default()],
        measured: Some(MeasuredFile {
            bins: bins.clone(),
            replay: Some(ReplayFile { records: vec![bins], transition_s: 1.0, ..ReplayFile::default() }),
            ..MeasuredFile::default()
        }),
        ..SceneFile::from_toml(PRESETS[0].1).unwrap()
    };
    file.detail = vec![Detail { cascade: 0, group: Group::Slopes, finest_level: 1, rate_hz: Some(30) }];
    file.water.depth_m = Some(50.0);
    file.cascades.n = Some(16);
    file.cascades.patches_m = vec![200.0];
    file
}

/// Paths of all numbers below a value.
fn numbers(value: &toml::Value, path: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    match value {
        toml::Value::Float(_) => found.push(path.clone()),
        toml::Value::Table(table) => {
            for (key, value) in table {
                path.push(key.clone());
                numbers(value, path, found);
                path.pop();
            }
        }
        toml::Value::Array(array) => {
            for (i, value) in array.iter().enumerate() {
                path.push(i.to_string());
                numbers(value, path, found);
                path.pop();
            }
        }
        _ => {}
    }
}

fn at<'a>(value: &'a mut toml::Value, path: &[String]) -> &'a mut toml::Value {
    path.iter().fold(value, |value, key| match value {
        toml::Value::Array(array) => &mut array[key.parse::<usize>().unwrap()],
        value => &mut value[key.as_str()],
    })
}

#[test]
fn any_number_anywhere_is_refused_by_name_or_makes_a_sea_that_holds() {
    let whole = toml::Value::try_from(whole()).unwrap();
    let mut paths = Vec::new();
    numbers(&whole, &mut Vec::new(), &mut paths);
    assert!(paths.len() > 40, "{} numbers", paths.len());
    let (mut held, mut refused) = (0, 0);
    for path in &paths {
        for number in ANYTHING {
            let mut changed = whole.clone();
            *at(&mut changed, path) = toml::Value::Float(number);
            // Calibrating foam costs more than all the rest: only where foam's own numbers are changed.
            let foam = path[path.len() - 1].starts_with("foam");
            *at(&mut changed, &["effects".to_owned(), "foam".to_owned()]) = toml::Value::Boolean(foam);
            let text = toml::to_string(&changed).unwrap();
            match SceneFile::from_toml(&text).and_then(build) {
                Ok(scene) => {
                    holds(&scene, &[DAY]).unwrap_or_else(|why| panic!("{} = {number}: {why}", path.join(".")));
                    held += 1;
                }
                Err(error) => {
                    let field = error.field().unwrap_or_else(|| panic!("{} = {number}: {error}", path.join(".")));
                    // The error names the table at least; a row of a record is named by its column.
                    assert!(field.starts_with(path[0].as_str()), "{} = {number}: {error}", path.join("."));
                    let last = &path[path.len() - 1];
                    let column = last.parse::<usize>().is_ok();
                    assert!(column || field.contains(last.as_str()), "{} = {number}: {error}", path.join("."));
                    refused += 1;
                }
            }
        }
    }
    println!("{} numbers: {held} scenes held, {refused} were refused", paths.len());
    assert!(held > 50 && refused > 200);
}

#[test]
fn json_says_the_same_as_toml() {
    // What the log and the HTTP interface write is read back to the same scene.
    let scene = build(whole()).unwrap();
    let text = serde_json::to_string(&SceneFile::from(&scene)).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    assert!(value["wind"]["speed_mps"].is_number());
    assert_eq!(build(serde_json::from_str(&text).unwrap()).unwrap(), scene);
}

/// Keys of all tables below a value.
fn keys(value: &toml::Value, found: &mut std::collections::BTreeSet<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                found.insert(key.clone());
                keys(value, found);
            }
        }
        toml::Value::Array(array) => array.iter().for_each(|value| keys(value, found)),
        _ => {}
    }
}

#[test]
fn every_field_of_a_scene_is_in_its_documentation() {
    let page = include_str!("../../../docs/scenes.md");
    let mut found = Default::default();
    let mut file = whole();
    // Of a station as well as of numbers: such a file is none, but has every field.
    let record = file.measured.as_mut().unwrap();
    let word = || Some("word".to_owned());
    (record.station, record.directory, record.time) = (word(), word(), word());
    record.replay.as_mut().unwrap().until = word();
    keys(&toml::Value::try_from(file).unwrap(), &mut found);
    let missing: Vec<_> =
        found.iter().filter(|key| !page.contains(&format!("`{key}`")) && !page.contains(&format!("[{key}]"))).collect();
    assert!(found.len() > 40 && missing.is_empty(), "docs/scenes.md lacks {missing:?}");
}
