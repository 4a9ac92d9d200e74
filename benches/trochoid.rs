//! The trochoid model beside the sum of all modes: what is kept, how far it is off, what it costs.
//!
//! `cargo bench --bench trochoid -- --write` puts the table into `docs/trochoid.md`.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::fmt::Write;
use std::time::Instant;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use swellcast::backend::{Backend, Cpu};
use swellcast::pass::trochoid::Trochoids;
use swellcast::plan::{CascadePlan, Field, FieldSet, Plan};
use swellcast::scene::{Effects, Model, Scene, Trochoid, preset};
use swellcast::sea::{Sea, Timeline, kept_waves};

const N: usize = 256;
const COMPONENTS: [usize; 4] = [16, 64, 256, 1024];
const TICK: i64 = 7200 * 3600;
const ROUNDS: usize = 20;
const STRAINED: FieldSet = FieldSet::of(&[Field::Height, Field::SlopeX, Field::SlopeZ, Field::Jacobian]);
const BEGIN: &str = "<!-- table -->";
const END: &str = "<!-- end of table -->";

fn main() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let table = one.install(table);
    print!("{table}");
    if std::env::args().any(|argument| argument == "--write") {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/trochoid.md");
        let page = std::fs::read_to_string(path).expect("the page is there");
        let (before, rest) = page.split_once(BEGIN).expect("the page has a table");
        let (_, after) = rest.split_once(END).expect("the table has an end");
        std::fs::write(path, format!("{before}{BEGIN}\n{table}{END}{after}")).expect("the page can be written");
    }
}

fn table() -> String {
    let mut table = String::from(
        "| K | energy kept | error without noise | spectrum, worst | below the peak | m0 | choice and fit, ms | \
         256 x 256 heights, ms | and slopes, Jacobian, ms | all fields, ms | 10,000 points, ms |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let seas = COMPONENTS.map(|components| sea(components, true));
    let trochoids: Vec<Trochoids> = seas.iter().map(|sea| Trochoids::new(&sea.cascades[0], sea)).collect();
    let patch = seas[0].cascades[0].cascade.patch_m;
    let points: Vec<(f64, f64)> =
        (0..10_000).map(|i| (f64::from(i) * 0.618 % 1.0 * patch, f64::from(i) * 0.7549 % 1.0 * patch)).collect();
    let mut times = vec![[(); 5].map(|()| Vec::new()); COMPONENTS.len()];
    let mut planes = Default::default();
    let timed = |times: &mut Vec<f64>, work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        times.push(start.elapsed().as_secs_f64() * 1e3);
    };
    for round in 0..ROUNDS as i64 {
        for ((sea, trochoids), times) in seas.iter().zip(&trochoids).zip(&mut times) {
            let [new, height, squeeze, all, ask] = times;
            timed(new, &mut || drop(Trochoids::new(&sea.cascades[0], sea)));
            timed(height, &mut || trochoids.fill(round * 240, N, FieldSet::of(&[Field::Height]), &mut planes));
            timed(squeeze, &mut || trochoids.fill(round * 240, N, STRAINED, &mut planes));
            timed(all, &mut || trochoids.fill(round * 240, N, FieldSet::of(&Field::ALL), &mut planes));
            timed(ask, &mut || drop(trochoids.points(round * 240, &points, 0.0)));
        }
    }
    for (components, times) in COMPONENTS.into_iter().zip(times) {
        let (kept, error) = alone(components);
        let (worst, below, m0) = spectrum(components);
        let _ = write!(
            table,
            "| {components} | {:.1} % | {:.1} % | {worst:+.1} dB | {:.1} % | {:.3} |",
            100.0 * kept,
            100.0 * error,
            100.0 * below,
            m0
        );
        for times in times {
            let _ = write!(table, " {:.2} |", fastest(times.into_iter()));
        }
        table.push('\n');
    }
    let _ = write!(
        table,
        "\nThe sum of all modes of the same patch by transform: {:.2} ms for heights alone.\n",
        full_ms()
    );
    table
}

fn scene(components: usize, turbulence: bool) -> Scene {
    let mut scene = preset("trochoid").expect("a preset");
    scene.effects.foam = None;
    scene.model = Model::Trochoid(Trochoid { components, turbulence, ..Trochoid::default() });
    scene
}

fn sea(components: usize, turbulence: bool) -> Sea {
    Timeline::new(&scene(components, turbulence)).at(TICK)
}

fn heights(sea: &Sea, tick: i64) -> Vec<f32> {
    let mut planes: [Vec<f32>; 16] = Default::default();
    Trochoids::new(&sea.cascades[0], sea).fill(tick, N, FieldSet::of(&[Field::Height]), &mut planes);
    std::mem::take(&mut planes[Field::Height as usize])
}

