//! Cost of a frame by stage: spectra, blend, step, encode; and of the bare transforms in the same run.
//!
//! `cargo bench --bench step`. Rounds of all stages are interleaved, so that a noisy machine troubles all alike;
//! what is printed is the median and the quartiles.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::sync::Arc;
use std::time::Instant;

use swellcast::backend::{Backend, Cpu};
use swellcast::engine::{Demand, Stepper};
use swellcast::pass::transform::Transform;
use swellcast::plan::{CascadePlan, Field, FieldSet, Plan};
use swellcast::scene::preset;
use swellcast::sea::{EnergyTable, FoamThresholds, Timeline};
use swellcast::tile::{Stamp, encode};
use swellcast::wire::{ErrorClass, Group, UnitName};

const ROUNDS: usize = 40;
const STAMP: Stamp = Stamp { tick: 0, epoch: 0, sequence: 0, layout: 0 };

fn main() {
    let scene = preset("beaufort-5").expect("a preset");
    let timeline = Arc::new(Timeline::new(&scene));
    let sea = timeline.at(0);
    let table = EnergyTable::build(&scene.sea, timeline.layout());
    let cascades = sea.cascades.len();
    let unit =
        |cascade: usize, group| UnitName { cascade: cascade as u8, level: 0, class: ErrorClass::Millimetre, group };
    let waves = [Group::Displacement, Group::Slopes, Group::Derivatives];
    let demand: Demand = (0..cascades).flat_map(|c| waves.map(|group| (unit(c, group), 240))).collect();
    let plan = |fields: &[Field]| Plan {
        cascades: vec![CascadePlan::new(FieldSet::of(fields), None, sea.choppiness); cascades],
    };
    let all = plan(&Field::SPECTRAL);

    let mut cpu = Cpu::new(None);
    cpu.load(&sea).expect("the CPU loads");
    let mut one = Cpu::new(Some(1));
    one.load(&sea).expect("the CPU loads");
    let mut stepper = Stepper::new(Box::new(Cpu::new(None)), Arc::clone(&timeline), 1);
    let mut bare = Bare::new(256);
    let transform = Transform::new(256, sea.cascades[0].cascade.half);
    let mut workspace = transform.workspace();
    let heights = vec![rustfft::num_complex::Complex32::ONE; sea.cascades[0].modes.len()];
    let factors = vec![1.0; heights.len()];
    let mut field = vec![0.0; 65_536];
    let mut tick = 0;

    let wave: Vec<f32> = (0..65_536).map(|i| (i as f32 * 0.01).sin()).collect();
    let planes = [wave.as_slice(); 3];

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
        ("encode one unit of 3 channels", Box::new(|| drop(encode(unit(0, Group::Displacement), 256, &planes, STAMP)))),
        (
            "one transform, pruned to its band",
            Box::new(move || transform.run(&heights, &factors, false, &mut workspace, &mut field)),
        ),
        ("one transform, bare and full (realfft)", Box::new(move || bare.run())),
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

/// The two passes of a full half-complex inverse transform, with nothing between them.
struct Bare {
    n: usize,
    columns: Arc<dyn rustfft::Fft<f32>>,
    rows: Arc<dyn realfft::ComplexToReal<f32>>,
    spectrum: Vec<rustfft::num_complex::Complex32>,
    scratch: Vec<rustfft::num_complex::Complex32>,
    field: Vec<f32>,
}

impl Bare {
    fn new(n: usize) -> Self {
        let columns = rustfft::FftPlanner::new().plan_fft_inverse(n);
        let rows = realfft::RealFftPlanner::new().plan_fft_inverse(n);
        let zero = rustfft::num_complex::Complex32::ZERO;
        let scratch = vec![zero; columns.get_inplace_scratch_len().max(rows.get_scratch_len())];
        Self { n, spectrum: vec![zero; n * (n / 2 + 1)], field: vec![0.0; n * n], columns, rows, scratch }
    }

    fn run(&mut self) {
        self.spectrum.fill(rustfft::num_complex::Complex32::ZERO);
        for column in self.spectrum.chunks_exact_mut(self.n) {
            self.columns.process_with_scratch(column, &mut self.scratch);
        }
        for (spectrum, row) in self.spectrum.chunks_exact_mut(self.n / 2 + 1).zip(self.field.chunks_exact_mut(self.n)) {
            // The error says only that an imaginary part was not zero.
            let _ = self.rows.process_with_scratch(spectrum, row, &mut self.scratch);
        }
    }
}
