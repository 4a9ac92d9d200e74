//! Many trochoids and noise: exact, seamless, steady, the same bits everywhere.

use super::*;
use crate::support::{DAY, TEN_YEARS, close, scene};
use swellcast::reference;
use swellcast::scene::{Change, ChangeKind};
use swellcast::sea::{kept_waves, turbulence};

/// Points of the world, some of them outside the patch.
fn places(patch_m: f64) -> Vec<(f64, f64)> {
    (0..200).map(|i| (f64::from(i) * 0.0317 * patch_m - patch_m, f64::from(i * i % 97) * 0.0211 * patch_m)).collect()
}

#[test]
fn the_fast_path_is_the_reference_at_once_after_a_day_and_after_ten_years() {
    for choppiness in [1.0, 5.0] {
        let mut scene = preset_with(64, true);
        scene.effects.choppiness = choppiness;
        let sea = Timeline::new(&scene).at(0);
        let modes = &sea.cascades[0];
        let (patch, index) = (modes.cascade.patch_m, modes.cascade.index);
        let waves = kept_waves(modes, &sea);
        let octaves = turbulence(modes, &sea, &waves);
        let trochoids = Trochoids::new(modes, &sea);
        let places = places(patch);
        let mut worst = [0.0_f64; 3];
        for tick in [0, DAY + 17, TEN_YEARS + 4711] {
            let got = trochoids.points(tick, &places, 0.0);
            for ((x, z), got) in places.iter().zip(&got) {
                let orbits = reference::trochoids(&waves, patch, sea.repeat, tick, *x, *z);
                let noise = |x, z| reference::noise(&octaves, (sea.seed, index), patch, sea.repeat, tick, x, z);
                let (dx, dz) = (noise(x + 1e-3, *z) - noise(x - 1e-3, *z), noise(*x, z + 1e-3) - noise(*x, z - 1e-3));
                let field = |field: Field| f64::from(got[field as usize]);
                let height = orbits.height + noise(*x, *z);
                worst[0] = worst[0].max((field(Field::Height) - height).abs());
                let slopes = [orbits.slope[0] + 500.0 * dx, orbits.slope[1] + 500.0 * dz];
                for (field_of, want) in [Field::SlopeX, Field::SlopeZ].into_iter().zip(slopes) {
                    worst[1] = worst[1].max((field(field_of) - want).abs());
                    assert_eq!(
                        field(field_of),
                        field(if field_of == Field::SlopeX { Field::NormalX } else { Field::NormalZ })
                    );
                }
                // The trochoids' share alone: noise has its own.
                let drift: f64 = (octaves.iter()).map(|octave| octave.omega * octave.chop * octave.amplitude).sum();
                worst[2] = worst[2].max((field(Field::VelocityX) - orbits.velocity[0]).abs() / drift);
                assert!(
                    [Field::Dx, Field::Dz, Field::Dxx, Field::Dzz, Field::Dxz].into_iter().all(|f| field(f) == 0.0)
                );
            }
        }
        println!("choppiness {choppiness}: height {:.1e} m, slope {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 2e-4 && worst[1] < 1e-4 && worst[2] < 1.0, "{worst:?}");
    }
}

#[test]
fn velocity_and_jacobian_of_trochoids_are_the_reference_s() {
    let mut scene = preset_with(64, false);
    scene.effects.choppiness = 2.0;
    let sea = Timeline::new(&scene).at(0);
    let patch = sea.cascades[0].cascade.patch_m;
    let waves = kept_waves(&sea.cascades[0], &sea);
    let places = places(patch);
    let got = Trochoids::new(&sea.cascades[0], &sea).points(DAY, &places, 0.0);
    for ((x, z), got) in places.into_iter().zip(got) {
        let want = reference::trochoids(&waves, patch, sea.repeat, DAY, x, z);
        let [xx, zz, xz] = want.strain;
        let eigenvalue = 1.0 + 0.5 * (xx + zz) - (0.25 * (xx - zz) * (xx - zz) + xz * xz).sqrt();
        for (field, want, bound) in [
            (Field::VelocityX, want.velocity[0], 1e-4),
            (Field::VelocityY, want.velocity[1], 1e-4),
            (Field::VelocityZ, want.velocity[2], 1e-4),
            (Field::Jacobian, (1.0 + xx) * (1.0 + zz) - xz * xz, 2e-5),
            (Field::Eigenvalue, eigenvalue, 2e-5),
        ] {
            let got = f64::from(got[field as usize]);
            assert!((got - want).abs() < bound, "{field:?}: {got}, {want}");
        }
    }
}

#[test]
fn the_orbits_squeeze_the_water_as_much_as_those_of_all_modes() {
    let timeline = Timeline::new(&preset_with(64, true));
    let sea = Sea { model: Model::Fft, ..timeline.at(0) };
    let mut cpu = Cpu::new(Some(2));
    cpu.load(&sea).unwrap();
    let surface = cpu.step(0, &crate::support::plan(&sea, &[Field::Jacobian])).unwrap();
    let all = surface.cascades[0].plane(Field::Jacobian).unwrap().to_vec();
    let trochoids = filled(&timeline.at(0), 0, 256, &[Field::Jacobian]).remove(0);
    let rms = |jacobian: &[f32]| {
        (jacobian.iter().map(|j| (f64::from(*j) - 1.0).powi(2)).sum::<f64>() / jacobian.len() as f64).sqrt()
    };
    let tenth = |jacobian: &[f32], share: f64| {
        let mut sorted = jacobian.to_vec();
        sorted.sort_by(f32::total_cmp);
        sorted[(share * sorted.len() as f64) as usize]
    };
    for share in [0.001, 0.01, 0.1] {
        println!("{share} of the area below {} of {}", tenth(&trochoids, share), tenth(&all, share));
    }
    println!("rms of J - 1: {:.4} of {:.4}", rms(&trochoids), rms(&all));
    close(rms(&trochoids), rms(&all), 0.2);
}

#[test]
fn a_loop_shorter_than_its_waves_does_not_pulse() {
    let mut scene = preset_with(1, true);
    scene.repeat.ticks = 7200;
    let sea = Timeline::new(&scene).at(0);
    let octaves = turbulence(&sea.cascades[0], &sea, &[]);
    let coarse = octaves.iter().filter(|octave| octave.changes == 1).copied().collect::<Vec<_>>();
    assert!(!coarse.is_empty());
    let at = |tick| reference::noise(&coarse, (1, 0), 1000.0, sea.repeat, tick, 123.0, 456.0);
    assert_eq!(at(0), at(3600), "what has one draw and no way to drift is still");
    let both: Vec<f32> =
        [0, 3600].map(|tick| Trochoids::new(&sea.cascades[0], &sea).at(tick, 1.0, 2.0, 400.0)[0]).into();
    assert_eq!(both[0], both[1]);
}

#[test]
fn a_grid_has_what_its_points_have() {
    let sea = Timeline::new(&preset_with(64, true)).at(0);
    let trochoids = Trochoids::new(&sea.cascades[0], &sea);
    for n in [256, 64, 20] {
        let grid = filled(&sea, 4321, n, &Field::ALL[..15]);
        let step = sea.cascades[0].cascade.patch_m / n as f64;
        for i in (0..n * n).step_by(37) {
            let (x, z) = ((i % n) as f64 * step, (i / n) as f64 * step);
            let point = trochoids.at(4321, x, z, step);
            for (field, plane) in grid.iter().enumerate() {
                assert!((plane[i] - point[field]).abs() < 2e-5, "{field} of {i}: {} {}", plane[i], point[field]);
            }
        }
        let fewer = filled(&sea, 4321, n, &[Field::Height]);
        assert!(fewer[0].iter().zip(&grid[0]).all(|(a, b)| (a - b).abs() < 2e-6), "height alone is the same height");
    }
}

#[test]
fn the_sea_closes_with_its_repeat_and_is_the_same_on_any_number_of_threads() {
    for loop_s in [None, Some(20)] {
        let mut scene = preset_with(64, true);
        scene.repeat.ticks = loop_s.map_or(scene.repeat.ticks, |seconds| seconds * 7200);
        let sea = Timeline::new(&scene).at(0);
        let at = |tick: i64, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| filled(&sea, tick, 128, &Field::ALL[..15]))
        };
        let bits = |planes: &[Vec<f32>]| planes.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        let first = at(1111, 1);
        assert!(bits(&first) == bits(&at(1111, 2)), "threads decide");
        assert!(bits(&first) == bits(&at(1111 + sea.repeat as i64, 2)), "the repeat is no repeat");
        assert!(bits(&first) == bits(&at(1111 - 3 * sea.repeat as i64, 2)), "nor before the beginning");
        assert!(bits(&first) != bits(&at(1112, 2)), "a tick moves it");
        let trochoids = Trochoids::new(&sea.cascades[0], &sea);
        assert_eq!(trochoids.at(5, 3.0, 4.0, 0.0), trochoids.at(5 + sea.repeat as i64, 3.0, 4.0, 0.0));
    }
}

