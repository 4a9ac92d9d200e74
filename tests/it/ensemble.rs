//! Laws of many draws: moments, envelope, and what a grid, a distribution or a record may not change.

use std::f64::consts::PI;

use swellcast::plan::Field;
use swellcast::reference;
use swellcast::scene::{CascadeRequest, NdbcStation, Patch, Scene, Swell, preset};
use swellcast::sea::{CascadeModes, Sea, Timeline, gaussian_pair, log_normal_pair};

use crate::support::{DAY, close, cpu_fields, scene};

/// Heights of the first cascade of a seed, at a tick.
fn heights(scene: &Scene, seed: u64, tick: i64) -> Vec<f64> {
    let timeline = Timeline::new(&Scene { seed, ..scene.clone() });
    cpu_fields(&timeline, tick, 0, &[Field::Height]).remove(0).into_iter().map(f64::from).collect()
}

#[test]
fn heights_of_many_seeds_are_normal() {
    // Many modes share the energy of a broad, short-crested sea.
    let sea = scene(
        "name = \"k\"\n[wind]\nspeed_mps = 10\n[cascades]\nn = 128\npatches_m = [1600.0]\n[effects]\nchoppiness = 0\n\
         foam = false",
    );
    let (mut second, mut third, mut fourth, mut count) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..40 {
        for h in heights(&sea, seed, 1000) {
            (second, third, fourth, count) = (second + h * h, third + h * h * h, fourth + h * h * h * h, count + 1.0);
        }
    }
    let m2 = second / count;
    let (skewness, kurtosis) = (third / count / m2.powf(1.5), fourth / count / (m2 * m2));
    println!("pooled skewness {skewness:.4}, kurtosis {kurtosis:.4}");
    assert!((kurtosis - 3.0).abs() < 0.1, "kurtosis {kurtosis}");
    assert!(skewness.abs() < 0.05, "skewness {skewness}");
}

#[test]
fn the_envelope_of_a_narrow_band_is_rayleigh() {
    let swell = |gamma| Swell { hs_m: 2.0, tp_s: 10.0, gamma, ..Swell::default() };
    let mut narrow =
        scene("name = \"r\"\n[cascades]\nn = 128\nband_limit = 0.9\npatches_m = [5000.0]\n[effects]\nfoam = false");
    narrow.sea.swells = vec![swell(20.0)];
    let (mut squares, mut above, mut count, mut points) = (0.0, [0.0_f64; 3], 0.0, Vec::new());
    for seed in 0..12 {
        let timeline = Timeline::new(&Scene { seed, ..narrow.clone() });
        let sea = timeline.at(DAY);
        // Independent points: groups of this swell are a few hundred metres long and wide.
        for i in 0..25 {
            let (x, z) = (f64::from(i % 5) * 1000.0, f64::from(i / 5) * 1000.0);
            let r = envelope(&sea, &sea.cascades[0], x, z);
            (squares, count) = (squares + r * r, count + 1.0);
            points.push(r);
        }
    }
    let mean_square: f64 = squares / count;
    for r in points {
        for (above, level) in above.iter_mut().zip([0.5, 1.0, 1.5]) {
            *above += f64::from(u8::from(r > level * mean_square.sqrt()));
        }
    }
    // E r^2 = 2 m0, and P(r > level rms) = exp(-level^2): within three standard errors of 300 points.
    close(mean_square, 2.0 * 4.0 / 16.0, 3.0 / count.sqrt());
    for (above, level) in above.iter().zip([0.5_f64, 1.0, 1.5]) {
        let (got, want) = (above / count, (-level * level).exp());
        println!("envelope above {level} rms: {got:.3}, Rayleigh {want:.3}");
        assert!((got - want).abs() < 3.0 * (want * (1.0 - want) / count).sqrt(), "{got} for {want}");
    }
}

