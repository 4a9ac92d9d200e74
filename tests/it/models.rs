//! Laws of every spectrum and spreading: published values, integrals, and that a layout holds what a model wants.

use std::f64::consts::PI;

use swellcast::scene::{
    DepthCorrection, Scene, SceneFile, Spreading, SpreadingForm, Swell, SwellModel, Water, WindModel, WindSea,
};
use swellcast::sea::{
    self, Dispersion, Elfouhaily, Jonswap, Phillips, Spectrum, Spreader, Timeline, kitaigorodskii, thompson_vincent,
};

use crate::support::{close, scene};

fn blown(model: WindModel, speed_mps: f64) -> WindSea {
    WindSea { model, ..WindSea::jonswap(speed_mps, 250.0, 300e3) }
}

/// 4 sqrt(m0) of a wind over deep water.
fn wanted_hs(wind: WindSea, water: Water) -> f64 {
    let mut scene = Scene { ..scene("name = \"m\"") };
    (scene.sea.wind, scene.sea.water) = (Some(wind), water);
    4.0 * Spectrum::new(&scene.sea).m0().sqrt()
}

#[test]
fn the_depth_factor_has_its_published_values_and_its_approximation_is_near() {
    let dispersion = |depth_m: f64| {
        Dispersion::new(Water { depth_m, dispersion: swellcast::scene::DispersionLaw::Finite, ..Water::default() })
    };
    for (wh, phi) in [(0.5, 0.1248), (1.0, 0.4828), (1.5, 0.8785), (2.0, 0.9934)] {
        // wh = w sqrt(d / g), at any depth.
        for depth_m in [0.5, 10.0, 300.0] {
            let k = dispersion(depth_m).wavenumber(wh * (9.81_f64 / depth_m).sqrt());
            close(kitaigorodskii(k * depth_m), phi, 1e-3);
        }
        assert!((thompson_vincent(wh) - phi).abs() < 0.04, "wh {wh}");
    }
    assert_eq!((kitaigorodskii(1e9), thompson_vincent(1e9)), (1.0, 1.0));
    assert!(kitaigorodskii(1e-12) < 1e-20);
}

#[test]
fn pierson_and_moskowitz_have_their_published_height_and_peaks() {
    let u19 = blown(WindModel::PiersonMoskowitzU19, 10.0);
    let wind_at_19 = 1.026 * 10.0_f64;
    close(wanted_hs(u19, Water::default()) * 9.81 / wind_at_19.powi(2), 0.2092, 1e-3);
    close(Jonswap::of_wind(&u19, 9.81).unwrap().peak(), 0.877 * 9.81 / wind_at_19, 1e-9);
    let u10 = Jonswap::of_wind(&blown(WindModel::PiersonMoskowitzU10, 12.0), 9.81).unwrap();
    close(u10.peak() / (2.0 * PI), 0.13 * 9.81 / 12.0, 1e-9);
}

#[test]
fn phillips_has_its_closed_form_and_can_be_scaled_to_a_height() {
    // m0 = alpha / 4 L^2 without the small-wave cut.
    let wind = WindSea { spreading: Spreading::default(), ..blown(WindModel::Phillips, 10.0) };
    let largest = 100.0 / 9.81;
    close(wanted_hs(wind, Water::default()), 4.0 * (0.25 * 8.1e-3_f64).sqrt() * largest, 1e-3);
    let scaled = WindSea { hs_m: Some(2.5), ..wind };
    close(wanted_hs(scaled, Water::default()), 2.5, 1e-9);
    // The small-wave cut is exp(-k^2 l^2), and takes energy.
    let cut = WindSea { small_wave_m: 1.0, ..wind };
    let (plain, cut_at) =
        (Phillips::of_wind(&wind, &Water::default()).unwrap(), Phillips::of_wind(&cut, &Water::default()).unwrap());
    close(cut_at.density(0.7), plain.density(0.7) * (-0.49_f64).exp(), 1e-9);
    assert!(wanted_hs(cut, Water::default()) < wanted_hs(wind, Water::default()));
}

#[test]
fn elfouhaily_is_never_negative_and_as_steep_as_the_sun_glitter_says() {
    for speed in [0.3, 1.0, 2.0, 2.6, 5.0, 10.0, 20.0, 60.0] {
        let shape = Elfouhaily::of_wind(&blown(WindModel::Elfouhaily, speed), &Water::default()).unwrap();
        for i in -40..80 {
            let k = 10_f64.powf(f64::from(i) / 16.0);
            assert!(shape.density(k) >= 0.0 && shape.density(k).is_finite(), "{speed} m/s, {k} rad/m");
        }
    }
    // Its mean square slope is near Cox & Munk's, .003 + 5.12e-3 U (1954), which is what it was made for.
    for speed in [5.0, 10.0, 15.0] {
        let shape =
            Elfouhaily::of_wind(&WindSea { fetch_m: 1e7, ..blown(WindModel::Elfouhaily, speed) }, &Water::default());
        let slopes = |k: f64, _: f64, _: f64| k * k * shape.unwrap().density(k);
        let mss = Dispersion::new(Water::default()).integrate(1e-3, 1e4, slopes);
        close(mss, 0.003 + 5.12e-3 * speed, 0.25);
    }
    // Fully developed, its height is near that of Pierson & Moskowitz.
    let developed = WindSea { fetch_m: 1e7, ..blown(WindModel::Elfouhaily, 10.0) };
    close(wanted_hs(developed, Water::default()), 0.024 * 100.0, 0.2);
}

