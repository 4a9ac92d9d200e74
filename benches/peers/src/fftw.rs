//! The CPU step beside the bare transforms of FFTW, planned with MEASURE, for the same fields in the same run.
//!
//! `cargo run --release --manifest-path benches/peers/Cargo.toml --bin fftw -- [ROUNDS] [PAGE]` (`just peers`); needs
//! libfftw3-dev. Rounds of all contestants are interleaved.
#![allow(clippy::disallowed_methods, reason = "a bench measures time")]

use std::ffi::{c_int, c_uint, c_void};
use std::time::Instant;

use rayon::prelude::*;
use swellcast::backend::{Backend, Cpu};
use swellcast::pass::evolve::{Amplitudes, EvolveTable};
use swellcast::pass::transform::{Transform, Workspace};
use swellcast::plan::{CascadePlan, Field, FieldSet, Packing, Plan};
use swellcast::scene::{Effects, Scene, SceneFile};
use swellcast::sea::{Timeline, turn_of_tick};

const FIELDS: [Field; 8] =
    [Field::Height, Field::Dx, Field::Dz, Field::SlopeX, Field::SlopeZ, Field::Dxx, Field::Dzz, Field::Dxz];

#[link(name = "fftw3f")]
unsafe extern "C" {
    fn fftwf_plan_dft_c2r_2d(n0: c_int, n1: c_int, from: *mut f32, to: *mut f32, flags: c_uint) -> *mut c_void;
    fn fftwf_execute(plan: *const c_void);
    fn fftwf_destroy_plan(plan: *mut c_void);
    fn fftwf_malloc(bytes: usize) -> *mut c_void;
    fn fftwf_free(memory: *mut c_void);
}

/// FFTW_MEASURE.
const MEASURE: c_uint = 0;

/// One half-complex to real transform of n x n samples, on memory of FFTW's own.
struct Fftw {
    plan: *mut c_void,
    from: *mut c_void,
    to: *mut c_void,
}

// SAFETY: fftwf_execute may run on any thread; each plan has memory of its own.
unsafe impl Send for Fftw {}

impl Fftw {
    fn new(n: usize) -> Self {
        // SAFETY: both arrays have the size that the plan reads and writes, and live as long as it.
        unsafe {
            let from = fftwf_malloc(n * (n / 2 + 1) * 8);
            let to = fftwf_malloc(n * n * 4);
            let plan = fftwf_plan_dft_c2r_2d(n as c_int, n as c_int, from.cast(), to.cast(), MEASURE);
            assert!(!plan.is_null());
            // Planning overwrites the arrays; zeros stay zeros through every transform.
            from.cast::<u8>().write_bytes(0, n * (n / 2 + 1) * 8);
            to.cast::<u8>().write_bytes(0, n * n * 4);
            Self { plan, from, to }
        }
    }

    fn run(&mut self) {
        // SAFETY: the plan and its arrays are alive.
        unsafe { fftwf_execute(self.plan) }
    }
}

impl Drop for Fftw {
    fn drop(&mut self) {
        // SAFETY: made by `new`, freed once.
        unsafe {
            fftwf_destroy_plan(self.plan);
            fftwf_free(self.from);
            fftwf_free(self.to);
        }
    }
}

fn scene(n: usize, band_limit: f64) -> Scene {
    let text = format!(
        "name = \"bench\"\n[wind]\nspeed_mps = 12\nfetch_m = 200e3\n[cascades]\nn = {n}\nband_limit = {band_limit}\n\
         patches_m = [500.0]\n[effects]\nfoam = false\n"
    );
    SceneFile::from_toml(&text).and_then(|file| file.check(None)).expect("a scene")
}

/// Milliseconds of one call.
fn timed(work: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| values[values.len() * quarter / 4])
}

const INTRODUCTION: &str = "\
# The CPU step beside bare transforms

`just peers` writes this page. One cascade, all eight fields of waves (height, displacement, slopes, derivatives), each \
frame a new tick: evolve, transform, everything. Beside it, in the same run and in turns, eight bare half-complex to \
real transforms of the same size by FFTW 3 in single precision, planned with MEASURE, side by side over as many threads. \
*band*: where it ends, as a share of Nyquist; FFTW always transforms the whole. *ratio*: step over FFTW, the median of \
paired rounds and its quartiles. Then where the step's time goes, each pass alone: *evolve* turns every mode to the \
tick, *columns* multiplies by each field's factor and transforms along z, *rows* gathers and transforms along x.
";

