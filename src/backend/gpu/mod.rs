//! The passes on a GPU, by compute shaders through wgpu: twins of those of the CPU, under the same plan.
//!
//! A frame is one submission: columns (evolve and the transform along z), rows (along x, and what is assembled of them),
//! differences, foam, quantise; what is wanted is copied to a staging buffer, and nothing else comes back. Invariants:
//! every kernel keeps to WebGPU's default limits; what came back is only taken if the frame's kernels signed it.

mod bundle;
mod cascade;
mod compose;
mod device;
mod kernels;
mod level;
mod outlet;
mod readback;
mod settings;
mod traffic;
mod uniforms;

use std::collections::VecDeque;

use wgpu::{Buffer, BufferUsages, QuerySet, SubmissionIndex};

use super::{Backend, BackendError, CascadeSurface, Surface, Tap};
use crate::plan::Plan;
use crate::scene::Model;
use crate::sea::{Sea, turn_of_tick};
use cascade::CascadeBuffers;
use compose::{Composer, buffer, storage, uniform_buffer};
use device::Device;
use kernels::{Kernel, Kernels};
use outlet::Outlet;
use readback::{Piece, Ring, Times, clear};

pub use settings::{GpuError, GpuSettings, Storage};
pub use traffic::{Traffic, traffic};

/// Most submissions that the device has before the next one waits.
const MOST_SUBMITTED: usize = 8;
/// Frames are named from 1 up to this, which a 32-bit float holds exactly.
const NAMES: u32 = 1 << 23;
/// Timestamps of a frame: two of each kernel.
const QUERIES: u32 = 2 * Kernel::ALL.len() as u32;

/// The GPU backend. Trochoid scenes are not done by it.
pub struct Gpu {
    device: Device,
    kernels: Kernels,
    uniforms: Buffer,
    outlet: Outlet,
    repeat: u64,
    cascades: Vec<CascadeBuffers>,
    surface: Surface,
    ring: Ring,
    frame: u32,
    submitted: VecDeque<SubmissionIndex>,
    timer: Option<(QuerySet, Buffer)>,
    /// Turn of the last step, for taps.
    turn: u32,
    times: Times,
}

impl Gpu {
    /// Opens a device and reads every kernel.
    ///
    /// # Errors
    /// [`GpuError`].
    pub fn open(settings: &GpuSettings) -> Result<Self, GpuError> {
        let device = Device::open(settings)?;
        let kernels = Kernels::new(&device.device, settings.storage);
        let (uniforms, outlet) = (uniform_buffer(&device), Outlet::new(&device));
        let refused =
            |error: BackendError| GpuError::Refused { adapter: device.adapter.clone(), reason: error.to_string() };
        device.check().map_err(refused)?;
        Ok(Self {
            device,
            kernels,
            uniforms,
            outlet,
            repeat: 1,
            cascades: Vec::new(),
            surface: Surface::default(),
            ring: Ring::default(),
            frame: 0,
            submitted: VecDeque::new(),
            timer: None,
            turn: 0,
            times: Vec::new(),
        })
    }

    /// The adapter: name, kind and driver, for people.
    pub fn adapter(&self) -> &str {
        &self.device.adapter
    }

    /// Every kernel's label and whole shader, for checks that need no device.
    pub fn shaders(storage: Storage) -> Vec<(&'static str, String)> {
        Kernel::ALL.into_iter().map(|kernel| (kernel.label(), kernel.source(storage))).collect()
    }