#[test]
fn two_ochi_hubble_peaks_hold_their_heights() {
    for lambda in [0.5, 1.0, 3.0, 20.0] {
        let peak = |hs_m, tp_s| Swell { model: SwellModel::OchiHubble, hs_m, tp_s, lambda, ..Swell::default() };
        let mut scene = scene("name = \"m\"");
        scene.sea.swells = vec![peak(2.0, 14.0), peak(1.5, 7.0)];
        let spectrum = Spectrum::new(&scene.sea);
        close(spectrum.m0(), (4.0 + 2.25) / 16.0, 1e-12);
        let (low, high) = spectrum.range().unwrap();
        let dispersion = Dispersion::new(Water::default());
        // Over all directions: 64 of them, evenly.
        let density = |k: f64, _: f64, _: f64| {
            let at = |i: u32| {
                let theta = f64::from(i) * PI / 64.0;
                spectrum.density(k * theta.cos(), k * theta.sin()) * k * PI / 64.0
            };
            (0..128).map(at).sum()
        };
        // The long tail of a small lambda ends at 150 peaks.
        close(dispersion.integrate(low, high, density), spectrum.m0(), 1e-3);
    }
}

#[test]
fn every_spreading_integrates_to_one() {
    let steps = 3600;
    let width = 2.0 * PI / f64::from(steps);
    for form in SpreadingForm::ALL {
        for (s, against_wind, blend, elongation) in
            [(0.0, 0.0, 0.0, 0.0), (75.0, 0.3, 0.0, 0.5), (1000.0, 1.0, 0.4, 1.0), (4.0, 0.0, 1.0, 0.2)]
        {
            let with = SpreadingForm::DonelanBanner;
            let spreader = Spreader::new(Spreading { form, s, against_wind, blend, with }, 0.9, elongation);
            for x in [0.05, 0.3, 0.56, 0.7, 0.95, 1.0, 1.3, 1.6, 2.0, 5.0, 30.0] {
                let at = |i: i32| spreader.density(x, (f64::from(i) * width - PI).cos());
                let sum: f64 = (0..steps).map(at).sum::<f64>() * width;
                assert!(
                    (sum - 1.0).abs() < 1e-3,
                    "{form:?} s {s} against {against_wind} blend {blend} xi {elongation} at {x}: {sum}"
                );
            }
        }
    }
}

#[test]
fn exponents_and_widths_have_their_published_values() {
    for (got, want) in [
        (sea::mitsuyasu_s(1.0, 1.0), 11.5),
        (sea::mitsuyasu_s(2.0, 1.0), 11.5 * 2_f64.powf(-2.5)),
        (sea::mitsuyasu_s(0.5, 0.84), 11.5 * 0.84_f64.powf(-2.5) / 32.0),
        (sea::hasselmann_s(1.0, 1.0), 6.97),
        (sea::hasselmann_s(0.8, 1.0), 6.97 * 0.8_f64.powf(4.06)),
        (sea::hasselmann_s(2.0, 1.17), 9.77 * 2_f64.powf(-2.33)),
        (sea::hasselmann_s(2.0, 1.0), 9.77 * 2_f64.powf(-2.33 + 1.45 * 0.17)),
        (sea::donelan_banner_beta(0.3), 2.61 * 0.56_f64.powf(1.3)),
        (sea::donelan_banner_beta(0.8), 2.61 * 0.8_f64.powf(1.3)),
        (sea::donelan_banner_beta(1.0), 2.28),
        (sea::donelan_banner_beta(1.5), 2.28 * 1.5_f64.powf(-1.3)),
        (sea::donelan_banner_beta(2.0), 10_f64.powf(-0.4 + 0.8393 * (-0.567 * 4_f64.ln()).exp())),
        (sea::horvath_swell_s(1.0, 1.0), 16.0 * 1_f64.tanh()),
        (sea::horvath_swell_s(0.5, 0.5), 4.0 * 2_f64.tanh()),
    ] {
        close(got, want, 1e-9);
    }
}

