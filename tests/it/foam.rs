//! Laws of foam: it covers what the wind calls for, closes with its loop, and knows nothing of frame rates.

use swellcast::backend::{Backend, Cpu};
use swellcast::plan::{CascadePlan, Field, FieldSet, FoamWork, Plan};
use swellcast::scene::{Foam, Scene, preset};
use swellcast::sea::Timeline;

use crate::random::Random;

/// Mean share of the area that combined foam above .1 covers, over `seconds` after its memory is full.
fn coverage(scene: &Scene, seconds: i64) -> f64 {
    let timeline = Timeline::new(scene);
    let (sea, foam) = (timeline.at(0), scene.effects.foam.unwrap());
    let mut cpu = Cpu::new(Some(2));
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
        };
        // Cascades that never foam need not be asked.
        let plan = |threshold: f64| {
            let work = (threshold > 0.0).then_some(work);
            CascadePlan::new(FieldSet::NONE, work, sea.choppiness)
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
    let (seeds, seconds, within) = if full { (20, 60, 0.2) } else { (3, 10, 0.5) };
    for speed in [8.0, 12.0, 16.0, 20.0_f64] {
        let mut scene = preset("beaufort-5").unwrap();
        scene.sea.wind.as_mut().unwrap().speed_mps = speed;
        let each: Vec<f64> = (0..seeds).map(|seed| coverage(&Scene { seed, ..scene.clone() }, seconds)).collect();
        let mean = each.iter().sum::<f64>() / each.len() as f64;
        let deviation = each.iter().map(|c| (c - mean) * (c - mean)).sum::<f64>() / (each.len() - 1) as f64;
        let wanted = 3.84e-6 * speed.powf(3.41);
        println!(
            "{speed} m/s: {:.3} % covered, standard error {:.3}, wanted {:.3}, told {:.3}",
            100.0 * mean,
            100.0 * (deviation / each.len() as f64).sqrt(),
            100.0 * wanted,
            100.0 * Timeline::new(&scene).statistics_at(0).foam_coverage,
        );
        assert!((mean / wanted - 1.0).abs() < within, "{speed} m/s: {mean} of {wanted}");
    }
}
