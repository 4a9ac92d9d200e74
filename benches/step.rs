//! Cost of a frame by stage: spectra, blend, step, encode. `benches/peers` holds the step to bare transforms.
//!
//! `cargo bench --bench step`. Rounds of all stages are interleaved, so that a noisy machine troubles all alike;
//! what is printed is the median and the quartiles.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::sync::Arc;
use std::time::Instant;

use swellcast::backend::{Backend, Cpu};
use swellcast::engine::Stepper;
use swellcast::plan::Demand;
use swellcast::plan::{CascadePlan, Field, FieldSet, Plan};
use swellcast::scene::preset;
use swellcast::sea::{EnergyTable, FoamThresholds, Timeline};
use swellcast::tile::{Plane, Stamp, UnitEncoder};
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

const ROUNDS: usize = 40;
const STAMP: Stamp = Stamp { tick: 0, epoch: 0, sequence: 0, layout: 0 };

fn main() {
    let scene = preset("beaufort-5").expect("a preset");
    let timeline = Arc::new(Timeline::new(&scene));
    let sea = timeline.at(0);
    let table = EnergyTable::build(&scene.sea, timeline.layout());
    let cascades = sea.cascades.len();
    let unit = |cascade: usize, group| UnitName {
        cascade: cascade as u8,
        level: 0,
        class: ErrorClass::Millimetre,
        group,
        codec: Codec::I16,
    };
    let waves = [Group::Displacement, Group::Slopes, Group::Derivatives];
    let demand: Demand = (0..cascades).flat_map(|c| waves.map(|group| (unit(c, group), 240))).collect();
    let plan = |fields: &[Field]| Plan {
        cascades: vec![CascadePlan::new([(0, FieldSet::of(fields))], None, &scene.effects); cascades],
    };
    let all = plan(&Field::SPECTRAL);

    let mut cpu = Cpu::new(None);
    cpu.load(&sea).expect("the CPU loads");
    let mut one = Cpu::new(Some(1));
    one.load(&sea).expect("the CPU loads");
    let mut stepper = Stepper::new(Box::new(Cpu::new(None)), Arc::clone(&timeline), 1);
    let mut tick = 0;

    let wave: Vec<f32> = (0..65_536).map(|i| (i as f32 * 0.01).sin()).collect();
    let planes = [Plane::Samples(&wave); 3];

    type Stage<'a> = (&'static str, Box<dyn FnMut() + 'a>);
    let mut stages: Vec<Stage> = vec![
        ("energy of all modes (once a change)", Box::new(|| drop(EnergyTable::build(&scene.sea, timeline.layout())))),
        (
            "foam's thresholds (once a change)",
            Box::new(|| {
                let foam = scene.effects.foam.expect("the preset foams");
                drop(FoamThresholds::new(&scene.sea, timeline.layout(), &table, scene.effects.choppiness, &foam));
            }),
        ),
        ("blend (a frame of a transition)", Box::new(|| drop(timeline.at(0)))),
        (
            "step, all 8 fields of all cascades",
            Box::new(move || drop(cpu.step(tick_of(&mut tick), &all).map(|s| s.tick))),
        ),
        ("  the same on one thread", Box::new(move || drop(one.step(7200, &plan(&Field::SPECTRAL)).map(|s| s.tick)))),
        ("step and encode, 8 channels", Box::new(move || drop(stepper.frames(tick_of(&mut tick), &demand)))),
        (
            "encode one unit of 3 channels",
            Box::new(|| drop(UnitEncoder::new(unit(0, Group::Displacement)).take(256, &planes, STAMP))),
        ),
    ];
    let mut times = vec![Vec::with_capacity(ROUNDS); stages.len()];
    for round in 0..ROUNDS + 3 {
        for ((_, stage), times) in stages.iter_mut().zip(&mut times) {
            let start = Instant::now();
            stage();
            if round >= 3 {
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    println!("{cascades} cascades of 256 x 256, {} threads, {ROUNDS} rounds", rayon::current_num_threads());
    println!("{:<42}{:>10}{:>18}", "stage", "median ms", "quartiles");
    for ((name, _), mut times) in stages.into_iter().zip(times) {
        times.sort_by(f64::total_cmp);
        let at = |share: usize| times[times.len() * share / 4];
        println!("{name:<42}{:>10.3}{:>9.3}{:>9.3}", at(2), at(1), at(3));
    }
}

fn tick_of(tick: &mut i64) -> i64 {
    *tick += 240;
    *tick
}
