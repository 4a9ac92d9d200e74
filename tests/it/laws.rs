//! Laws of the initial spectra: energy, integrals, dispersion, randomness, exact phase.

use std::f64::consts::PI;

use swellcast::scene::{PRESETS, SceneFile, Water, WindSea, preset};
use swellcast::sea::{self, Dispersion, Jonswap, Timeline};

use crate::support::close;

#[test]
fn jonswap_by_wind_and_fetch_has_the_published_heights_and_peaks() {
    for (speed_mps, fetch_m, hs, tp) in
        [(10.0, 1e5, 2.139, 6.232), (15.0, 3e5, 5.647, 10.289), (20.0, 1e5, 3.954, 7.852)]
    {
        let jonswap = Jonswap::of_wind(&WindSea::jonswap(speed_mps, 0.0, fetch_m), 9.81).unwrap();
        close(4.0 * jonswap.m0().sqrt(), hs, 1e-3);
        close(2.0 * PI / jonswap.peak(), tp, 1e-3);
    }
}

#[test]
fn spreading_integrates_to_one_for_every_exponent() {
    for s in [0.0, 0.1, 0.5, 1.0, 4.0, 9.9, 50.0, 150.0, 1000.0] {
        let steps = 20_000;
        let width = 2.0 * PI / f64::from(steps);
        let sum: f64 = (0..steps).map(|i| sea::cos2s(s, (f64::from(i) * width - PI).cos())).sum();
        // A small s has a cusp at the back, where the sum itself errs.
        close(sum * width, 1.0, 2e-5);
    }
    for (s, norm) in [(0.5, 0.25), (1.0, std::f64::consts::FRAC_1_PI), (4.0, 0.58205), (10.0, 0.90328), (50.0, 1.9997)]
    {
        close(sea::cos2s(s, 1.0), norm, 1e-4);
    }
}

#[test]
fn dispersion_and_its_derivative_agree_and_its_inverse_inverts() {
    for depth_m in [1e-3, 0.5, 20.0, f64::INFINITY] {
        let dispersion = Dispersion::new(Water { depth_m, ..Water::default() });
        for k in [1e-4, 0.01, 0.3, 5.0, 367.0, 1e4] {
            let h = 1e-5 * k;
            let slope = (dispersion.omega(k + h) - dispersion.omega(k - h)) / (2.0 * h);
            close(dispersion.group_velocity(k), slope, 1e-6);
            close(dispersion.wavenumber(dispersion.omega(k)), k, 1e-9);
        }
    }
    let deep = Dispersion::new(Water::default());
    let slowest = (1..2000).map(|k| deep.omega(f64::from(k)) / f64::from(k)).fold(f64::INFINITY, f64::min);
    close(slowest, 0.231, 5e-3);
}

#[test]
fn every_preset_holds_the_energy_its_spectrum_wants() {
    for (name, _) in PRESETS {
        let timeline = Timeline::new(&preset(name).unwrap());
        let (got, want) = (timeline.hs_at(0), timeline.wanted_hs_at(0));
        println!(
            "{name}: Hs {got:.4} m of {want:.4} m, {:?}",
            timeline.layout().cascades.iter().map(|c| c.patch_m).collect::<Vec<_>>()
        );
        assert!(want > 0.0, "{name} is flat");
        close(got, want, 0.01);
    }
}

#[test]
fn every_preset_survives_the_round_trip_through_its_file() {
    for (name, _) in PRESETS {
        let scene = preset(name).unwrap();
        assert_eq!(&scene.name, name);
        assert_eq!(SceneFile::from(&scene).check(None).unwrap(), scene);
    }
}

#[test]
fn cosine_and_sine_of_a_turn_are_good_to_2_to_the_minus_24() {
    let mut worst: f64 = 0.0;
    for i in 0..200_000_u32 {
        let turn = i.wrapping_mul(2_654_435_761);
        let (cos, sin) = sea::cos_sin_q24(turn);
        let angle = f64::from(turn) / 4_294_967_296.0 * 2.0 * PI;
        worst = worst.max((f64::from(cos) / 16_777_216.0 - angle.cos()).abs());
        worst = worst.max((f64::from(sin) / 16_777_216.0 - angle.sin()).abs());
    }
    assert!(worst < 3.6e-8, "{worst}");
}

