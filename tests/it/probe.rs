//! Laws of point queries: grids say what the sum of the modes says, the particle found has come to the point, folds are
//! told, what was made is not made again.

use std::sync::Arc;

use swellcast::backend::Cpu;
use swellcast::engine::{ProbeAnswer, ProbeError, ProbeFields, ProbeMethod, Prober};
use swellcast::reference::{self, Probe};
use swellcast::scene::{Change, ChangeKind, Scene};
use swellcast::sea::{Displacement, Timeline, rest_position, rest_position_within};

use crate::random::Random;
use crate::support::{TEN_YEARS, scene, wind_sea};

const TICK: i64 = 7200 * 31 + 240;
const ALL_MODES: ProbeMethod = ProbeMethod::Direct { share: 1.0 };

fn prober(scene: &Scene) -> (Prober, Arc<Timeline>) {
    let timeline = Arc::new(Timeline::new(scene));
    (Prober::new(Box::new(Cpu::new(Some(2))), Arc::clone(&timeline)), timeline)
}

fn points(random: &mut Random, n: usize, within_m: f64) -> Vec<[f64; 2]> {
    (0..n).map(|_| [(random.unit() - 0.5) * within_m, (random.unit() - 0.5) * within_m]).collect()
}

fn probe(prober: &mut Prober, tick: i64, points: &[[f64; 2]], method: ProbeMethod) -> Vec<ProbeAnswer> {
    prober.probe(tick, points, ProbeFields::ALL, method).unwrap().answers
}

fn length(v: impl Iterator<Item = f64>) -> f64 {
    v.map(|v| v * v).sum::<f64>().sqrt()
}

/// How far two answers are apart: height in metres, normal in degrees, velocity in m/s, Jacobian.
fn apart(a: &ProbeAnswer, b: &ProbeAnswer) -> [f64; 4] {
    let (n, m, v, w) = (a.normal.unwrap(), b.normal.unwrap(), a.velocity.unwrap(), b.velocity.unwrap());
    let angle = 2.0 * (0.5 * length((0..3).map(|i| n[i] - m[i]))).asin();
    [
        (a.height - b.height).abs(),
        angle.to_degrees(),
        length((0..3).map(|i| v[i] - w[i])),
        (a.jacobian.unwrap() - b.jacobian.unwrap()).abs(),
    ]
}

fn as_answer(probe: Probe) -> ProbeAnswer {
    let Probe { x, z, height, normal, velocity, jacobian, folded, rest, residual, iterations } = probe;
    let (normal, velocity, jacobian) = (Some(normal), Some(velocity), Some(jacobian));
    ProbeAnswer { x, z, height, normal, velocity, jacobian, folded, rest, residual, iterations }
}