/// Length of the analytic signal of the waves at a point: all modes as they travel, none twice.
fn envelope(sea: &Sea, cascade: &CascadeModes, x: f64, z: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (kx, kz, mode) in cascade.with_wave_vectors() {
        let angle = kx * x + kz * z;
        let turn = 2.0 * PI * (f64::from(mode.cycles) * DAY as f64 / sea.repeat as f64).fract();
        // 2 h0 e^{i(kx - wt)}, and of the opposite wave the conjugate of e^{i(kx + wt)}, which turns the same way.
        let twice = if kx == 0.0 { 1.0 } else { 2.0 };
        for (amplitude, phase) in [(mode.forward, angle - turn), (mode.backward.conj(), -angle - turn)] {
            re += twice * (amplitude.re * phase.cos() - amplitude.im * phase.sin());
            im += twice * (amplitude.re * phase.sin() + amplitude.im * phase.cos());
        }
    }
    re.hypot(im)
}

#[test]
fn the_same_patch_on_any_grid_has_the_same_waves() {
    let asked = |n: usize| {
        let mut asked = preset("beaufort-5").unwrap();
        // One band in metres for all three grids.
        let band_limit = 0.9 * 128.0 / n as f64;
        asked.cascades = CascadeRequest::Chosen { patches: vec![Patch { length_m: 1000.0, n }], band_limit };
        Timeline::new(&asked)
    };
    let coarse = asked(128);
    let hs = coarse.hs_at(0);
    let base = cpu_fields(&coarse, DAY, 0, &[Field::Height]).remove(0);
    for n in [256, 512] {
        let fine = asked(n);
        let grid = cpu_fields(&fine, DAY, 0, &[Field::Height]).remove(0);
        let ratio = n / 128;
        let sample = |i: usize| grid[(i / 128 * ratio) * n + i % 128 * ratio];
        let worst = (0..base.len()).map(|i| f64::from((base[i] - sample(i)).abs())).fold(0.0, f64::max);
        println!("n {n}: {:.1e} Hs", worst / hs);
        assert!(worst <= 1e-5 * hs, "{n}: {worst} m");
    }
    // By default the band grows with the grid: what both hold is still the same.
    let usual = |n: usize| {
        let mut asked = preset("beaufort-5").unwrap();
        let band_limit = 1.0 / 3.0;
        asked.cascades = CascadeRequest::Chosen { patches: vec![Patch { length_m: 1000.0, n }], band_limit };
        Timeline::new(&asked).at(0).cascades.remove(0)
    };
    let (small, large) = (usual(128), usual(512));
    let (rows, half, wide) = (small.rows(), small.cascade.half as i32, large.rows());
    let mut difference: f64 = 0.0;
    for (i, mode) in small.modes.iter().enumerate() {
        let (n, m) = ((i / rows) as i32, (i % rows) as i32 - half);
        // The cells on the edge of the smaller band are cut by it.
        if f64::from(n * n + m * m).sqrt() < small.cascade.to_k / small.cascade.dk() - 1.0 {
            let same = &large.modes[n as usize * wide + (m + large.cascade.half as i32) as usize];
            difference += 2.0 * ((mode.forward - same.forward).norm() + (mode.backward - same.backward).norm());
        }
    }
    println!("sum of all amplitude differences: {:.1e} Hs", difference / hs);
    assert!(difference <= 1e-5 * hs, "{difference} m");
}

#[test]
fn log_normal_amplitudes_have_the_mean_energy_of_gaussian_ones_and_scatter_more() {
    let text = |law: &str| format!("name = \"l\"\n[amplitudes]\n{law}\n[wind]\n[effects]\nfoam = false");
    let gaussian = scene(&text("distribution = \"gaussian\""));
    let log_normal = scene(&text("distribution = \"log-normal\"\nsigma = 0.8"));
    let (mut mean, mut fourth) = ([0.0; 2], [0.0; 2]);
    let count = 200_000;
    for i in 0..count {
        let (n, m) = (i % 431, i / 431);
        for (law, (re, im)) in [gaussian_pair(3, 0, n, m), log_normal_pair(0.8, 3, 0, n, m)].into_iter().enumerate() {
            let e = re * re + im * im;
            mean[law] += e / f64::from(count);
            fourth[law] += e * e / f64::from(count);
        }
    }
    // E e^2 is 2 (E e)^2 of a Gaussian, exp(4 sigma^2) (E e)^2 of a log-normal.
    println!("mean energies {mean:?}, of squares {fourth:?}");
    close(mean[0], 2.0, 0.01);
    close(mean[1], 2.0, 0.04);
    assert!(fourth[1] > 3.0 * fourth[0], "log-normal energies scatter more");
    let sampled = |scene: &Scene| {
        let seas = (0..10).map(|seed| Timeline::new(&Scene { seed, ..scene.clone() }).at(0));
        let energy = |sea: Sea| -> f64 {
            sea.cascades.iter().flat_map(|cascade| &cascade.modes).map(|mode| mode.forward.norm_sqr()).sum()
        };
        seas.map(energy).sum::<f64>()
    };
    let (a, b) = (sampled(&gaussian), sampled(&log_normal));
    assert!(a != b, "the scene's law is not used");
    close(b, a, 0.25);
}

