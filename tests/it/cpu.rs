//! The CPU backend against the f64 reference, and the laws of a moving surface.

use swellcast::backend::{Backend, Cpu, Tap};
use swellcast::plan::{Field, FieldSet, FoamWork, Plan};
use swellcast::reference;
use swellcast::scene::{Change, ChangeKind};
use swellcast::sea::{Sea, Timeline};

use crate::support::{DAY, TEN_YEARS, cpu_fields, full, max_error, plan, scene, wind_sea};

const MOVING: [Field; 3] = [Field::Height, Field::Dx, Field::Dz];
const SLOPING: [Field; 5] = [Field::SlopeX, Field::SlopeZ, Field::Dxx, Field::Dzz, Field::Dxz];
const VELOCITY: [Field; 3] = [Field::VelocityX, Field::VelocityY, Field::VelocityZ];

fn hold_against_reference(timeline: &Timeline, tick: i64) {
    let sea = timeline.at(tick);
    let hs = timeline.hs_at(tick);
    for cascade in 0..sea.cascades.len() {
        for (fields, bound) in [(&MOVING[..], 1e-5 * hs), (&SLOPING[..], 1e-5), (&VELOCITY, 1e-5 * hs)] {
            let fast = cpu_fields(timeline, tick, cascade, fields);
            let slow = reference::fields(&sea, cascade, tick, fields);
            for ((fast, slow), field) in fast.iter().zip(&slow).zip(fields) {
                let error = max_error(fast, slow);
                assert!(
                    error <= bound,
                    "{field:?} of cascade {cascade} at tick {tick} errs {error:e}, bound {bound:e}"
                );
            }
        }
    }
}

#[test]
fn cpu_agrees_with_the_reference_at_once_after_a_day_and_after_ten_years() {
    let timeline = Timeline::new(&wind_sea(12.0, 128, &[900.0, 130.0, 20.0]));
    for tick in [0, 1, DAY + 17, TEN_YEARS + 4711] {
        hold_against_reference(&timeline, tick);
    }
}

#[test]
fn cpu_agrees_with_the_reference_across_a_change_of_depth() {
    let at = DAY + 333;
    let deepen = Change {
        sequence: 1,
        effective_tick: at,
        transition_ticks: 7200,
        kind: ChangeKind::Water { depth_m: Some(19.9), gravity: None },
    };
    let mut shallow = wind_sea(12.0, 128, &[900.0, 130.0]);
    shallow.sea.water.depth_m = 20.0;
    let timeline = Timeline::new(&shallow).with(deepen, at);
    for tick in [at - 1, at, at + 1, at + 3600, at + 7200, at + DAY] {
        hold_against_reference(&timeline, tick);
    }
}

