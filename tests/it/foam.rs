//! Laws of foam: it covers what the wind calls for, closes with its loop, and knows nothing of frame rates.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;
use swellcast::backend::{Backend, Cpu};
use swellcast::engine::Stepper;
use swellcast::plan::Demand;
use swellcast::plan::{Field, FieldSet, FoamWork, Plan};
use swellcast::scene::{Foam, Scene, preset};
use swellcast::sea::Timeline;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

use crate::random::Random;
use crate::support::full;

/// Mean share of the area that combined foam above .1 covers, over `seconds` after its memory is full.
fn coverage(scene: &Scene, seconds: i64) -> f64 {
    let timeline = Timeline::new(scene);
    let (sea, foam) = (timeline.at(0), scene.effects.foam.unwrap());
    let mut cpu = Cpu::new(Some(1));
    cpu.load(&sea).unwrap();
    let (memory, end) = (foam.memory_ticks(), foam.memory_ticks() + seconds * 7200);
    let mut random = Random(scene.seed);
    let (mut covered, mut points) = (0, 0);
    for step in 0..=end / Foam::STEP_TICKS {
        let tick = step * Foam::STEP_TICKS;
        let work = FoamWork {
            restart: step == 0,
            decay: foam.decay_over(Foam::STEP_TICKS) as f32,
            growth: foam.growth_over(Foam::STEP_TICKS) as f32,
            advance: true,
            breaks: true,
        };
        // Cascades that never foam need not be asked.
        let plan = |threshold: f64| {
            let work = (threshold > 0.0).then_some(work);
            full(FieldSet::NONE, work, sea.choppiness)
        };
        let plan = Plan { cascades: sea.cascades.iter().map(|c| plan(c.foam_threshold)).collect() };
        let surface = cpu.step(tick, &plan).unwrap();
        // Foam changes little within a second.
        if tick < memory || step % 10 != 0 {
            continue;
        }
        for _ in 0..20_000 {
            let (x, z) = (random.unit() * 1e6, random.unit() * 1e6);
            let mut clear = 1.0;
            for (surface, modes) in surface.cascades.iter().zip(&sea.cascades) {
                let Some(plane) = surface.plane(Field::Foam) else { continue };
                let (n, patch) = (modes.cascade.n, modes.cascade.patch_m);
                let at = |metres: f64| (metres / patch * n as f64) as usize % n;
                clear *= 1.0 - plane[at(z) * n + at(x)];
            }
            covered += u32::from(f64::from(1.0 - clear) > Foam::COVERS);
            points += 1;
        }
    }
    f64::from(covered) / f64::from(points)
}

/// All 20 seeds and 60 s of the promise with `SWELLCAST_FULL=1`, else a few.
#[test]
fn whitecaps_cover_what_the_wind_calls_for() {
    let full = std::env::var("SWELLCAST_FULL").is_ok();
    let (seeds, seconds, within) = if full { (20, 60, 0.2) } else { (3, 10, 0.3) };
    for speed in [8.0, 12.0, 16.0, 20.0_f64] {
        let mut scene = preset("beaufort-5").unwrap();
        scene.sea.wind.as_mut().unwrap().speed_mps = speed;
        let each: Vec<f64> =
            (0..seeds).into_par_iter().map(|seed| coverage(&Scene { seed, ..scene.clone() }, seconds)).collect();
        let mean = each.iter().sum::<f64>() / each.len() as f64;
        let deviation = each.iter().map(|c| (c - mean) * (c - mean)).sum::<f64>() / (each.len() - 1) as f64;
        let wanted = 3.84e-6 * speed.powf(3.41);
        let told = Timeline::new(&scene).statistics_at(0).foam_coverage;
        assert!((told / wanted - 1.0).abs() < 0.01, "{speed} m/s: {told} is told of {wanted}");
        println!(
            "{speed} m/s: {:.3} % covered, standard error {:.3}, wanted {:.3}, told {:.3}",
            100.0 * mean,
            100.0 * (deviation / each.len() as f64).sqrt(),
            100.0 * wanted,
            100.0 * told,
        );
        assert!((mean / wanted - 1.0).abs() < within, "{speed} m/s: {mean} of {wanted}");
    }
}

