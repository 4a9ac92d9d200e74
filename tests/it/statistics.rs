//! Laws of what a sea says of itself: promises, periods, slopes, folds, and what it warns of.

use std::f64::consts::PI;

use swellcast::plan::Field;
use swellcast::scene::{PRESETS, Swell, WMO_UPPER_HS_M, preset, wmo_sea_state};
use swellcast::sea::{Dispersion, FREQUENCY_BIN, Spectrum, Strain, Timeline};

use crate::support::{close, cpu_fields, scene};

#[test]
fn every_preset_keeps_what_it_promises() {
    for (name, _) in PRESETS {
        let scene = preset(name).unwrap();
        let promise = scene.promise.unwrap_or_else(|| panic!("{name} promises nothing"));
        let statistics = Timeline::new(&scene).statistics_at(0);
        close(statistics.hs_m, promise.hs_m, 0.02);
        close(statistics.hs_m, statistics.wanted_hs_m, 0.01);
        assert_eq!(statistics.sea_state, promise.sea_state, "{name}: {} m", statistics.hs_m);
    }
}

#[test]
fn a_sea_state_is_what_the_code_table_says() {
    for (state, upper) in WMO_UPPER_HS_M.into_iter().enumerate() {
        assert_eq!((wmo_sea_state(upper), wmo_sea_state(upper + 1e-9)), (state as u8, state as u8 + 1));
    }
    assert_eq!(wmo_sea_state(99.0), 9);
}

/// Peak period of the wanted spectrum, by its density over frequency, summed over all directions.
fn wanted_tp(spectrum: &Spectrum, dispersion: &Dispersion) -> f64 {
    let over_frequency = |omega: f64| -> f64 {
        let k = dispersion.wavenumber(omega);
        let at = |i: i32| spectrum.density(k * (f64::from(i) * 0.05).cos(), k * (f64::from(i) * 0.05).sin());
        (0..126).map(at).sum::<f64>() * k / dispersion.group_velocity(k)
    };
    let omegas = (0..1600).map(|i| 0.2 * 1.0025_f64.powi(i));
    2.0 * PI / omegas.max_by(|a, b| over_frequency(*a).total_cmp(&over_frequency(*b))).unwrap()
}

#[test]
fn the_peak_period_of_the_modes_is_that_of_the_spectrum_within_a_bin() {
    for (name, _) in PRESETS {
        let mut scene = preset(name).unwrap();
        scene.effects.foam = None;
        let got = Timeline::new(&scene).statistics_at(0).tp_s.unwrap();
        let want = wanted_tp(&Spectrum::new(&scene.sea), &Dispersion::new(scene.sea.water));
        println!("{name}: {got:.3} s, {want:.3} s");
        assert!((got / want).ln().abs() <= FREQUENCY_BIN.ln(), "{name}: {got} s, {want} s");
    }
}

#[test]
fn a_single_swell_has_its_own_numbers() {
    let mut swell = scene("name = \"s\"");
    swell.sea.swells = vec![Swell { hs_m: 2.0, tp_s: 12.0, direction_from_deg: 75.0, ..Swell::default() }];
    let statistics = Timeline::new(&swell).statistics_at(0);
    close(statistics.hs_m, 2.0, 0.01);
    close(statistics.tp_s.unwrap(), 12.0, 0.03);
    close(statistics.direction_from_deg.unwrap(), 75.0, 0.01);
    // cos^2s: r1 = s / (s + 1), spread sqrt(2 (1 - r1)).
    close(statistics.spread_deg.unwrap(), (2.0 / 26.0_f64).sqrt().to_degrees(), 0.01);
    let flat = Timeline::new(&scene("name = \"flat\"")).statistics_at(0);
    assert_eq!((flat.hs_m, flat.tp_s, flat.direction_from_deg, flat.folded_fraction), (0.0, None, None, 0.0));
}