fn main() {
    let mut arguments = std::env::args().skip(1);
    let rounds: usize = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(60);
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    let mut page = format!(
        "{INTRODUCTION}\n{rounds} rounds (half as many at 1024) on {cores} cores, {}.\n\n",
        std::env::consts::ARCH
    );
    page += "| N | band | threads | FFTW, ms | step, ms | ratio | evolve | columns | rows |\n";
    page += "|---|---|---|---|---|---|---|---|---|\n";
    for n in [256, 512, 1024] {
        for (band, name) in [(1.0, "full"), (1.0 / 3.0, "1/3")] {
            for threads in [1, 2] {
                let line = compare(n, band, name, threads, if n == 1024 { rounds.div_ceil(2) } else { rounds });
                eprintln!("{line}");
                page += &format!("{line}\n");
            }
        }
    }
    println!("{page}");
    if let Some(path) = arguments.next() {
        // What the bench of the GPU wrote stays.
        let held = std::fs::read_to_string(&path).unwrap_or_default();
        let gpu = held.find("# The GPU step").map_or("", |at| &held[at..]);
        std::fs::write(path, page + gpu).expect("the page can be written");
    }
}

fn compare(n: usize, band_limit: f64, band: &str, threads: usize, rounds: usize) -> String {
    let sea = Timeline::new(&scene(n, band_limit)).at(0);
    let mut fftw: Vec<Fftw> = FIELDS.iter().map(|_| Fftw::new(n)).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let mut cpu = Cpu::new(Some(threads));
    cpu.load(&sea).expect("the CPU loads");
    let cascade = CascadePlan::new([(0, FieldSet::of(&FIELDS))], None, &Effects::default());
    let plan = Plan { cascades: vec![cascade] };

    let table = EvolveTable::new(&sea.cascades[0], sea.choppiness, sea.repeat);
    let half = sea.cascades[0].cascade.half;
    let transform = Transform::new(n, half);
    let packings: Vec<Packing> = Packing::of(FieldSet::of(&FIELDS)).collect();
    let mut heights = Amplitudes::default();
    table.heights(0, half, &mut heights);
    let mut works: Vec<Workspace> = packings.iter().map(|_| Workspace::default()).collect();
    let mut planes: Vec<[Vec<f32>; 2]> = packings.iter().map(|_| [vec![0.0; n * n], vec![0.0; n * n]]).collect();

    let mut times: [Vec<f64>; 5] = Default::default();
    for round in 0..rounds + 5 {
        let tick = round as i64 * 240;
        let one = [
            timed(&mut || pool.install(|| fftw.par_iter_mut().with_max_len(1).for_each(Fftw::run))),
            timed(&mut || drop(cpu.step(tick, &plan).map(|surface| surface.tick))),
            timed(&mut || pool.install(|| table.heights(turn_of_tick(tick, sea.repeat), half, &mut heights))),
            timed(&mut || {
                let jobs = packings.par_iter().zip(&mut works).with_max_len(1);
                pool.install(|| jobs.for_each(|(packing, work)| transform.columns(*packing, &table, &heights, work)));
            }),
            timed(&mut || {
                let jobs = packings.par_iter().zip(&mut works).zip(&mut planes).with_max_len(1);
                pool.install(|| {
                    jobs.for_each(|((packing, work), [a, b])| transform.rows(*packing, work, [a, b]));
                });
            }),
        ];
        if round >= 5 {
            times.iter_mut().zip(one).for_each(|(times, one)| times.push(one));
        }
    }
    let ratios = times[0].iter().zip(&times[1]).map(|(fftw, step)| step / fftw).collect();
    let [low, ratio, high] = quartiles(ratios);
    let [fftw, step, evolve, columns, rows] = times.map(|times| quartiles(times)[1]);
    format!(
        "| {n} | {band} | {threads} | {fftw:.3} | {step:.3} | {ratio:.2} ({low:.2} to {high:.2}) | {evolve:.3} | \
         {columns:.3} | {rows:.3} |"
    )
}
