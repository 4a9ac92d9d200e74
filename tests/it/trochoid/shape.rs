//! One trochoid: its profile, its moments, its water.

use super::*;
use swellcast::pass::trochoid::{Profile, ProfileShape, look_up, slope};
use swellcast::reference;
use swellcast::sea::orbit;

const STEEPNESSES: [f64; 14] = [0.0, 0.01, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 0.9, 0.97, 0.999, 1.0];

/// cos(theta) and its derivative by psi, as the fast path has them.
fn fast(profile: &Profile, psi: u32) -> (f64, f64) {
    match profile.shape(usize::MAX) {
        ProfileShape::Table(table) => {
            let (cos, sin) = look_up(table, psi);
            (f64::from(cos), f64::from(slope(profile.steepness, cos, sin)))
        }
        ProfileShape::Series(polynomial) => {
            let angle = (f64::from(psi) / 4_294_967_296.0 * 2.0 * PI) as f32;
            let (mut y, mut dy) = (0.0_f32, 0.0_f32);
            for a in polynomial.coefficients[..=polynomial.degree].iter().rev() {
                (y, dy) = (y * angle.cos() + a, dy * angle.cos() + y);
            }
            (f64::from(y - 0.5 * profile.steepness), f64::from(-angle.sin() * dy))
        }
    }
}

#[test]
fn a_profile_is_kepler_s_within_a_ten_thousandth_of_its_radius() {
    for s in STEEPNESSES {
        let profile = Profile::new(s);
        let (mut worst, mut worst_slope) = (0.0_f64, 0.0_f64);
        for i in 0..20_000_u32 {
            let psi = i.wrapping_mul(214_748).wrapping_add(i * i % 9973);
            let theta = reference::kepler(s, f64::from(psi) / 4_294_967_296.0 * 2.0 * PI);
            let (cos, rate) = fast(&profile, psi);
            worst = worst.max((cos - theta.cos()).abs());
            worst_slope = worst_slope.max((rate + theta.sin() / (1.0 - s * theta.cos())).abs());
        }
        println!("s {s}: {worst:.1e} of r, slope {worst_slope:.1e} of k r");
        assert!(worst <= 1e-4, "s {s}: {worst:e}");
        // A cusp has no slope: it is blunted.
        assert!(s > 0.9 || worst_slope <= 3e-3, "s {s}: slope {worst_slope:e}");
    }
}

#[test]
fn a_trochoid_has_no_mean_and_the_variance_of_its_mode() {
    for (amplitude, chop_k) in [(1.0, 0.0), (1.0, 0.1), (2.0, 0.2), (0.5, 1.0), (1.0, 0.7), (1.0, 0.7069), (3.0, 5.0)] {
        let (r, s) = orbit(amplitude, chop_k);
        assert!((s - (chop_k * r).min(1.0)).abs() < 1e-12, "steepness {s} of {}", chop_k * r);
        let samples = 200_000;
        let height = |i: i32| r * (reference::kepler(s, f64::from(i) * 2.0 * PI / f64::from(samples)).cos() + 0.5 * s);
        let (mean, square) = (0..samples).map(height).fold((0.0, 0.0), |(m, q), y| (m + y, q + y * y));
        let (mean, square) = (mean / f64::from(samples), square / f64::from(samples));
        assert!(mean.abs() < 1e-6 * amplitude, "mean {mean} at steepness {s}");
        assert!((square / (0.5 * amplitude * amplitude) - 1.0).abs() < 1e-6, "variance {square} at steepness {s}");
        if s < 1.0 {
            // A wave that is not clamped: the mean of what isn't raised is -k r^2 / 2 where chop is 1.
            assert!((0.5 * r * s - 0.5 * chop_k * r * r).abs() < 1e-12);
        }
    }
}

#[test]
fn a_steep_trochoid_keeps_mean_and_variance_on_a_grid() {
    for slope in [0.05, 0.4, 0.6, 0.75] {
        let (sea, wave) = single(slope / SINGLE_K, 1.0);
        let height = filled(&sea, 1234, 256, &[Field::Height]).remove(0);
        let mean = height.iter().map(|h| f64::from(*h)).sum::<f64>() / height.len() as f64;
        let square = height.iter().map(|h| f64::from(*h).powi(2)).sum::<f64>() / height.len() as f64;
        println!("s {}: mean {mean:e}", wave.steepness);
        assert!(mean.abs() < 1e-4 * wave.radius);
        crate::support::close(square, 0.5 * wave.amplitude * wave.amplitude, 2e-3);
        let crest = height.iter().copied().fold(f32::MIN, f32::max);
        let trough = height.iter().copied().fold(f32::MAX, f32::min);
        assert!(crest > -trough, "crests are higher than troughs are deep: {crest}, {trough}");
    }
}

#[test]
fn water_stays_at_the_surface_that_moves() {
    // What a surface of water must obey: d eta / dt + u d eta / dx + v d eta / dz = w. One trochoid does exactly.
    for (slope, chop) in [(0.1, 1.0), (0.4, 1.0), (0.2, 2.0), (0.1, 0.3)] {
        let (sea, wave) = single(slope / SINGLE_K, chop);
        let mut moved = 0.0_f64;
        for i in 0..50 {
            let (x, z, tick) = (f64::from(i) * 1.37, f64::from(i) * 0.61, i64::from(i) * 997);
            let at = |tick: i64| reference::trochoids(&[wave], 64.0, sea.repeat, tick, x, z);
            let here = at(tick);
            let rate = (at(tick + 1).height - at(tick - 1).height) * 3600.0;
            let carried = here.velocity[0] * here.slope[0] + here.velocity[2] * here.slope[1];
            assert!((rate + carried - here.velocity[1]).abs() < 1e-4, "{rate} + {carried}, {}", here.velocity[1]);
            moved = moved.max(here.velocity[1].abs());
            let speed = here.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
            if chop == 1.0 {
                crate::support::close(speed, wave.omega * wave.radius, 1e-9);
            }
        }
        assert!(moved > 0.5 * wave.omega * wave.radius);
    }
}

#[test]
fn a_trochoid_travels_as_its_mode_does() {
    let (sea, wave) = single(0.3, 0.0);
    let trochoids = Trochoids::new(&sea.cascades[0], &sea);
    for tick in [0, 777, 1_000_003] {
        let full = reference::at(&sea, &sea.cascades, tick, 11.0, 23.0).fields[0];
        let got = f64::from(trochoids.at(tick, 11.0, 23.0, 0.0)[0]);
        assert!((full - got).abs() < 1e-6, "{full} and {got} at {tick}");
    }
    assert_eq!((wave.n, wave.m, wave.steepness, wave.along), (3, 4, 0.0, 1.0));
}