#[test]
fn a_loop_closes_to_the_last_bit_foam_included() {
    // A second, a prime number of ticks, a length that is no multiple of the foam step, six hours.
    for ticks in [7200, 7207, 100_000, 21_600 * 7200_i64] {
        let mut scene = crate::support::wind_sea(16.0, 32, &[120.0, 25.0]);
        scene.repeat.ticks = ticks as u64;
        let timeline = Timeline::new(&scene);
        let planes = |tick: i64| {
            let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), Arc::new(timeline.clone()), 1);
            let fields = FieldSet::of(&Field::ALL);
            let surface = stepper.surface(tick, fields).unwrap();
            let plane = |c: &swellcast::backend::CascadeSurface, field| -> Vec<u32> {
                c.plane(field).unwrap().iter().map(|v| v.to_bits()).collect()
            };
            surface.cascades.iter().flat_map(|c| Field::ALL.map(|field| plane(c, field))).collect::<Vec<_>>()
        };
        for tick in [0, 240, 6960, 7199] {
            let once = planes(tick);
            assert!(once.iter().any(|plane| plane.iter().any(|bits| *bits != 0)));
            for turns in [1, 3, 1000] {
                assert!(once == planes(tick + turns * ticks), "a loop of {ticks} ticks at {tick}, {turns} turns on");
            }
        }
        assert!(ticks < 8000 || planes(240) != planes(480), "a loop moves");
    }
}

#[test]
fn foam_is_the_same_bytes_at_any_frame_rate() {
    let timeline = Arc::new(Timeline::new(&crate::support::wind_sea(16.0, 64, &[300.0, 40.0])));
    let unit = |cascade| UnitName {
        cascade,
        level: 0,
        class: ErrorClass::HalfMillimetre,
        group: Group::Foam,
        codec: Codec::I16,
    };
    let begin = 50 * 7200;
    let frames = |rate: i64| {
        let interval = 7200 / rate;
        let demand = Demand::from([(unit(0), interval), (unit(1), interval)]);
        let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), Arc::clone(&timeline), 1);
        stepper.set_demand(&demand);
        let mut frames = BTreeMap::new();
        for tick in (begin..begin + 2 * 7200).step_by(interval as usize) {
            while stepper.warm_foam(tick).unwrap() {}
            for frame in stepper.frames(tick, &demand).unwrap().frames {
                frames.insert((tick, frame.unit), frame.bytes);
            }
        }
        assert_eq!(frames.len() as i64, 2 * 2 * rate);
        frames
    };
    let rates = [15, 30, 60, 90].map(frames);
    for (name, frame) in &rates[0] {
        assert!(rates[1][name] == *frame && rates[2][name] == *frame, "{name:?}");
        // 90 and 15 Hz meet at every frame of 15, too.
        assert!(rates[3][name] == *frame, "{name:?} at 90 Hz");
    }
    let distinct: std::collections::BTreeSet<_> = rates[0].values().map(|frame| frame[88..].to_vec()).collect();
    assert!(distinct.len() > 20, "foam stands still");
}

#[test]
fn foam_that_lives_through_the_end_of_a_loop_is_that_of_a_server_begun_after_it() {
    for (ticks, rate) in [(7207, 60), (100_000, 15)] {
        let mut scene = crate::support::wind_sea(18.0, 32, &[60.0]);
        scene.repeat.ticks = ticks;
        let timeline = Arc::new(Timeline::new(&scene));
        let unit =
            UnitName { cascade: 0, level: 0, class: ErrorClass::HalfMillimetre, group: Group::Foam, codec: Codec::I16 };
        let interval = 7200 / rate;
        let demand = Demand::from([(unit, interval)]);
        let begin = |tick: i64| {
            let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), Arc::clone(&timeline), 1);
            stepper.set_demand(&demand);
            while stepper.warm_foam(tick).unwrap() {}
            stepper
        };
        let first = ticks as i64 / interval * interval - 10 * interval;
        let mut living = begin(first);
        for tick in (first..first + 30 * interval).step_by(interval as usize) {
            // Between frames a server runs the foam ticks that are missing, and only those.
            let mut steps = 0;
            while living.warm_foam(tick).unwrap() {
                steps += 1;
            }
            assert!(steps <= 2, "{steps} foam steps before a frame: its memory was lost");
            let frames = living.frames(tick, &demand).unwrap().frames;
            assert!(frames == begin(tick).frames(tick, &demand).unwrap().frames, "a loop of {ticks} at {tick}");
            assert_eq!(frames.len(), 1);
        }
    }
}
