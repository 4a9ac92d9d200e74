//! Where the energy of trochoids and noise lies.

use super::*;
use crate::support::close;
use swellcast::reference;
use swellcast::sea::{OCTAVE_CENTRE, OCTAVE_VARIANCE, kept_waves, kernel_energies, turbulence};

/// Rings of a quarter of an octave.
fn edges() -> Vec<f64> {
    (0..40).map(|i| 0.71 * 1.19_f64.powi(i)).take_while(|edge| *edge < 129.0).collect()
}

/// Wanted and found energy by ring: modes of a sea, and grids of n x n at several hours.
fn spectra(sea: &Sea, n: usize) -> (Vec<f64>, Vec<f64>) {
    const TIMES: i64 = 8;
    let want = rings(&edges(), mode_energies(&sea.cascades[0]).into_iter());
    let mut got = vec![0.0; want.len()];
    for time in 0..TIMES {
        let grid = filled(sea, time * 7200 * 3600, n, &[Field::Height]).remove(0);
        let found = energies(n, &grid);
        let found = rings(&edges(), found.iter().enumerate().map(|(i, energy)| (radius(n, i), *energy)));
        got.iter_mut().zip(found).for_each(|(sum, energy)| *sum += energy / TIMES as f64);
    }
    (want, got)
}

#[test]
fn the_spectrum_follows_the_wanted_one_from_the_peak_to_nyquist() {
    for components in [16, 64, 256, 1024] {
        for seed in [1, 2] {
            let mut scene = preset_with(components, true);
            scene.seed = seed;
            let sea = Timeline::new(&scene).at(0);
            let (want, got) = spectra(&sea, 256);
            let decibels: Vec<f64> = got.iter().zip(&want).map(|(got, want)| 10.0 * (got / want).log10()).collect();
            let peak = (0..want.len()).max_by(|a, b| want[*a].total_cmp(&want[*b])).unwrap();
            let worst =
                decibels[peak..].iter().fold(0.0_f64, |worst, db| if db.abs() > worst.abs() { *db } else { worst });
            let excess = got[..peak].iter().zip(&want).map(|(got, want)| (got - want).max(0.0)).sum::<f64>();
            let (all, total): (f64, f64) = (want.iter().sum(), got.iter().sum());
            println!(
                "K {components}: {worst:+.2} dB, below the peak {:.1} % of m0, m0 {:.3}",
                100.0 * excess / all,
                total / all
            );
            assert!(worst.abs() < if components >= 64 { 1.5 } else { 3.0 }, "K {components}: {decibels:?}");
            // Where the grid that waves are kept from ends, the noise goes on: in value, and so in slope.
            let join = edges().partition_point(|edge| *edge <= 32.0) - 1;
            assert!(decibels[join - 1..=join + 1].iter().all(|db| db.abs() < 1.0), "K {components}: {decibels:?}");
            assert!(excess < 0.10 * all && (total / all - 1.0).abs() < 0.1, "{excess} and {total} of {all}");
        }
    }
}

#[test]
fn without_noise_the_spectrum_ends_with_the_trochoids() {
    // What the law above is good for: it fails where the noise is missing.
    let (want, got) = spectra(&Timeline::new(&preset_with(64, false)).at(0), 256);
    assert!(got.last().unwrap() < &(0.01 * want.last().unwrap()));
}

#[test]
fn the_spectrum_of_an_octave_is_the_square_of_its_kernel_s_transform() {
    // One octave alone: a sea whose fit has nothing but noise to offer, at the place of its strongest octave.
    let sea = Timeline::new(&preset_with(1, true)).at(0);
    let modes = &sea.cascades[0];
    let strongest = |sea: &Sea| {
        let octaves = turbulence(&sea.cascades[0], sea, &[]);
        octaves.into_iter().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)).unwrap()
    };
    let mut octave = strongest(&sea);
    octave.amplitude = 1.0;
    let (n, cells) = (64_usize, f64::from(octave.cells));
    let mut found = vec![0.0; n * n];
    const SEEDS: u64 = 60;
    for seed in 0..SEEDS {
        let step = modes.cascade.patch_m / n as f64;
        let at = |i: usize| {
            let (x, z) = ((i % n) as f64 * step, (i / n) as f64 * step);
            reference::noise(&[octave], (seed, 0), modes.cascade.patch_m, sea.repeat, 123_456_789, x, z) as f32
        };
        let grid: Vec<f32> = (0..n * n).map(at).collect();
        found.iter_mut().zip(energies(n, &grid)).for_each(|(sum, energy)| *sum += energy / SEEDS as f64);
    }
    let signed = |j: usize| if j < n / 2 { j as f64 } else { j as f64 - n as f64 };
    let closed = |i: usize| {
        let [(a, b), (c, d)] = [i % n, i / n].map(|j| kernel_energies(2.0 * PI * signed(j) / cells));
        (a * d + b * c) / (2.0 * cells * cells)
    };
    let edges: Vec<f64> = (0..9).map(|i| cells * (0.2 + 0.1 * f64::from(i))).collect();
    let ring = |energy: &dyn Fn(usize) -> f64| rings(&edges, (0..n * n).map(|i| (radius(n, i), energy(i))));
    let (found_rings, closed_rings) = (ring(&|i| found[i]), ring(&closed));
    for (found, closed) in found_rings.iter().zip(&closed_rings) {
        close(*found, *closed, 0.06);
    }
    close(found.iter().sum::<f64>(), OCTAVE_VARIANCE, 0.02);
    let total: f64 = (0..n * n).map(closed).sum();
    close(total, OCTAVE_VARIANCE, 0.01);
    close((0..n * n).map(|i| closed(i) * radius(n, i)).sum::<f64>() / total / cells, OCTAVE_CENTRE, 0.01);
}

