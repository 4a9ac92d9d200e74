//! Laws of the initial spectra: energy, integrals, dispersion, randomness, exact phase.

use std::f64::consts::PI;

use swellcast::scene::{PRESETS, SceneFile, Water, preset};
use swellcast::sea::{self, Dispersion, Jonswap, Timeline};

fn close(got: f64, want: f64, relative: f64) {
    assert!((got - want).abs() <= relative * want.abs(), "got {got}, want {want} within {relative}");
}

#[test]
fn jonswap_by_wind_and_fetch_has_the_published_heights_and_peaks() {
    for (speed_mps, fetch_m, hs, tp) in
        [(10.0, 1e5, 2.139, 6.232), (15.0, 3e5, 5.647, 10.289), (20.0, 1e5, 3.954, 7.852)]
    {
        let wind = swellcast::scene::WindSea { speed_mps, fetch_m, direction_from_deg: 0.0, gamma: 3.3, swell: 0.0 };
        let jonswap = Jonswap::of_wind(&wind, 9.81).unwrap();
        close(4.0 * jonswap.m0().sqrt(), hs, 1e-3);
        close(2.0 * PI / jonswap.peak(), tp, 1e-3);
    }
}

#[test]
fn spreading_integrates_to_one_for_every_exponent() {
    for s in [0.0, 0.1, 0.5, 1.0, 4.0, 9.9, 50.0, 150.0, 1000.0] {
        let steps = 20_000;
        let width = 2.0 * PI / f64::from(steps);
        let sum: f64 = (0..steps).map(|i| sea::cos2s(s, f64::from(i) * width - PI)).sum();
        // A small s has a cusp at the back, where the sum itself errs.
        close(sum * width, 1.0, 2e-5);
    }
    for (s, norm) in [(0.5, 0.25), (1.0, 0.31831), (4.0, 0.58205), (10.0, 0.90328), (50.0, 1.9997)] {
        close(sea::cos2s(s, 0.0), norm, 1e-4);
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