#[test]
fn the_depth_factor_leaves_a_saturated_range_as_it_is() {
    // Kitaigorodskii's factor is the one that keeps alpha / 2 k^-3 at any depth (Bouws et al. 1985).
    let mut shallow = scene("name = \"m\"");
    let wind = WindSea { spreading: Spreading::cos2s(0.0), ..blown(WindModel::Phillips, 60.0) };
    (shallow.sea.wind, shallow.sea.water.depth_m) = (Some(wind), 8.0);
    let spectrum = Spectrum::new(&shallow.sea);
    for k in [0.1, 0.15, 0.5, 3.0] {
        // Far above the peak of .002 rad/m, in water that is shallow for the first of them.
        close(spectrum.density(k, 0.0) * 2.0 * PI * k, 0.5 * 8.1e-3 / (k * k * k), 0.02);
    }
    let (deep, flat) = (Water::default(), Water { depth_m: 8.0, ..Water::default() });
    for model in [WindModel::Phillips, WindModel::Elfouhaily] {
        let hs = |water| wanted_hs(blown(model, 12.0), water);
        assert!(hs(flat) < 0.9 * hs(deep) && hs(flat) > 0.2 * hs(deep), "{model:?}: {} of {}", hs(flat), hs(deep));
        close(hs(Water { depth_m: 1e4, ..deep }), hs(deep), 1e-3);
        let parabolas = WindSea { depth_correction: DepthCorrection::ThompsonVincent, ..blown(model, 12.0) };
        close(wanted_hs(parabolas, flat), hs(flat), 0.04);
    }
}

#[test]
fn cos_squared_sends_nothing_behind_unless_told() {
    let at = |against_wind: f64, cos: f64| {
        let form = SpreadingForm::Cos2;
        Spreader::new(Spreading { form, against_wind, ..Spreading::default() }, 1.0, 0.0).density(1.0, cos)
    };
    assert_eq!(at(0.0, -0.5), 0.0);
    close(at(0.0, 1.0), 2.0 / PI, 1e-12);
    close(at(0.2, -1.0), 0.2 * at(0.2, 1.0), 1e-12);
}

fn resolved_share(scene: &Scene) -> f64 {
    let timeline = Timeline::new(scene);
    timeline.hs_at(0) / timeline.wanted_hs_at(0)
}

#[test]
fn an_automatic_layout_holds_every_model_with_every_spreading() {
    let settings = |form, blend, elongation| {
        (Spreading { form, s: 75.0, against_wind: 0.1, blend, with: SpreadingForm::Uniform }, elongation)
    };
    let mut spreadings: Vec<_> = SpreadingForm::ALL.into_iter().map(|form| settings(form, 0.0, 0.0)).collect();
    spreadings.push(settings(SpreadingForm::DonelanBanner, 0.3, 1.0));
    let mut worst: f64 = 0.0;
    for (i, (spreading, elongation)) in spreadings.into_iter().enumerate() {
        let mut hold = |mut asked: SceneFile, what: String| {
            asked.effects.foam = false;
            let share = resolved_share(&asked.check(None).unwrap());
            worst = worst.max((share - 1.0).abs());
            assert!((share - 1.0).abs() < 0.01, "{what} with {spreading:?}: Hs {share} of the wanted one");
        };
        for (j, model) in WindModel::ALL.into_iter().enumerate() {
            // Winds in turn: all pairs of model and spreading, not all triples.
            let speed = [4.0, 9.0, 18.0][(i + j) % 3];
            let wind = swellcast::scene::WindFile {
                model,
                speed_mps: speed,
                spreading: Some(spreading),
                swell: elongation,
                range_mps: [speed; 2],
                ..Default::default()
            };
            hold(SceneFile { wind: Some(wind), ..SceneFile::default() }, format!("{model:?} at {speed} m/s"));
        }
        for model in [SwellModel::Jonswap, SwellModel::OchiHubble] {
            let swell =
                Swell { model, hs_m: 2.0, tp_s: 18.0, gamma: 7.0, spreading, swell: elongation, ..Swell::default() };
            hold(SceneFile { swell: vec![swell], ..SceneFile::default() }, format!("a swell by {model:?}"));
        }
    }
    println!("worst: {worst:.5} of Hs");
}

#[test]
fn shallow_water_flattens_a_wind_sea_and_only_when_asked() {
    let shallow = Water { depth_m: 5.0, ..Water::default() };
    let hs =
        |depth_correction, water| wanted_hs(WindSea { depth_correction, ..blown(WindModel::Jonswap, 12.0) }, water);
    let deep = hs(DepthCorrection::Kitaigorodskii, Water::default());
    close(hs(DepthCorrection::None, shallow), deep, 1e-4);
    assert!(hs(DepthCorrection::Kitaigorodskii, shallow) < 0.5 * deep);
    close(hs(DepthCorrection::ThompsonVincent, shallow), hs(DepthCorrection::Kitaigorodskii, shallow), 0.04);
}