#[test]
fn grids_agree_with_the_sum_of_the_modes() {
    let mut random = Random(7);
    let patch = "[cascades]\nn = 256\npatches_m = [500]";
    for (what, text) in [
        ("a breeze", format!("[wind]\nspeed_mps = 11\n{patch}")),
        ("a gale", format!("[wind]\nspeed_mps = 20\nfetch_m = 300e3\n{patch}")),
        ("a light air", format!("seed = 3\n[wind]\nspeed_mps = 4\n{patch}")),
        ("swell and wind sea", format!("seed = 5\n[wind]\nspeed_mps = 9\n[[swell]]\nhs_m = 3\ntp_s = 12\n{patch}")),
        ("shallow water", format!("seed = 6\n[water]\ndepth_m = 8\n[wind]\nspeed_mps = 14\n{patch}")),
        ("no choppiness", format!("[effects]\nchoppiness = 0\n[wind]\nspeed_mps = 12\n{patch}")),
        ("a small grid", "[wind]\nspeed_mps = 3\n[cascades]\nn = 64\npatches_m = [40, 9]".to_owned()),
        ("three cascades", "[wind]\nspeed_mps = 9\n[cascades]\nn = 256\npatches_m = [500, 90, 17]".to_owned()),
        ("the default", "seed = 9\n[wind]\nspeed_mps = 9\nfetch_m = 200e3".to_owned()),
    ] {
        let (mut prober, timeline) = prober(&scene(&text));
        let points = points(&mut random, 250, 3000.0);
        let grids = probe(&mut prober, TICK, &points, ProbeMethod::Grid);
        let direct = probe(&mut prober, TICK, &points, ALL_MODES);
        let flat: Vec<_> = grids.iter().zip(&direct).filter(|(a, b)| !a.folded && !b.folded).collect();
        assert!(flat.len() > 240, "{what}: {} of 250 do not fold", flat.len());
        let worst = flat
            .iter()
            .map(|(a, b)| apart(a, b))
            .fold([0.0; 4], |most, apart| std::array::from_fn(|i| f64::max(most[i], apart[i])));
        let steps = grids.iter().map(|a| a.iterations).max().unwrap();
        let residual = flat.iter().flat_map(|(a, b)| [a.residual, b.residual]).fold(0.0, f64::max);
        println!("{what}: {worst:.4?} (m, degrees, m/s, 1), {steps} steps at most, residual {residual:.1e} m");
        assert!(worst[0] < 5e-3, "{what}: heights are {} m apart", worst[0]);
        assert!(worst[1] < 0.6 && worst[2] < 0.03 && worst[3] < 0.02, "{what}: {worst:?}");
        assert!(residual < 1e-3 && steps <= 8, "{what}: {residual} m after {steps} steps");
        // Both against the reference, which shares nothing with either but the search.
        let sea = timeline.at(TICK);
        for (grid, direct) in grids.iter().zip(&direct).take(3) {
            let told = as_answer(reference::probe(&sea, TICK, grid.x, grid.z));
            assert!(apart(direct, &told).iter().all(|d| *d < 1e-6), "{what}: {direct:?} is not {told:?}");
            assert!(apart(grid, &told)[0] < 5e-3, "{what}: {grid:?} is not {told:?}");
        }
    }
}

#[test]
fn the_search_arrives_where_the_mapping_is_one_to_one() {
    // One steep wave along a slant, up to where it just doesn't fold.
    for steepness in [0.0, 0.3, 0.9, 0.99] {
        let (k, c, s) = (0.7, 0.8, 0.6);
        let wave = |[x, z]: [f64; 2]| {
            let angle: f64 = k * (c * x + s * z);
            let (by, strain) = (-steepness / k * angle.sin(), -steepness * angle.cos());
            let (dxx, dzz, dxz) = (strain * c * c, strain * s * s, strain * c * s);
            Displacement { dx: c * by, dz: s * by, dxx, dzz, dxz, dzx: dxz }
        };
        let mut random = Random(1);
        for target in points(&mut random, 2000, 100.0) {
            let found = rest_position(target, wave);
            let moved = wave(found.at);
            let missing = length([found.at[0] + moved.dx - target[0], found.at[1] + moved.dz - target[1]].into_iter());
            assert!(found.arrived && !found.folded() && missing <= 1.001e-4, "{steepness} {target:?}: {found:?}");
            assert!(found.iterations <= 30, "{steepness} {target:?}: {found:?}");
        }
    }
    // What is no number ends, too, and is no answer.
    let found = rest_position([1.0, 2.0], |_| Displacement { dx: f64::NAN, ..Displacement::default() });
    assert!(found.folded() && !found.arrived && found.iterations == 0, "{found:?}");
}