/// Mean direction the modes of a sea come from, and their spread, degrees.
fn direction_and_spread(timeline: &Timeline) -> (f64, f64) {
    let statistics = timeline.statistics_at(0);
    (statistics.direction_from_deg.unwrap(), statistics.spread_deg.unwrap())
}

#[test]
fn a_measured_sea_runs_and_spreads_as_its_record_says() {
    let station = NdbcStation::built_in();
    let mut worst = (0.0_f64, 0.0_f64);
    for time in station.times().unwrap().iter().step_by(6) {
        let record = station.spectrum(Some(time)).unwrap();
        let (from, spread) = record.direction_and_spread_deg().unwrap();
        let mut asked = preset("ndbc-41010").unwrap();
        asked.effects.foam = None;
        asked.sea.measured = Some(record);
        let timeline = Timeline::new(&asked);
        close(timeline.hs_at(0), timeline.wanted_hs_at(0), 0.01);
        let (got, got_spread) = direction_and_spread(&timeline);
        let off = (got - from + 180.0).rem_euclid(360.0) - 180.0;
        worst = (worst.0.max(off.abs()), worst.1.max((got_spread - spread).abs()));
        assert!(off.abs() <= 1.0, "{time}: from {got}, the record {from}");
        assert!((got_spread - spread).abs() <= 2.0, "{time}: spread {got_spread}, the record {spread}");
    }
    println!("worst direction {:.2} degrees, spread {:.2} degrees", worst.0, worst.1);
}

#[test]
fn a_clipped_series_says_by_how_much_it_turns_and_widens_its_record() {
    let record = NdbcStation::built_in().spectrum(Some("2020-06-08T03:50")).unwrap();
    let (from, spread) = record.direction_and_spread_deg().unwrap();
    let mut asked = preset("ndbc-41010").unwrap();
    asked.effects.foam = None;
    asked.sea.measured = Some(record.with_directions(swellcast::scene::DirectionMethod::Fourier));
    let measured = swellcast::sea::MeasuredSea::new(asked.sea.measured.as_ref().unwrap());
    let clipping = measured.clipping().unwrap();
    println!("{clipping:?}");
    assert!(clipping.bins > 10 && clipping.spread_deg > 1.0);
    let timeline = Timeline::new(&asked);
    close(timeline.hs_at(0), timeline.wanted_hs_at(0), 0.01);
    let (got, got_spread) = direction_and_spread(&timeline);
    let off = (got - from - clipping.direction_deg + 180.0).rem_euclid(360.0) - 180.0;
    assert!(off.abs() < 1.0, "{got} from, {from} and a turn of {}", clipping.direction_deg);
    assert!((got_spread - spread - clipping.spread_deg).abs() < 2.0);
}

#[test]
fn the_reference_sees_the_same_sea_in_every_cascade() {
    let timeline = Timeline::new(&scene("name = \"c\"\n[wind]\nspeed_mps = 7\n[cascades]\nn = 64\nband_limit = 0.5"));
    let sea = timeline.at(77);
    for cascade in 0..sea.cascades.len() {
        let fast = cpu_fields(&timeline, 77, cascade, &[Field::Height]).remove(0);
        let slow = reference::fields(&sea, cascade, 77, &[Field::Height]).remove(0);
        assert!(crate::support::max_error(&fast, &slow) < 1e-5 * timeline.hs_at(77));
    }
}