#[test]
fn sampled_heights_over_seeds_have_the_energy_of_the_modes() {
    let mut scene = preset("beaufort-5").unwrap();
    let layout = Timeline::new(&scene).layout().clone();
    let table = sea::EnergyTable::build(&scene.sea, &layout);
    // Variance of a patch's mean square: each pair of opposite modes is one complex Gaussian, |h|^2 exponential.
    let pairs = |energy: &Vec<f64>| -> f64 {
        (0..energy.len() / 2).map(|i| (energy[i] + energy[energy.len() - 1 - i]).powi(2)).sum()
    };
    let spread: f64 = table.energy.iter().map(pairs).sum();
    let seeds = 20;
    let mut sum = 0.0;
    for seed in 0..seeds {
        scene.seed = seed;
        let timeline = Timeline::new(&scene);
        for cascade in 0..layout.cascades.len() {
            let height =
                crate::support::cpu_fields(&timeline, 4321, cascade, &[swellcast::plan::Field::Height]).remove(0);
            sum += height.iter().map(|h| f64::from(*h).powi(2)).sum::<f64>() / height.len() as f64;
        }
    }
    let (m0, want) = (sum / seeds as f64, table.resolved_m0());
    let error = (spread / seeds as f64).sqrt();
    println!("m0 {m0:.5} m^2 of {want:.5} m^2, standard error {error:.5}");
    assert!(3.0 * error < 0.04 * want, "the sample is too small to tell anything: Hs to {}", 1.5 * error / want);
    assert!((m0 - want).abs() <= 3.0 * error);
}

#[test]
fn a_mode_keeps_its_draw_on_another_grid() {
    assert_eq!(sea::gaussian_pair(5, 1, -3, 7), sea::gaussian_pair(5, 1, -3, 7));
    let (mut sum, mut squares, mut cross) = (0.0, 0.0, 0.0);
    let count = 100_000;
    for i in 0..count {
        let (a, b) = sea::gaussian_pair(9, 0, i % 317, i / 317);
        (sum, squares, cross) = (sum + a + b, squares + a * a + b * b, cross + a * b);
    }
    let per = 2.0 * f64::from(count);
    assert!((sum / per).abs() < 0.01 && (squares / per - 1.0).abs() < 0.015 && (cross / per).abs() < 0.01);
}

#[test]
fn a_measured_sea_keeps_the_directions_of_its_record() {
    let scene = preset("ndbc-41010").unwrap();
    let record = scene.sea.measured.clone().unwrap();
    let measured = sea::MeasuredSea::new(&record);
    println!("{} bins infeasible, {} without direction", measured.infeasible(), measured.missing());
    for bin in record.bins().iter().filter(|bin| bin.density > 0.1) {
        let Some(spread) = bin.direction else { continue };
        let omega = 2.0 * PI * bin.frequency_hz;
        let (mut a, mut b, mut total) = (0.0, 0.0, 0.0);
        let steps = 3600;
        for i in 0..steps {
            let theta = 2.0 * PI * f64::from(i) / f64::from(steps);
            let d = measured.density(omega, (theta.cos(), theta.sin()));
            assert!(d >= 0.0);
            (a, b, total) = (a + d * theta.cos(), b + d * theta.sin(), total + d);
        }
        // Travel toward theta is coming from theta - 90 degrees on the compass, turned about.
        let from = (b.atan2(a).to_degrees() - 90.0).rem_euclid(360.0);
        let turn = (from - spread.alpha1_deg + 180.0).rem_euclid(360.0) - 180.0;
        assert!(turn.abs() < 0.1, "from {from}, the record says {}", spread.alpha1_deg);
        close(a.hypot(b) / total, spread.r1, 0.01);
        close(total * 2.0 * PI / f64::from(steps) * 2.0 * PI, bin.density, 0.01);
    }
}

#[test]
fn a_layout_holds_the_sea_over_the_whole_wind_range_it_declares() {
    for (name, _) in PRESETS {
        let scene = preset(name).unwrap();
        let Some([low, high]) = scene.wind_range_mps else { continue };
        // Below 1 m/s a sea is under 4 cm high; what is missing of that is told beside it.
        for speed in [low.max(1.0), high] {
            let mut blown = scene.clone();
            blown.sea.wind.as_mut().unwrap().speed_mps = speed;
            let timeline = Timeline::new(&blown);
            assert_eq!(timeline.layout(), Timeline::new(&scene).layout(), "the wind changes no layout");
            close(timeline.hs_at(0), timeline.wanted_hs_at(0), 0.012);
        }
    }
}