#[test]
fn slopes_and_folds_of_the_modes_are_those_of_their_grids() {
    // Exaggerated choppiness, so that folds are counted and not guessed.
    let mut sea = scene("name = \"f\"\n[wind]\nspeed_mps = 18\n[effects]\nchoppiness = 5\nfoam = false");
    let (mut slope, mut expected_slope) = (0.0, 0.0);
    let (mut folded, mut expected) = (0.0, 0.0);
    for seed in 0..6 {
        sea.seed = seed;
        let timeline = Timeline::new(&sea);
        let cascade = 1;
        let fields = cpu_fields(&timeline, 500, cascade, &[Field::SlopeX, Field::SlopeZ, Field::Jacobian]);
        let count = fields[0].len() as f64;
        slope += fields[0].iter().chain(&fields[1]).map(|s| f64::from(*s).powi(2)).sum::<f64>() / count;
        folded += fields[2].iter().filter(|j| **j < 0.0).count() as f64 / count;
        let table = swellcast::sea::EnergyTable::build(&sea.sea, timeline.layout());
        let here = &timeline.layout().cascades[cascade];
        let mss = here.wave_vectors().zip(&table.energy[cascade]);
        expected_slope += mss.map(|((kx, kz), e)| (kx * kx + kz * kz) * e).sum::<f64>();
        expected += table.strain[cascade].below(0.0, 5.0);
    }
    println!("slope {slope:.5} of {expected_slope:.5}, folded {folded:.5} of {expected:.5}");
    close(slope, expected_slope, 0.05);
    assert!(expected > 1e-3);
    close(folded, expected, 0.15);
}

#[test]
fn strain_that_is_one_wave_folds_where_its_crest_does() {
    let dispersion = Dispersion::new(Default::default());
    // Along x alone: J = 1 + Dxx, normal with deviation k a.
    let strain = Strain::of_mode(&dispersion, 2.0, 0.0, 0.04);
    close(strain.stretch(), 0.4, 1e-9);
    // Whichever way it runs.
    close(Strain::of_mode(&dispersion, 1.2, -1.6, 0.04).stretch(), 0.4, 1e-9);
    // P(z < -1 / .4) of a normal number.
    close(strain.below(0.0, 1.0), 0.006_209_7, 0.02);
    close(strain.below(1.0, 1.0), 0.5, 0.05);
    assert_eq!(Strain::default().below(0.5, 1.0), 0.0);
}

#[test]
fn a_hand_made_layout_that_loses_energy_says_how_much_and_where() {
    let warnings = |cascades: &str| {
        let text = format!("name = \"w\"\n[wind]\nspeed_mps = 9\n[effects]\nfoam = false\n[cascades]\n{cascades}");
        Timeline::new(&scene(&text)).warnings().to_vec()
    };
    assert!(warnings("").is_empty() && warnings("patches_m = [1600, 300, 56]").is_empty());
    let short = warnings("n = 64\npatches_m = [1600]");
    println!("{short:?}");
    assert!(short.len() == 1 && short[0].contains("% in waves shorter than"), "{short:?}");
    let long = warnings("patches_m = [20.0, 5.0]");
    println!("{long:?}");
    assert!(long.len() == 1 && long[0].contains("% in longer ones"), "{long:?}");
    let share =
        |text: &str| text.split("leave out ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
    assert!(share(&short[0]) > 5.0 && share(&long[0]) > 80.0);
}

#[test]
fn a_grid_is_as_fine_as_the_waves_need_unless_one_is_asked_for() {
    let grid = |text: &str| {
        let timeline = Timeline::new(&scene(&format!("name = \"n\"\n{text}\n[effects]\nfoam = false")));
        let cascades = &timeline.layout().cascades;
        (cascades[0].n, cascades.len())
    };
    let swell = "[[swell]]\nhs_m = 1\ntp_s = 10\n";
    // Metres are all a long swell needs.
    let (n, count) = grid(&format!("{swell}[cascades]\nfinest_wavelength_m = 60"));
    assert!(count <= 2 && n <= 256, "{n} {count}");
    let waves_only_of_10_s = "[measured]\nbins = [[0.095, 0.0], [0.1, 9.0], [0.105, 0.0]]\n";
    assert_eq!(grid(waves_only_of_10_s), (128, 1));
    assert_eq!(grid("[wind]").0, 256);
    assert_eq!(grid("[wind]\n[cascades]\nn = 64").0, 64);
}
