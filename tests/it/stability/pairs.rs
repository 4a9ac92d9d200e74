//! Every pair of hard values of different fields occurs in some scene, and each of these scenes holds.

use swellcast::scene::{
    Amplitudes, DepthCorrection, DispersionLaw, Distribution, SceneFile, Spreading, SpreadingForm, Swell, SwellModel,
    WindFile, WindModel,
};

use super::{build, holds};
use crate::support::{DAY, TEN_YEARS};

/// One field and its hard values.
type Axis = (&'static str, Vec<fn(&mut SceneFile)>);

fn wind(file: &mut SceneFile) -> &mut WindFile {
    file.wind.get_or_insert_with(WindFile::default)
}

fn swell(file: &mut SceneFile) -> &mut Swell {
    if file.swell.is_empty() {
        file.swell.push(Swell::default());
    }
    &mut file.swell[0]
}

fn axes() -> Vec<Axis> {
    vec![
        (
            "speed",
            vec![
                |f| wind(f).speed_mps = 0.0,
                |f| wind(f).speed_mps = 1e-3,
                |f| wind(f).speed_mps = 2.0,
                |f| wind(f).speed_mps = 60.0,
                |f| wind(f).speed_mps = 100.0,
            ],
        ),
        (
            "model",
            vec![
                |f| wind(f).model = WindModel::Jonswap,
                |f| wind(f).model = WindModel::PiersonMoskowitzU10,
                |f| wind(f).model = WindModel::PiersonMoskowitzU19,
                |f| wind(f).model = WindModel::Elfouhaily,
                |f| wind(f).model = WindModel::Phillips,
            ],
        ),
        ("fetch", vec![|f| wind(f).fetch_m = 0.0, |f| wind(f).fetch_m = 1.0, |f| wind(f).fetch_m = 1e7]),
        (
            "spreading",
            vec![
                |f| wind(f).spreading = Some(Spreading::cos2s(1000.0)),
                |f| {
                    wind(f).spreading =
                        Some(Spreading { form: SpreadingForm::Cos2, against_wind: 1.0, ..Spreading::default() })
                },
                |f| {
                    wind(f).spreading =
                        Some(Spreading { form: SpreadingForm::DonelanBanner, blend: 0.5, ..Spreading::default() })
                },
                |f| wind(f).spreading = Some(Spreading { form: SpreadingForm::Mitsuyasu, ..Spreading::default() }),
                |f| wind(f).spreading = None,
            ],
        ),
        ("xi", vec![|f| wind(f).swell = 0.0, |f| wind(f).swell = 1.0]),
        ("depth", vec![|f| f.water.depth_m = Some(1e-3), |f| f.water.depth_m = Some(2.0), |f| f.water.depth_m = None]),
        (
            "correction",
            vec![
                |f| wind(f).depth_correction = DepthCorrection::None,
                |f| wind(f).depth_correction = DepthCorrection::Kitaigorodskii,
                |f| wind(f).depth_correction = DepthCorrection::ThompsonVincent,
            ],
        ),
        (
            "dispersion",
            vec![|f| f.water.dispersion = DispersionLaw::Deep, |f| f.water.dispersion = DispersionLaw::Finite, |f| {
                f.water.dispersion = DispersionLaw::Capillary
            }],
        ),
        ("gravity", vec![|f| f.water.gravity = 0.1, |f| f.water.gravity = 9.81, |f| f.water.gravity = 100.0]),
        (
            "swell",
            vec![
                |_| {},
                |f| (swell(f).gamma, swell(f).tp_s) = (20.0, 30.0),
                |f| (swell(f).hs_m, swell(f).tp_s) = (30.0, 0.5),
                |f| (swell(f).model, swell(f).lambda) = (SwellModel::OchiHubble, 0.5),
            ],
        ),
        (
            "grid",
            vec![
                |f| f.cascades.n = Some(16),
                |f| (f.cascades.n, f.cascades.band_limit) = (Some(32), 1.0),
                |f| (f.cascades.n, f.cascades.patches_m) = (Some(32), vec![1e5]),
                |f| (f.cascades.n, f.cascades.patches_m) = (Some(32), vec![300.0, 80.0]),
                |f| (f.cascades.n, f.cascades.patches_m) = (Some(32), vec![0.1]),
            ],
        ),
        (
            "choppiness",
            vec![|f| f.effects.choppiness = 0.0, |f| f.effects.choppiness = 1.0, |f| f.effects.choppiness = 5.0],
        ),
        ("loop", vec![|f| f.loop_s = None, |f| f.loop_s = Some(1.0), |f| f.loop_s = Some(21600.0)]),
        (
            "amplitudes",
            vec![|_| {}, |f| f.amplitudes = Amplitudes { distribution: Distribution::LogNormal, sigma: 0.3 }],
        ),
    ]
}

/// Choices of a value for every axis such that any two values of two axes meet in one of them: at each turn, of a few
/// candidates, the one that covers most pairs that are still missing.
fn covering(axes: &[Axis]) -> Vec<Vec<usize>> {
    let mut missing = std::collections::BTreeSet::new();
    for (a, (_, values)) in axes.iter().enumerate() {
        for (b, (_, others)) in axes.iter().enumerate().skip(a + 1) {
            missing.extend((0..values.len()).flat_map(|i| (0..others.len()).map(move |j| (a, i, b, j))));
        }
    }
    let mut random = crate::random::Random(7);
    let mut rows = Vec::new();
    while let Some(&(a, i, b, j)) = missing.iter().next() {
        let candidate = |random: &mut crate::random::Random| {
            let mut row: Vec<usize> = axes.iter().map(|(_, values)| random.below(values.len())).collect();
            (row[a], row[b]) = (i, j);
            row
        };
        let meets = |row: &[usize]| missing.iter().filter(|(a, i, b, j)| row[*a] == *i && row[*b] == *j).count();
        let best = (0..60).map(|_| candidate(&mut random)).max_by_key(|row| meets(row)).unwrap();
        missing.retain(|(a, i, b, j)| best[*a] != *i || best[*b] != *j);
        rows.push(best);
    }
    rows
}

#[test]
fn every_pair_of_hard_values_holds() {
    let axes = axes();
    let rows = covering(&axes);
    println!("{} scenes", rows.len());
    let mut wrong = Vec::new();
    for row in &rows {
        let mut file = SceneFile { name: "pair".to_owned(), ..SceneFile::default() };
        wind(&mut file).range_mps = [0.0, 100.0];
        for ((_, values), choice) in axes.iter().zip(row) {
            values[*choice](&mut file);
        }
        let names: Vec<_> = axes.iter().zip(row).map(|((name, _), choice)| format!("{name} {choice}")).collect();
        // None of these is out of bounds by itself: each must make a sea.
        let verdict = build(file).map_err(|e| e.to_string()).and_then(|scene| holds(&scene, &[0, DAY, TEN_YEARS]));
        if let Err(why) = verdict {
            wrong.push(format!("{}: {why}", names.join(", ")));
        }
    }
    assert!(rows.len() >= 25, "at least the product of the two largest axes");
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}
