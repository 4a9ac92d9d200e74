//! Each axis moves the way theory says.

use swellcast::accuracy::{
    self, Axis, Errors, Ground, KERNELS, between_frames, left_out_by_trochoids, spots, trochoid_sea,
};
use swellcast::engine::Clock;
use swellcast::scene::{Scene, SceneFile, preset};
use swellcast::sea::Timeline;
use swellcast::wire::{ErrorClass, Group};

/// Two small cascades under a fresh breeze.
fn breeze() -> Scene {
    let text = "name = \"breeze\"\nseed = 3\n[wind]\nspeed_mps = 9.0\nfetch_m = 200e3\ndirection_from_deg = 250.0\n\
                [cascades]\nn = 64\nband_limit = 0.5\npatches_m = [400.0, 67.3]\n";
    SceneFile::from_toml(text).unwrap().check(None).unwrap()
}

fn ground(clock: &Clock) -> Ground<'_> {
    Ground::new(&breeze(), true, clock)
}

fn clock() -> Clock {
    Clock::start(Clock::unix_now_ns())
}

/// Errors of the first point whose setting begins so.
fn of(axis: &Axis, setting: &str) -> Errors {
    let point = axis.points.iter().find(|point| point.setting.starts_with(setting));
    point.unwrap_or_else(|| panic!("{setting} is not among {:?}", axis.points)).errors
}

fn height(axis: &Axis, setting: &str) -> f64 {
    of(axis, setting).height_rms.unwrap()
}

#[test]
fn f32_seconds_lose_phase_with_uptime_and_exact_phase_does_not() {
    let clock = clock();
    let axis = accuracy::time(&ground(&clock));
    let lost = ["1 h", "1 day", "30 days"].map(|after| height(&axis, &format!("f32 seconds, {after}")));
    let kept = ["1 h", "1 day", "30 days"].map(|after| height(&axis, &format!("exact phase, {after}")));
    // An f32 of a day's seconds has steps of 1/128 s, one of 30 days' of 1/4 s.
    assert!(lost[0] > 1e-5 && lost[1] > 5.0 * lost[0] && lost[2] > 5.0 * lost[1], "{lost:?}");
    assert!(kept.iter().all(|error| *error < 1e-6), "{kept:?}");
}

#[test]
fn the_centre_of_a_cell_misses_a_narrow_swell_and_its_integral_does_not() {
    let scene = accuracy::narrow_swell(&breeze());
    let wanted = Timeline::new(&scene).wanted_hs_at(0);
    let accuracy::ByCell { integrated: (_, integrated), centre: (_, centre) } = accuracy::by_cell(&scene, 0);
    let off = |hs_m: f64| (hs_m / wanted - 1.0).abs();
    assert!(off(integrated) < 0.003, "{}", off(integrated));
    assert!(off(centre) > 0.01, "{}", off(centre));
}

#[test]
fn linear_playback_errs_with_the_square_of_the_interval_and_cubic_with_its_fourth_power() {
    let scene = preset("long-swell").unwrap();
    let sea = Timeline::new(&scene).at(0);
    let spots = spots(sea.cascades[0].cascade.patch_m, 12);
    let intervals = [120_i64, 240, 480, 720];
    let errors =
        intervals.map(|interval| between_frames(&sea, &spots, 7200, interval).map(|errors| errors.height_rms.unwrap()));
    // Least squares of log error over log interval.
    let slope = |kernel: usize| {
        let points = intervals.iter().zip(errors).map(|(x, y)| ((*x as f64).ln(), y[kernel].ln()));
        let points: Vec<(f64, f64)> = points.collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
    };
    let slopes: Vec<f64> = (0..KERNELS.len()).map(slope).collect();
    for (slope, law) in slopes.iter().zip([1.0, 2.0, 4.0, 4.0]) {
        assert!((slope / law - 1.0).abs() < 0.15, "{slopes:?}");
    }
    // Velocities of the two frames around tell more than positions of two more.
    assert!(errors.iter().all(|errors| errors[3] < 0.5 * errors[2]), "{errors:?}");
}

#[test]
fn the_quantiser_errs_by_half_a_step_at_most_and_evenly() {
    let clock = clock();
    let ground = ground(&clock);
    let axis = accuracy::stream(&ground);
    // Counts of each of two cascades are off by a number spread evenly over a step.
    for class in ErrorClass::ALL {
        let half = f64::from(class.max_error(Group::Displacement));
        let errors = of(&axis, &format!("{}, predicted", class.name()));
        let rms = errors.height_rms.unwrap() * ground.hs_m;
        let law = half * (2.0_f64 / 3.0).sqrt();
        assert!((rms / law - 1.0).abs() < 0.1, "{}: {rms} m, not {law}", class.name());
        let most = errors.height_max.unwrap() * ground.hs_m;
        assert!((1.7..=2.0).contains(&(most / half)), "{}: {most} m of {half} twice", class.name());
        let keys = of(&axis, &format!("{}, key frames alone", class.name()));
        assert_eq!(keys, errors, "predictions lose nothing");
    }
    let bytes = |setting: &str| {
        axis.points.iter().find(|point| point.setting.starts_with(setting)).unwrap().bytes_per_s.unwrap()
    };
    assert!(bytes("f32") > 1.9 * bytes("f16"));
    assert!(bytes("1mm, key frames alone") > 1.5 * bytes("1mm, predicted"));
    assert!(bytes("0.5mm, predicted") > bytes("1mm, predicted") && bytes("1mm, predicted") > bytes("20mm, predicted"));
}

