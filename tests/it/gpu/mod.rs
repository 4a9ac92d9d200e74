//! The GPU backend against the CPU's, pass by pass and end to end, on whatever adapter there is.
//!
//! Without one these tests say so and pass; `SWELLCAST_REQUIRE_GPU=1` makes that a failure.

mod parity;
mod shaders;
mod stream;

use std::sync::Mutex;

use swellcast::backend::{Backend, BackendError, Cpu, Gpu, GpuSettings, Storage, Surface, Tap};
use swellcast::plan::{Field, Plan};
use swellcast::sea::Sea;

/// A device, software where there is no other; `None`, loudly, where there is none at all.
pub fn gpu(storage: Storage) -> Option<Gpu> {
    let adapter = std::env::var("SWELLCAST_GPU").ok();
    match Gpu::open(&GpuSettings { adapter, software: true, storage }) {
        Ok(gpu) => Some(gpu),
        Err(error) if std::env::var_os("SWELLCAST_REQUIRE_GPU").is_some() => panic!("a GPU is required: {error}"),
        Err(error) => {
            eprintln!("SKIPPED, for want of a GPU: {error}");
            None
        }
    }
}

/// A device of one sea after another: to open one takes longer than most seas do, and none may leave anything behind.
pub struct Lent(Option<Gpu>);

static UNUSED: Mutex<Vec<Gpu>> = Mutex::new(Vec::new());

/// As [`gpu`], used before where one is free.
pub fn lent() -> Option<Lent> {
    let unused = UNUSED.lock().unwrap().pop();
    unused.or_else(|| gpu(Storage::F32)).map(|gpu| Lent(Some(gpu)))
}

impl Lent {
    fn gpu(&self) -> &Gpu {
        self.0.as_ref().expect("until it is dropped")
    }

    fn gpu_mut(&mut self) -> &mut Gpu {
        self.0.as_mut().expect("until it is dropped")
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        // After a failure, who knows what state it is in.
        if !std::thread::panicking() {
            UNUSED.lock().unwrap().extend(self.0.take());
        }
    }
}

impl Backend for Lent {
    fn name(&self) -> &'static str {
        self.gpu().name()
    }

    fn load(&mut self, sea: &Sea) -> Result<(), BackendError> {
        self.gpu_mut().load(sea)
    }

    fn step(&mut self, tick: i64, plan: &Plan) -> Result<&Surface, BackendError> {
        self.gpu_mut().step(tick, plan)
    }

    fn surface(&self) -> &Surface {
        self.gpu().surface()
    }

    fn tap(&self, cascade: usize, tap: Tap) -> Option<Vec<f32>> {
        self.gpu().tap(cascade, tap)
    }
}

/// The same step on both.
fn both(gpu: &mut Gpu, sea: &Sea, tick: i64, plan: &Plan) -> [Surface; 2] {
    let mut cpu = Cpu::new(Some(2));
    cpu.load(sea).unwrap();
    gpu.load(sea).unwrap();
    [gpu.step(tick, plan).unwrap().clone(), cpu.step(tick, plan).unwrap().clone()]
}

/// How far a field is from what it should be, over its own scale.
#[derive(Clone, Copy, Debug)]
pub struct Error {
    pub rms: f64,
    pub max: f64,
}

impl Error {
    /// Of a plane against another; where the other is nothing, the error is as it is.
    pub fn of(got: &[f32], want: &[f32], scale: f64) -> Self {
        assert_eq!(got.len(), want.len());
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let off = got.iter().zip(want).map(|(got, want)| f64::from(got - want) / scale);
        let (squares, max) = off.fold((0.0, 0.0), |(sum, max): (f64, f64), e| {
            (sum + e * e, if e.is_nan() { f64::INFINITY } else { max.max(e.abs()) })
        });
        Self { rms: (squares / got.len() as f64).sqrt(), max }
    }

    /// What two backends may differ by: rms 2e-6 and at most 2e-5 of the scale.
    pub fn is_parity(self) -> bool {
        self.rms <= 2e-6 && self.max <= 2e-5
    }
}

/// Of a field: the significant wave height for height and displacement, its own rms for what follows from them. A
/// Jacobian and its eigenvalue are 1 at rest.
pub fn scale(field: Field, plane: &[f32], hs: f64) -> f64 {
    match field {
        Field::Height | Field::Dx | Field::Dz => hs,
        Field::Jacobian | Field::Eigenvalue | Field::Foam => 1.0,
        _ => (plane.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>() / plane.len() as f64).sqrt(),
    }
}