#[test]
fn folds_are_told_and_even_there_a_particle_is_found() {
    // A wave so steep that its crest is a loop: in the middle of it the surface is upside down.
    let loops = |[x, z]: [f64; 2]| Displacement {
        dx: -2.5 * x.sin(),
        dz: 0.1 * z.cos(),
        dxx: -2.5 * x.cos(),
        dzz: -0.1 * z.sin(),
        dxz: 0.0,
        dzx: 0.0,
    };
    let crest = rest_position([0.0, 0.1], loops);
    assert!(crest.arrived && crest.jacobian < -1.0 && crest.folded(), "{crest:?}");
    for target in points(&mut Random(2), 2000, 20.0) {
        let found = rest_position(target, loops);
        assert!(found.arrived && found.folded() == (found.jacobian <= 0.0), "{target:?}: {found:?}");
    }

    let steep = "[effects]\nchoppiness = 5\n[wind]\nspeed_mps = 16\n[cascades]\nn = 128\npatches_m = [300, 50, 8]";
    let (mut prober, _) = prober(&scene(steep));
    let at = points(&mut Random(11), 10_000, 600.0);
    for (at, method) in [(&at[..], ProbeMethod::Grid), (&at[..500], ProbeMethod::Direct { share: 0.98 })] {
        let answers = probe(&mut prober, TICK, at, method);
        let folded = answers.iter().filter(|a| a.folded).count();
        let lost = answers.iter().filter(|a| a.residual > 1e-3).count();
        let steps = answers.iter().map(|a| f64::from(a.iterations)).sum::<f64>() / at.len() as f64;
        println!("{method:?}: {folded} of {} fold, {lost} without a particle, {steps:.2} steps each", at.len());
        assert!(lost * 200 <= at.len(), "{lost} of {} were not reached", at.len());
        assert!(steps < 10.0, "{steps} steps a point");
        assert!(folded > 0 || at.len() < 1000, "none of {} points folds", at.len());
        assert!(answers.iter().all(|a| a.folded || (a.jacobian.unwrap() > 0.0 && a.residual < 1e-3)));
    }
    let gentle = probe(&mut self::prober(&wind_sea(6.0, 128, &[300.0])).0, TICK, &at, ProbeMethod::Grid);
    assert!(gentle.iter().all(|a| !a.folded), "a gentle sea does not fold");
}

#[test]
fn a_search_takes_no_more_steps_than_it_may() {
    // Nothing comes within ten metres of any point: every search looks to the end.
    for most in [0, 1, 7, 20, 100] {
        let mut looks = 0;
        let away = |[x, _]: [f64; 2]| {
            looks += 1;
            Displacement { dx: 10.0 - x, dz: 20.0 + x.sin(), ..Displacement::default() }
        };
        let found = rest_position_within(most, [0.0, 0.0], away);
        assert!(found.iterations == most && looks <= most + 1, "{most}: {looks} looks, {found:?}");
        assert!(found.folded() && found.residual >= 10.0 && found.residual <= 23.0, "{most}: {found:?}");
    }
    // What arrives in time is the same whatever the most would have been.
    let wave = |[x, _]: [f64; 2]| Displacement { dx: -0.9 * x.sin(), dxx: -0.9 * x.cos(), ..Displacement::default() };
    for target in points(&mut Random(6), 500, 50.0) {
        let (all, some) = (rest_position(target, wave), rest_position_within(20, target, wave));
        assert!(all == some || all.iterations > 20, "{all:?} is not {some:?}");
    }
}

#[test]
fn far_away_and_one_patch_on_the_water_is_the_same() {
    let (mut prober, _) = prober(&wind_sea(11.0, 256, &[500.0]));
    let near = points(&mut Random(3), 100, 500.0);
    let here = probe(&mut prober, TICK, &near, ProbeMethod::Grid);
    // 500 m is a whole number of floats: the sums of patches are exact.
    for patches in [1.0, -7.0, 1_999_998.0, -1_999_998.0] {
        let far: Vec<_> = near.iter().map(|[x, z]| [x + 500.0 * patches, z - 500.0 * patches]).collect();
        for (a, b) in here.iter().zip(probe(&mut prober, TICK, &far, ProbeMethod::Grid)) {
            let apart = apart(a, &b);
            assert!(apart[0] < 2e-4 && apart[1] < 0.01 && apart[2] < 1e-3, "{patches} patches on: {apart:?}");
        }
    }
    // Against the modes, at the edge of what may be asked for.
    let (mut prober, _) = self::prober(&wind_sea(9.0, 256, &[500.0, 90.0, 17.0]));
    let edge: Vec<_> = near.iter().map(|[x, z]| [x + 1e9 - 500.0, z - 1e9 + 500.0]).collect();
    let grids = probe(&mut prober, TEN_YEARS, &edge, ProbeMethod::Grid);
    for (a, b) in grids.iter().zip(probe(&mut prober, TEN_YEARS, &edge, ALL_MODES)) {
        assert!(a.folded || b.folded || (apart(a, &b)[0] < 5e-3 && a.residual < 1e-3), "{a:?} is not {b:?}");
    }
}