#[test]
fn a_change_of_depth_or_gravity_moves_no_point_more_than_a_frame_does() {
    let at = DAY;
    let mut shallow = wind_sea(12.0, 128, &[900.0, 130.0]);
    shallow.sea.water.depth_m = 20.0;
    // At once, the height of the whole sea changes by a few millimetres, too; with the usual transition it does not.
    for (transition_ticks, within) in [(0, 1.05), (5 * 7200, 1.0)] {
        for (depth_m, gravity) in [(Some(19.9), None), (None, Some(9.75)), (Some(20.1), Some(9.85))] {
            let kind = ChangeKind::Water { depth_m, gravity };
            let change = Change { sequence: 1, effective_tick: at, transition_ticks, kind };
            let timeline = Timeline::new(&shallow).with(change, at);
            let heights = |tick| cpu_fields(&timeline, tick, 0, &[Field::Height]).remove(0);
            let step =
                |a: i64, b: i64| heights(a).iter().zip(heights(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // The largest of a second: one frame's largest scatters by a few per cent.
            let steady = (2..32).map(|frame| step(at - frame * 240, at - (frame - 1) * 240)).fold(0.0, f32::max);
            let across = step(at - 240, at);
            let told = format!("{across:.4} m across {depth_m:?}, {gravity:?} in {transition_ticks} ticks");
            println!("{told}; {steady:.4} m in a steady frame");
            assert!(across <= within * steady, "{told}; {steady} m in a steady frame");
        }
    }
}

#[test]
fn the_separable_reference_is_the_direct_sum() {
    let timeline = Timeline::new(&wind_sea(8.0, 32, &[120.0]));
    let (tick, sea) = (TEN_YEARS, timeline.at(TEN_YEARS));
    let fields: Vec<Field> = MOVING.into_iter().chain(SLOPING).collect();
    let grids = reference::fields(&sea, 0, tick, &fields);
    for (x, z) in [(0, 0), (1, 0), (0, 1), (5, 29), (31, 16), (17, 3)] {
        let metres = |i: usize| i as f64 * 120.0 / 32.0;
        let point = reference::at(&sea, &sea.cascades, tick, metres(x), metres(z));
        for (grid, field) in grids.iter().zip(&fields) {
            let (a, b) = (grid[z * 32 + x], point.fields[*field as usize]);
            assert!((a - b).abs() < 1e-11, "{field:?} at {x},{z}: {a} and {b}");
        }
    }
}

#[test]
fn derivatives_are_those_of_the_displacement_and_velocity_is_its_rate() {
    let timeline = Timeline::new(&wind_sea(8.0, 32, &[120.0]));
    let (tick, sea) = (DAY, timeline.at(DAY));
    let at = |x: f64, z: f64, tick: i64| reference::at(&sea, &sea.cascades, tick, x, z);
    let (x, z, h) = (13.7, 88.1, 1e-3);
    let along_x = |field: Field| {
        (at(x + h, z, tick).fields[field as usize] - at(x - h, z, tick).fields[field as usize]) / (2.0 * h)
    };
    let along_z = |field: Field| {
        (at(x, z + h, tick).fields[field as usize] - at(x, z - h, tick).fields[field as usize]) / (2.0 * h)
    };
    let here = at(x, z, tick);
    for (field, difference) in [
        (Field::SlopeX, along_x(Field::Height)),
        (Field::SlopeZ, along_z(Field::Height)),
        (Field::Dxx, along_x(Field::Dx)),
        (Field::Dzz, along_z(Field::Dz)),
        (Field::Dxz, along_z(Field::Dx)),
        (Field::Dxz, along_x(Field::Dz)),
    ] {
        let exact = here.fields[field as usize];
        assert!((exact - difference).abs() < 1e-6, "{field:?}: {exact} and {difference}");
    }
    for (axis, field) in [(0, Field::Dx), (1, Field::Height), (2, Field::Dz)] {
        let (before, after) = (at(x, z, tick - 1).fields[field as usize], at(x, z, tick + 1).fields[field as usize]);
        let rate = (after - before) * 3600.0;
        assert!((here.fields[8 + axis] - rate).abs() < 1e-5, "{field:?}: {} and {rate}", here.fields[8 + axis]);
    }
}

/// One wave (n, m) of amplitude `a` travelling along +k on a patch of 64 m.
fn single_mode(n: usize, m: i64, a: f64) -> Sea {
    let mut sea = Timeline::new(&wind_sea(8.0, 64, &[64.0])).at(0);
    let cascade = &mut sea.cascades[0];
    let rows = cascade.rows();
    let chosen = n * rows + (cascade.cascade.half as i64 + m) as usize;
    for (i, mode) in cascade.modes.iter_mut().enumerate() {
        mode.forward.re = if i == chosen { a / 2.0 } else { 0.0 };
        (mode.forward.im, mode.backward.re, mode.backward.im) = (0.0, 0.0, 0.0);
    }
    sea
}

#[test]
fn a_wave_travels_along_its_wave_vector_at_omega_over_k() {
    let (n, m) = (3, 4);
    let sea = single_mode(n, m, 0.1);
    let k = 5.0 * 2.0 * std::f64::consts::PI / 64.0;
    let speed = (9.81_f64 / k).sqrt();
    let mut cpu = Cpu::new(Some(1));
    cpu.load(&sea).unwrap();
    let mut crest_phase = |tick: i64| {
        let surface = cpu.step(tick, &plan(&sea, &[Field::Height])).unwrap();
        let height = surface.cascades[0].plane(Field::Height).unwrap();
        // Phase of the wave's own Fourier component: cos(k.x - p) has its crest where k.x = p.
        let (mut re, mut im) = (0.0, 0.0);
        for (i, h) in height.iter().enumerate() {
            let (x, z) = ((i % 64) as f64, (i / 64) as f64);
            let angle = 2.0 * std::f64::consts::PI * (3.0 * x + 4.0 * z) / 64.0;
            re += f64::from(*h) * angle.cos();
            im += f64::from(*h) * angle.sin();
        }
        im.atan2(re)
    };
    let tick = 1440;
    let advance = (crest_phase(tick) - crest_phase(0)).rem_euclid(2.0 * std::f64::consts::PI);
    let metres = advance / k;
    let want = speed * tick as f64 / 7200.0;
    assert!((metres - want).abs() < 2e-3 * want, "crest went {metres} m along +k, w/k says {want} m");
}

#[test]
fn crests_sharpen_and_troughs_flatten() {
    let sea = single_mode(4, 0, 0.8);
    let mut cpu = Cpu::new(Some(1));
    cpu.load(&sea).unwrap();
    let surface = cpu.step(0, &plan(&sea, &[Field::Height, Field::Dx])).unwrap();
    let row = |field| &surface.cascades[0].plane(field).unwrap()[..64];
    let (height, dx) = (row(Field::Height), row(Field::Dx));
    // Width in the world of the water above the rest level, between neighbouring particles.
    let width = |above: bool| -> f32 {
        (0..63).filter(|i| (height[*i] + height[i + 1] > 0.0) == above).map(|i| 1.0 + dx[i + 1] - dx[i]).sum()
    };
    assert!(width(true) < 0.9 * width(false), "crests are {} m wide, troughs {} m", width(true), width(false));
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let timeline = Timeline::new(&scene("name = \"t\"\n[wind]\nspeed_mps = 14"));
    let sea = timeline.at(0);
    let fields = FieldSet::of(&Field::ALL);
    let steps = |threads: usize| {
        let mut cpu = Cpu::new(Some(threads));
        cpu.load(&sea).unwrap();
        let mut bits = Vec::new();
        for step in 0..3 {
            let foam = FoamWork { restart: step == 0, decay: 0.9, growth: 0.5, advance: true, breaks: true };
            let cascade = full(fields, Some(foam), sea.choppiness);
            let surface = cpu.step(step * 720, &Plan { cascades: vec![cascade; sea.cascades.len()] }).unwrap();
            for cascade in &surface.cascades {
                for field in Field::ALL {
                    bits.extend(cascade.plane(field).unwrap().iter().map(|v| v.to_bits()));
                }
            }
        }
        bits
    };
    let one = steps(1);
    assert!(one == steps(2) && one == steps(8));
}

#[test]
fn evolve_alone_turns_every_mode_by_its_exact_phase() {
    let timeline = Timeline::new(&wind_sea(10.0, 64, &[300.0, 40.0]));
    let (tick, sea) = (TEN_YEARS + 99, timeline.at(TEN_YEARS + 99));
    let mut cpu = Cpu::new(Some(1));
    cpu.load(&sea).unwrap();
    cpu.step(tick, &plan(&sea, &[Field::Height])).unwrap();
    for (index, cascade) in sea.cascades.iter().enumerate() {
        let heights = cpu.tap(index, Tap::Heights).unwrap();
        let largest = cascade.modes.iter().map(|mode| mode.forward.norm() + mode.backward.norm()).fold(0.0, f64::max);
        for (mode, h) in cascade.modes.iter().zip(heights.as_chunks::<2>().0) {
            let cycles = i128::from(mode.cycles) * i128::from(tick) % i128::from(sea.repeat);
            let turns = cycles as f64 / sea.repeat as f64 + f64::from(mode.offset) / 4_294_967_296.0;
            let (sin, cos) = (2.0 * std::f64::consts::PI * turns).sin_cos();
            let (a, b) = (mode.forward, mode.backward);
            let want =
                [a.re * cos + a.im * sin + b.re * cos - b.im * sin, a.im * cos - a.re * sin + b.im * cos + b.re * sin];
            for (got, want) in h.iter().zip(want) {
                assert!((f64::from(*got) - want).abs() < 3e-7 * largest, "{got} for {want}");
            }
        }
    }
}