    /// Names and members, in order, of every struct that shaders declare as we do; each member is a word.
    pub fn shared_structs() -> &'static [(&'static str, &'static [&'static str])] {
        &uniforms::SHARED
    }

    /// Names and values of every number that shaders declare as we do.
    pub fn shared_numbers() -> &'static [(&'static str, u32)] {
        uniforms::NUMBERS
    }

    /// What destroys the device, from anywhere, so that all further work of it fails: for tests and drills.
    pub fn loss(&self) -> impl Fn() + Send + Sync + use<> {
        let device = self.device.device.clone();
        move || device.destroy()
    }

    /// From now on passes are timed, where the device can: true then.
    pub fn time_passes(&mut self) -> bool {
        if self.device.timestamps && self.timer.is_none() {
            let queries = self.device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: QUERIES,
            });
            let times = buffer(&self.device, "times", u64::from(QUERIES) * 8, BufferUsages::QUERY_RESOLVE);
            self.timer = Some((queries, times));
        }
        self.timer.is_some()
    }

    /// Label and milliseconds of each pass of the frame that was collected last, where passes are timed.
    pub fn pass_times(&self) -> Vec<(&'static str, f64)> {
        let period = f64::from(self.device.queue.get_timestamp_period());
        self.times.iter().map(|(kernel, ticks)| (kernel.label(), *ticks as f64 * period / 1e6)).collect()
    }

    /// Copies so many bytes from buffer to buffer on the device, so many times, and waits for it.
    ///
    /// # Errors
    /// [`BackendError::DeviceLost`].
    pub fn copy(&self, bytes: u64, times: usize) -> Result<(), BackendError> {
        let [from, to] = ["from", "to"].map(|label| storage(&self.device, label, bytes));
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for _ in 0..times {
            encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes);
        }
        self.device.wait(self.device.queue.submit([encoder.finish()]))
    }

    /// Submits a frame without waiting for it, for [`Gpu::collect`] to fetch: what is under way keeps its order.
    ///
    /// # Errors
    /// [`BackendError`] when the plan doesn't fit or the device is lost.
    pub fn submit(&mut self, tick: i64, plan: &Plan) -> Result<(), BackendError> {
        if plan.cascades.len() != self.cascades.len() {
            return Err(BackendError::PlanMismatch { plan: plan.cascades.len(), sea: self.cascades.len() });
        }
        self.device.check()?;
        if self.submitted.len() >= MOST_SUBMITTED
            && let Some(oldest) = self.submitted.pop_front()
        {
            self.device.wait(oldest)?;
        }
        self.turn = turn_of_tick(tick, self.repeat);
        self.frame = self.frame % NAMES + 1;
        let mut composer = Composer::new(&self.device, &mut self.kernels, &self.uniforms, self.frame);
        for (cascade, plan) in self.cascades.iter_mut().zip(&plan.cascades) {
            cascade.compose(&mut composer, self.turn, plan);
        }
        let mut leaving = self.outlet.compose(&mut composer, &self.cascades, &plan.cascades)?;
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_buffer(self.outlet.found(), 0, None);
        // Times lie on a place of eight bytes.
        let times_at = leaving.words.next_multiple_of(2);
        let used = composer.used();
        let timer = self.timer.as_ref().filter(|_| !used.is_empty());
        composer.record(&mut encoder, timer.map(|(queries, _)| queries));
        if let Some((queries, times)) = timer {
            leaving.words = times_at + 4 * used.len();
            leaving.pieces.push(Piece::Times { at: times_at, kernels: used.clone() });
            let count = 2 * used.len() as u32;
            encoder.resolve_query_set(queries, 0..count, times, 0);
        }
        let staging = self.ring.staging(&self.device, leaving.words);
        if let Some(staging) = &staging {
            leaving.record(&mut encoder, staging);
            if let Some((_, times)) = timer {
                let bytes = 16 * used.len() as u64;
                encoder.copy_buffer_to_buffer(times, 0, staging, times_at as u64 * 4, bytes);
            }
        }
        let index = self.device.queue.submit([encoder.finish()]);
        self.submitted.push_back(index.clone());
        self.ring.push(tick, self.frame, staging, leaving.words, leaving.pieces, index);
        self.device.check()
    }

    /// Waits for the oldest frame that was submitted; its surface says its tick.
    ///
    /// # Errors
    /// [`BackendError::DeviceLost`], also where what came back is not what was submitted.
    pub fn collect(&mut self) -> Result<&Surface, BackendError> {
        match self.ring.collect(&self.device, &mut self.surface) {
            Some(Ok(times)) => self.times = times,
            Some(Err(error)) => {
                self.ring.forget();
                return Err(error);
            }
            None => {}
        }
        Ok(&self.surface)
    }

    /// Reads a buffer of words at once, for whoever looks between the passes.
    fn read(&self, from: &Buffer, words: usize) -> Option<Vec<f32>> {
        let staging = self.device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("tap"),
            size: words as u64 * 4,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(from, 0, &staging, 0, words as u64 * 4);
        let index = self.device.queue.submit([encoder.finish()]);
        staging.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device.wait(index).ok()?;
        let view = staging.slice(..).get_mapped_range().ok()?;
        Some(view.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
    }

    fn heights(&self, cascade: &CascadeBuffers) -> Option<Vec<f32>> {
        let modes = (cascade.cascade.half + 1) * (2 * cascade.cascade.half + 1);
        let heights = storage(&self.device, "heights", (modes * 8) as u64);
        let mut kernels = Kernels::new(&self.device.device, self.kernels.storage());
        let told = uniform_buffer(&self.device);
        let mut composer = Composer::new(&self.device, &mut kernels, &told, self.frame);
        let bind = composer.bind(Kernel::Heights, &[cascade.table(), &heights]);
        composer.add(Kernel::Heights, 0, &bind, &[self.turn], [modes.div_ceil(256), 1]);
        let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        composer.record(&mut encoder, None);
        self.device.queue.submit([encoder.finish()]);
        self.read(&heights, 2 * modes)
    }
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> &str {
        self.adapter()
    }

    fn load(&mut self, sea: &Sea) -> Result<(), BackendError> {
        if sea.model != Model::Fft {
            return Err(BackendError::Unsupported("trochoids are summed on the CPU"));
        }
        self.device.check()?;
        // Frames on their way belong to cascades that may be gone.
        while self.ring.len() > 0 {
            self.collect()?;
        }
        self.repeat = sea.repeat;
        let mut held = std::mem::take(&mut self.cascades);
        self.surface.cascades.clear();
        for modes in &sea.cascades {
            // A cascade that stays keeps its foam, wherever it stands now.
            let mut cascade = match held.iter().position(|held| held.cascade == modes.cascade) {
                Some(at) => held.swap_remove(at),
                None => CascadeBuffers::new(&self.device, modes.cascade),
            };
            cascade.load(&self.device, modes, sea, self.kernels.storage());
            self.cascades.push(cascade);
            self.surface.cascades.push(CascadeSurface::new(&modes.cascade));
        }
        self.device.check()
    }

    fn step(&mut self, tick: i64, plan: &Plan) -> Result<&Surface, BackendError> {
        self.submit(tick, plan)?;
        // Where nothing comes back there is nothing to wait for.
        let looked_at = plan.cascades.iter().any(|plan| plan.wanted.as_ref().is_none_or(|wanted| !wanted.is_empty()));
        while self.ring.len() > usize::from(!looked_at) * MOST_SUBMITTED {
            self.collect()?;
        }
        if !looked_at {
            clear(&mut self.surface);
            self.surface.tick = tick;
        }
        Ok(&self.surface)
    }

    fn surface(&self) -> &Surface {
        &self.surface
    }

    fn tap(&self, cascade: usize, tap: Tap) -> Option<Vec<f32>> {
        let cascade = self.cascades.get(cascade)?;
        match tap {
            Tap::Heights => self.heights(cascade),
            Tap::HeldFoam => match cascade.held_foam() {
                None => Some(Vec::new()),
                Some(held) => {
                    let held = self.read(held, 2 * cascade.cascade.n * cascade.cascade.n)?;
                    Some(held.as_chunks::<2>().0.iter().map(|[foam, _]| *foam).collect())
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{CascadePlan, Field, FieldSet};
    use crate::scene::{Effects, preset};
    use crate::sea::Timeline;

    #[test]
    fn what_other_kernels_made_is_not_taken() {
        let settings = GpuSettings { software: true, ..GpuSettings::default() };
        let mut gpu = match Gpu::open(&settings) {
            Ok(gpu) => gpu,
            Err(error) if std::env::var_os("SWELLCAST_REQUIRE_GPU").is_some() => panic!("a GPU is required: {error}"),
            Err(error) => return eprintln!("SKIPPED, for want of a GPU: {error}"),
        };
        let sea = Timeline::new(&preset("beaufort-1").unwrap()).at(0);
        let cascade = CascadePlan::new([(1, FieldSet::of(&[Field::Height]))], None, &Effects::default());
        let plan = Plan { cascades: vec![cascade; sea.cascades.len()] };
        gpu.load(&sea).unwrap();
        assert!(gpu.step(0, &plan).is_ok());
        gpu.submit(240, &plan).unwrap();
        gpu.ring.misname();
        assert!(matches!(gpu.collect(), Err(BackendError::DeviceLost(why)) if why.contains("as its name")));
    }
}