#[test]
fn trochoids_err_by_the_energy_that_they_leave_out() {
    let clock = clock();
    let ground = ground(&clock);
    let axis = accuracy::model(&ground);
    let mut before = f64::INFINITY;
    for components in [16, 64, 256, 1024] {
        let left = left_out_by_trochoids(&trochoid_sea(&ground.scene, 128, components, false, ground.tick));
        let error = 4.0 * height(&axis, &format!("trochoids, K = {components}"));
        assert!((error / left.sqrt() - 1.0).abs() < 0.1, "K = {components}: {error} beside {}", left.sqrt());
        assert!(error < before);
        // Noise has that energy once more, at random.
        let noisy = 4.0 * height(&axis, &format!("trochoids, K = {components}, with noise"));
        assert!(noisy > error, "{noisy} {error}");
        before = error;
    }
    assert!(height(&axis, "all modes") < 1e-6);
}

#[test]
fn sobel_errs_more_than_spectral_normals() {
    let clock = clock();
    let axis = accuracy::normals(&ground(&clock));
    let degrees = ["exact", "diagonal", "displaced-slopes", "central-difference", "sobel"]
        .map(|way| of(&axis, way).normal_deg.unwrap());
    assert!(degrees[0] < 1e-3, "{degrees:?}");
    assert!(degrees.windows(2).all(|pair| pair[0] < pair[1]), "{degrees:?}");
}

#[test]
fn finer_grids_more_cascades_and_more_steps_err_less() {
    let clock = clock();
    let ground = ground(&clock);
    let heights = |axis: Axis| axis.points.iter().map(|point| point.errors.height_rms.unwrap()).collect::<Vec<_>>();
    let grids = heights(accuracy::grid(&ground));
    assert!(grids.windows(2).all(|pair| pair[1] < pair[0]), "{grids:?}");
    // Where all waves are there, half the spacing errs a third or less: the cubic is tuned for waves of few samples.
    assert!(grids[3] < grids[2] / 2.5 && grids[4] < grids[3] / 2.5, "{grids:?}");
    let counts = heights(accuracy::cascades(&ground));
    assert!(counts.windows(2).all(|pair| pair[1] < pair[0]), "{counts:?}");
    let searches = accuracy::inverse(&ground);
    let found: Vec<f64> = searches.points.iter().map(|point| point.errors.position_mm.unwrap()).collect();
    assert!(found[1] < 0.5 * found[0] && found[8] <= found[1], "{found:?}");
    let foam = accuracy::foam(&ground, &mut Vec::new()).expect("a fresh breeze breaks");
    let by_step: Vec<f64> = foam.points.iter().map(|point| point.errors.foam.unwrap()).collect();
    assert!(by_step[4] < by_step[0], "{by_step:?}");
}

#[test]
fn laws_of_dispersion_that_leave_out_more_err_more() {
    let clock = clock();
    let axis = accuracy::dispersion(&ground(&clock));
    let [deep, finite, all] = ["deep", "finite depth", "finite depth and"].map(|law| height(&axis, law));
    assert!(deep > 0.05 && finite < deep && all == 0.0, "{deep} {finite} {all}");
}

#[test]
fn the_band_decides_what_is_left_out_and_the_reader_what_is_lost() {
    let clock = clock();
    let axis = accuracy::band(&ground(&clock));
    for share in ["a third", "half", "all"] {
        let [linear, cubic] =
            ["bilinear", "bicubic"].map(|reader| height(&axis, &format!("{share} of Nyquist, {reader}")));
        assert!(cubic < linear, "{share}: {cubic} {linear}");
    }
    assert!(height(&axis, "half of Nyquist, bicubic") < height(&axis, "a third of Nyquist, bicubic"));
}

#[test]
fn the_cpu_is_a_twin_of_the_reference_and_errors_are_the_same_on_every_run() {
    let clock = clock();
    let run = || accuracy::arithmetic(&ground(&clock), &[], &mut Vec::new()).0;
    let axis = run();
    assert!(height(&axis, "CPU") < 1e-6 && height(&axis, "reference") == 0.0, "{:?}", axis.points);
    let errors = |axis: &Axis| axis.points.iter().map(|point| point.errors).collect::<Vec<_>>();
    assert_eq!(errors(&axis), errors(&run()), "to the last digit");
}