#[test]
fn a_coarse_grid_folds_back_less_than_a_hundredth() {
    for (choppiness, depth) in [(1.0, f64::INFINITY), (5.0, f64::INFINITY), (2.0, 3.0)] {
        let mut scene = preset_with(64, true);
        scene.effects.choppiness = choppiness;
        scene.sea.water.depth_m = depth;
        let sea = Timeline::new(&scene).at(0);
        let trochoids = Trochoids::new(&sea.cascades[0], &sea);
        let patch = sea.cascades[0].cascade.patch_m;
        for n in [32, 64, 128] {
            let coarse = filled(&sea, 777, n, &[Field::Height]).remove(0);
            let total = coarse.iter().map(|h| f64::from(*h).powi(2)).sum::<f64>() / (n * n) as f64;
            // The same waves and octaves, seen finely: what of them lies beyond the coarse grid's Nyquist wavenumber.
            let fine = 4 * n;
            let at = |i: usize| ((i % fine) as f64 * patch / fine as f64, (i / fine) as f64 * patch / fine as f64);
            let points: Vec<(f64, f64)> = (0..fine * fine).map(at).collect();
            let heights: Vec<f32> = trochoids.points(777, &points, patch / n as f64).iter().map(|p| p[0]).collect();
            let found = energies(fine, &heights);
            let half = |j: usize| j.min(fine - j) >= n / 2;
            let beyond: f64 = (0..fine * fine).filter(|i| half(i % fine) || half(i / fine)).map(|i| found[i]).sum();
            println!("choppiness {choppiness}, {n}: {:.3} % folded back, variance {total:.3}", 100.0 * beyond / total);
            assert!(beyond < 0.01 * total, "{n}: {beyond} of {total}");
        }
    }
}

#[test]
fn more_components_keep_more_and_what_is_missing_is_what_was_left_out() {
    let mut last = 0.0;
    for components in [16, 64, 256, 1024] {
        let mut scene = preset_with(components, false);
        scene.effects.choppiness = 0.0;
        let sea = Timeline::new(&scene).at(0);
        let kept = kept_waves(&sea.cascades[0], &sea);
        assert_eq!(kept.len(), components);
        let energy: f64 = kept.iter().map(|wave| 0.5 * wave.amplitude * wave.amplitude).sum();
        assert!(energy > last, "{energy} after {last}");
        last = energy;
        // Of every wave, that share of the amplitude that is missing.
        let all: f64 = mode_energies(&sea.cascades[0]).iter().map(|(_, energy)| energy).sum();
        let whole = |wave: &TrochoidWave| {
            let modes = &sea.cascades[0];
            let mode = &modes.modes[wave.n as usize * modes.rows() + (modes.cascade.half as i32 + wave.m) as usize];
            2.0 * if wave.along > 0.0 { mode.forward.norm() } else { mode.backward.norm() }
        };
        let missing = all - kept.iter().map(|wave| 0.5 * whole(wave).powi(2)).sum::<f64>()
            + kept.iter().map(|wave| 0.5 * (whole(wave) - wave.amplitude).powi(2)).sum::<f64>();
        let tick = 5_000_000;
        let full = reference::fields(&sea, 0, tick, &[Field::Height]).remove(0);
        let got = filled(&sea, tick, 256, &[Field::Height]).remove(0);
        let error = got.iter().zip(&full).map(|(a, b)| (f64::from(*a) - b).powi(2)).sum::<f64>() / full.len() as f64;
        println!("K {components}: keeps {:.3}, error {error:.5} m^2, left out {missing:.5} m^2", energy / all);
        // Waves that run against each other with one length stand still together for a while: one moment is not the mean.
        close(error, missing, 2e-2);
    }
}