#[test]
fn the_end_of_the_repeat_is_a_frame_like_any_other() {
    for ticks in [60 * 7200, 1 << 32] {
        let mut scene = preset_with(16, true);
        scene.repeat.ticks = ticks;
        let sea = Timeline::new(&scene).at(0);
        let heights = |tick: i64| filled(&sea, tick, 128, &[Field::Height]).remove(0);
        let step = |tick: i64| {
            let (before, after) = (heights(tick - 24), heights(tick));
            before.iter().zip(after).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        let steady = (1..10).map(|i| step(i * 100_003)).fold(0.0, f32::max);
        let across = step(ticks as i64).max(step(ticks as i64 + 12));
        assert!(across < 1.3 * steady, "{across} m across the end, {steady} m in a steady frame");
    }
}

#[test]
fn a_patch_has_no_seam() {
    let sea = Timeline::new(&preset_with(64, true)).at(0);
    let trochoids = Trochoids::new(&sea.cascades[0], &sea);
    let patch = sea.cascades[0].cascade.patch_m;
    for i in 0..100 {
        let along = f64::from(i) * 0.0137 * patch;
        for (inside, outside) in [((1e-4, along), (patch - 1e-4, along)), ((along, 1e-4), (along, -1e-4))] {
            let (a, b) = (trochoids.at(99, inside.0, inside.1, 0.0), trochoids.at(99, outside.0, outside.1, 0.0));
            for field in 0..15 {
                assert!((a[field] - b[field]).abs() < 1e-3, "field {field} at {along}: {} {}", a[field], b[field]);
            }
        }
    }
}

#[test]
fn a_change_of_wind_after_a_week_pops_nowhere() {
    let at = 7 * DAY;
    let kind = ChangeKind::Wind { speed_mps: 11.0, direction_from_deg: 300.0 };
    let change = Change { sequence: 1, effective_tick: at, transition_ticks: 5 * 7200, kind };
    let timeline = Timeline::new(&preset_with(64, true)).with(change, at);
    let trochoids = |tick| filled(&timeline.at(tick), tick, 128, &[Field::Height]).remove(0);
    let full = |tick| full(&timeline, tick);
    let largest = |heights: &dyn Fn(i64) -> Vec<f32>, frames: std::ops::Range<i64>| {
        let mut last = heights(at + (frames.start - 1) * 240);
        let step = |frame: i64| {
            let now = heights(at + frame * 240);
            let step = now.iter().zip(&last).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            last = now;
            step
        };
        frames.map(step).fold(0.0, f32::max)
    };
    let steady = largest(&trochoids, -20..0).max(largest(&trochoids, 160..180));
    let (across, full) = (largest(&trochoids, 0..150), largest(&full, 0..150));
    let kept = kept_waves(&timeline.at(at).cascades[0], &timeline.at(at)).len();
    println!(
        "{across:.4} m across, {steady:.4} m in steady frames; the sum of all modes {full:.4} m across; {kept} kept"
    );
    // Most of the waves change places in five seconds. Without the fade, it is 3.5 times a steady frame.
    assert!(across <= 2.0 * steady && across <= 1.6 * full);
    assert_eq!(timeline.at(at).drift, timeline.at(at + DAY).drift);
}

#[test]
fn everything_is_finite_whatever_the_sea() {
    for text in [
        "[wind]\nspeed_mps = 0.0\nrange_mps = [0.0, 20.0]",
        "[wind]\nspeed_mps = 0.001\nrange_mps = [0.0, 20.0]",
        "[wind]\nspeed_mps = 80\nrange_mps = [10.0, 100.0]",
        "[wind]\nspeed_mps = 80\nrange_mps = [10.0, 100.0]\n[effects]\nchoppiness = 5.0\nfoam = false",
        "[wind]\nspeed_mps = 80\nrange_mps = [10.0, 100.0]\n[effects]\nchoppiness = 0.0\nfoam = false",
        "[wind]\n[water]\ndepth_m = 0.1\n[effects]\nchoppiness = 5.0\nfoam = false",
        "[[swell]]\nhs_m = 30\ntp_s = 3\nspreading = { form = \"cos2s\", s = 1000.0 }\n[effects]\nchoppiness = 5\nfoam = false",
        "loop_s = 1\n[wind]",
    ] {
        let scene = scene(&format!("model = \"trochoid\"\n{text}"));
        let timeline = Timeline::new(&scene);
        let hs = timeline.hs_at(0) as f32;
        for tick in [0, TEN_YEARS, i64::MAX] {
            let sea = timeline.at(tick);
            assert_eq!(sea.cascades.len(), 1, "one patch is enough");
            let planes = filled(&sea, tick, 64, &Field::ALL[..15]);
            for (field, plane) in planes.iter().enumerate() {
                assert!(plane.iter().all(|v| v.is_finite()), "{field} of {text} at {tick}");
            }
            assert!(planes[0].iter().all(|h| h.abs() <= 2.0 * hs + 1e-6), "{text}: higher than two Hs");
            let point = Trochoids::new(&sea.cascades[0], &sea).at(tick, 1e9, -1e9, 0.3);
            assert!(point.iter().all(|v| v.is_finite()), "{text}: {point:?}");
        }
    }
}

#[test]
fn waves_drift_where_the_first_wind_blows() {
    for (text, toward) in [
        ("[wind]\ndirection_from_deg = 0", [0.0, 1.0]),
        ("[[swell]]\ndirection_from_deg = 270", [1.0, 0.0]),
        ("", [1.0, 0.0]),
    ] {
        let drift = Timeline::new(&scene(text)).at(0).drift;
        assert!((drift.toward[0] - toward[0]).abs() + (drift.toward[1] - toward[1]).abs() < 1e-12, "{text}: {drift:?}");
    }
    let sea = Timeline::new(&preset_with(64, true)).at(0);
    let octaves = turbulence(&sea.cascades[0], &sea, &[]);
    for octave in octaves {
        let seconds = sea.repeat as f64 / 7200.0;
        let speed =
            f64::from(octave.drift[0]).hypot(f64::from(octave.drift[1])) * sea.cascades[0].cascade.patch_m / seconds;
        close(speed, octave.omega / octave.k, 0.01);
    }
}