fn plan() -> Plan {
    Plan { cascades: vec![CascadePlan::new([(0, FieldSet::of(&[Field::Height]))], None, &Effects::default())] }
}

fn full_ms() -> f64 {
    let mut cpu = Cpu::new(Some(1));
    cpu.load(&Sea { model: Model::Fft, ..sea(1, false) }).expect("the CPU loads");
    fastest((0..ROUNDS as i64).map(|round| {
        let start = Instant::now();
        cpu.step(round * 240, &plan()).expect("the CPU steps");
        start.elapsed().as_secs_f64() * 1e3
    }))
}

/// The fastest round is what the work costs; others share the machine.
fn fastest(times: impl Iterator<Item = f64>) -> f64 {
    times.fold(f64::INFINITY, f64::min)
}

/// Energy kept, and rms error of the height, as shares of the sum of all modes. Nothing moves sideways, so that both
/// have their heights at the same places.
fn alone(components: usize) -> (f64, f64) {
    let mut scene = scene(components, false);
    scene.effects.choppiness = 0.0;
    let sea = Timeline::new(&scene).at(TICK);
    let kept: f64 = kept_waves(&sea.cascades[0], &sea).iter().map(|wave| 0.5 * wave.amplitude * wave.amplitude).sum();
    let m0: f64 = modes(&sea).iter().map(|(_, energy)| energy).sum();
    let found = heights(&sea, TICK);
    let mut cpu = Cpu::new(Some(1));
    cpu.load(&Sea { model: Model::Fft, ..sea }).expect("the CPU loads");
    let surface = cpu.step(TICK, &plan()).expect("the CPU steps");
    let full = surface.cascades[0].plane(Field::Height).expect("heights");
    let squares = |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v).powi(2)).sum::<f64>();
    let error = squares(&mut full.iter().zip(&found).map(|(a, b)| a - b)) / squares(&mut full.iter().copied());
    (kept / m0, error.sqrt())
}

/// |(n, m)| and energy of every mode of a sea.
fn modes(sea: &Sea) -> Vec<(f64, f64)> {
    let (modes, dk) = (&sea.cascades[0], sea.cascades[0].cascade.dk());
    let waves = modes.with_wave_vectors().filter(|(kx, kz, _)| *kx > 0.0 || *kz > 0.0);
    waves.map(|(x, z, mode)| (x.hypot(z) / dk, 2.0 * (mode.forward.norm_sqr() + mode.backward.norm_sqr()))).collect()
}

/// Largest deviation of a ring's energy from the peak to Nyquist in dB, the surplus of rings below the peak and the
/// variance, both as a share of m0; the mean of eight hours.
fn spectrum(components: usize) -> (f64, f64, f64) {
    let sea = sea(components, true);
    let ring = |radius: f64| (radius / 0.71).ln() / 1.19_f64.ln();
    let rings = ring(N as f64 / 2.0) as usize;
    let (mut want, mut got) = (vec![0.0; rings], vec![0.0; rings]);
    let add = |sums: &mut [f64], radius: f64, energy: f64| {
        if let Some(sum) = sums.get_mut(ring(radius).max(0.0) as usize) {
            *sum += energy;
        }
    };
    modes(&sea).into_iter().for_each(|(radius, energy)| add(&mut want, radius, energy));
    let fft = FftPlanner::new().plan_fft_forward(N);
    for hour in 0..8 {
        let grid = heights(&sea, TICK + hour * 7200 * 3600);
        let mut values: Vec<Complex64> = grid.iter().map(|h| Complex64::new(f64::from(*h), 0.0)).collect();
        for _ in 0..2 {
            values.chunks_exact_mut(N).for_each(|row| fft.process(row));
            values = (0..N * N).map(|i| values[i % N * N + i / N]).collect();
        }
        for (i, value) in values.iter().enumerate() {
            let signed = |j: usize| if j < N / 2 { j as f64 } else { j as f64 - N as f64 };
            let energy = value.norm_sqr() / (N as f64).powi(4) / 8.0;
            add(&mut got, signed(i % N).hypot(signed(i / N)), energy);
        }
    }
    let peak = (0..rings).max_by(|a, b| want[*a].total_cmp(&want[*b])).unwrap_or(0);
    let decibels = (peak..rings).map(|i| 10.0 * (got[i] / want[i]).log10());
    let worst = decibels.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
    let m0: f64 = want.iter().sum();
    let below = (0..peak).map(|i| (got[i] - want[i]).max(0.0)).sum::<f64>();
    (worst, below / m0, got.iter().sum::<f64>() / m0)
}