#[test]
fn only_what_is_wanted_is_made_and_only_once() {
    let (mut prober, timeline) = prober(&wind_sea(9.0, 64, &[200.0, 30.0]));
    let at = points(&mut Random(4), 50, 100.0);
    let mut made = |tick: i64, wanted: ProbeFields| {
        let probed = prober.probe(tick, &at, wanted, ProbeMethod::Grid).unwrap();
        assert_eq!((probed.tick, probed.omitted_rms_m, probed.answers.len()), (tick, 0.0, 50));
        let answer = probed.answers[7];
        let has = [answer.normal.is_some(), answer.velocity.is_some(), answer.jacobian.is_some()];
        assert_eq!(has, [wanted.normal, wanted.velocity, wanted.jacobian]);
        (probed.transforms, answer.height)
    };
    let jacobian = ProbeFields { jacobian: true, ..ProbeFields::HEIGHT };
    let (first, height) = made(0, ProbeFields::HEIGHT);
    assert_eq!(first, 2 * 3, "height and displacement of two cascades");
    assert_eq!(made(0, ProbeFields::HEIGHT), (0, height), "the same tick again");
    assert_eq!(made(240, ProbeFields::ALL).0, 2 * 11);
    assert_eq!(made(240, ProbeFields::HEIGHT).0, 0, "part of what is there");
    assert_eq!(made(0, jacobian), (2 * 6, height), "another tick");
    assert_eq!(made(0, ProbeFields { velocity: true, ..jacobian }).0, 2 * 9, "more of the same tick");
    assert_eq!(made(0, jacobian), (0, height), "nothing was lost by it");

    // The same timeline keeps what was made; a change does not, and acts.
    prober.set_timeline(Arc::clone(&timeline));
    assert_eq!(prober.probe(0, &at, jacobian, ProbeMethod::Grid).unwrap().transforms, 0);
    let change = Change {
        sequence: 1,
        effective_tick: 0,
        transition_ticks: 0,
        kind: ChangeKind::Wind { speed_mps: 14.0, direction_from_deg: 90.0 },
    };
    prober.set_timeline(Arc::new(timeline.with(change, 0)));
    let changed = prober.probe(0, &at, jacobian, ProbeMethod::Grid).unwrap();
    assert_eq!((changed.transforms, changed.sequence), (2 * 6, 1));
    assert!((changed.answers[7].height - height).abs() > 0.01);

    let (mut still, _) = self::prober(&scene("[effects]\nchoppiness = 0\n[cascades]\nn = 32\npatches_m = [60]"));
    let probed = still.probe(0, &at, ProbeFields::ALL, ProbeMethod::Grid).unwrap();
    assert_eq!(probed.transforms, 4, "height, slopes and vertical velocity");
    assert!(probed.answers.iter().all(|a| a.iterations == 0 && a.jacobian == Some(1.0) && a.rest == [a.x, a.z]));
}

#[test]
fn what_the_strongest_modes_leave_out_is_told() {
    let (mut prober, timeline) = prober(&wind_sea(11.0, 128, &[300.0, 50.0]));
    let at = points(&mut Random(5), 400, 2000.0);
    let all = probe(&mut prober, TICK, &at, ALL_MODES);
    for share in [0.5, 0.9, 0.999] {
        let wanted = ProbeFields::HEIGHT;
        let some = prober.probe(TICK, &at, wanted, ProbeMethod::Direct { share }).unwrap();
        let told = some.omitted_rms_m;
        let most = 0.25 * timeline.hs_at(TICK) * (1.0 - share).sqrt();
        assert!(told > 0.5 * most && told <= most * 1.001, "{share}: {told} of {most}");
        let rms = length(all.iter().zip(&some.answers).map(|(a, b)| a.height - b.height)) / (at.len() as f64).sqrt();
        // The particle that comes to the point is another, too, by a little.
        assert!((0.7 * told..1.5 * told).contains(&rms), "{share}: {rms} is not about {told}");
    }
    let many = vec![[0.0; 2]; 1_000_000];
    let refused = prober.probe(TICK, &many, ProbeFields::HEIGHT, ALL_MODES).unwrap_err();
    assert!(matches!(refused, ProbeError::TooManySums { points: 1_000_000, most, .. } if most > 1000), "{refused}");
}
