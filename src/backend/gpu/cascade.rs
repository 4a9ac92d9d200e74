//! One cascade on the device: its table of modes, its levels, and its foam.

use wgpu::{BindGroup, Buffer};

use super::bundle::{GRADIENT, Source, kind};
use super::compose::{Composer, storage};
use super::device::Device;
use super::kernels::Kernel;
use super::level::{HEADER_WORDS, Level, Told};
use super::settings::Storage;
use super::uniforms;
use crate::pass::evolve::EvolveTable;
use crate::plan::{CascadePlan, FoamWork, Packing};
use crate::scene::Foam;
use crate::sea::{Cascade, CascadeModes, Sea};

/// Largest number that is kept in 16 bits, with some to spare: they hold 65504.
const LARGEST_F16: f64 = 60_000.0;

/// A cascade and all that the device keeps of it.
pub struct CascadeBuffers {
    pub cascade: Cascade,
    table: Buffer,
    /// By kind of packing, of the height and of its rate: factors that keep it within 16 bits; 1 where all is 32 bits.
    scales: [[f32; 2]; 5],
    levels: Vec<Option<Level>>,
    foam: Option<FoamBuffers>,
    foam_threshold: f32,
}

struct FoamBuffers {
    held: Buffer,
    shown: Buffer,
    bind: BindGroup,
}

impl CascadeBuffers {
    /// A cascade that holds no sea yet.
    pub fn new(device: &Device, cascade: Cascade) -> Self {
        let modes = (cascade.half + 1) * (2 * cascade.half + 1);
        Self {
            cascade,
            table: storage(device, "table", (modes * 32) as u64),
            scales: [[1.0; 2]; 5],
            levels: (0..cascade.levels()).map(|_| None).collect(),
            foam: None,
            foam_threshold: 0.0,
        }
    }

    /// Takes the modes of a sea. What is held of foam stays.
    pub fn load(&mut self, device: &Device, modes: &CascadeModes, sea: &Sea, kept: Storage) {
        let words: Vec<[u32; 8]> = EvolveTable::new(modes, sea.choppiness, sea.repeat).words().collect();
        device.queue.write_buffer(&self.table, 0, bytemuck::cast_slice(&words));
        self.foam_threshold = modes.foam_threshold as f32;
        if kept == Storage::F16 {
            self.scales = scales(modes, sea);
        }
    }

    /// The table of modes, for whoever looks between the passes.
    pub fn table(&self) -> &Buffer {
        &self.table
    }

    /// Foam held since the last foam tick.
    pub fn held_foam(&self) -> Option<&Buffer> {
        Some(&self.foam.as_ref()?.held)
    }

    /// The buffer of a source at a level, once it has been made.
    pub fn buffer(&self, level: u8, source: Source) -> Option<&Buffer> {
        match source {
            Source::Foam => Some(&self.foam.as_ref()?.shown),
            _ => self.levels.get(usize::from(level))?.as_ref()?.buffer(source),
        }
    }

    /// Adds all passes of a plan to a frame, but for quantising.
    pub fn compose(&mut self, composer: &mut Composer, turn: u32, plan: &CascadePlan) {
        let scales = self.scales;
        let scale = move |packing: Packing| {
            let (kind, rate) = kind(packing);
            scales[kind as usize][usize::from(rate)]
        };
        let told = Told { table: &self.table, turn, scale: &scale };
        for planned in &plan.levels {
            let level = &mut self.levels[usize::from(planned.level)];
            let level = level.get_or_insert_with(|| Level::new(composer, &self.cascade, planned.level));
            level.compose(composer, &told, planned);
        }
        if let Some(work) = plan.foam {
            self.add_foam(composer, work);
        }
    }

    fn add_foam(&mut self, composer: &mut Composer, work: FoamWork) {
        let samples = self.cascade.n * self.cascade.n;
        let full = self.levels[0].get_or_insert_with(|| Level::new(composer, &self.cascade, 0));
        full.ensure(composer, &self.table, GRADIENT);
        let Some(jacobian) = full.buffer(Source::Assembled) else { return };
        let foam = self.foam.get_or_insert_with(|| {
            let held = storage(composer.device, "held foam", (samples * 8) as u64);
            let shown = storage(composer.device, "foam", (HEADER_WORDS + samples as u64) * 4);
            let bind = composer.bind(Kernel::Foam, &[jacobian, &held, &shown]);
            FoamBuffers { held, shown, bind }
        });
        let told = uniforms::Foam {
            frame: composer.frame,
            samples: samples as u32,
            restart: u32::from(work.restart),
            advance: u32::from(work.advance),
            breaks: u32::from(work.breaks),
            threshold: self.foam_threshold,
            decay: work.decay,
            growth: work.growth,
            steepness: (1.0 / Foam::SOURCE_WIDTH) as f32,
            flush: Foam::FLUSH as f32,
        };
        composer.add(Kernel::Foam, self.cascade.n, &foam.bind, &told.words(), [samples.div_ceil(256), 1]);
    }
}

/// Powers of two by which no column of a packing can leave 16 bits, whatever the phases: a sum of M terms is at most
/// sqrt(M) times the root of the sum of their squares (Cauchy-Schwarz).
fn scales(modes: &CascadeModes, sea: &Sea) -> [[f32; 2]; 5] {
    let mut squares = [[0.0_f64; 2]; 5];
    for (kx, kz, mode) in modes.with_wave_vectors() {
        let h = 2.0 * (mode.forward.norm_sqr() + mode.backward.norm_sqr());
        let rate = h * mode.omega(sea.repeat) * mode.omega(sea.repeat);
        let k = libm::hypot(kx, kz);
        let chop = if k > 0.0 { sea.choppiness * mode.widening / k } else { 0.0 };
        let factors = [1.0, chop * k, k, chop * libm::hypot(kx * kx, kz * kz), chop * (kx * kz).abs()];
        for (squares, factor) in squares.iter_mut().zip(factors) {
            squares[0] += h * factor * factor;
            squares[1] += rate * factor * factor;
        }
    }
    let most = (modes.rows() as f64).sqrt();
    squares.map(|pair| {
        pair.map(|sum| {
            let bound = most * sum.sqrt();
            // Within what a 32-bit float can invert.
            if bound > 0.0 { (LARGEST_F16 / bound).log2().floor().clamp(-100.0, 100.0).exp2() as f32 } else { 1.0 }
        })
    })
}
