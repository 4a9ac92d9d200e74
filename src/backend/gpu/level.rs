//! Buffers of one level of a cascade, and the two passes over each of its bundles.

use wgpu::{BindGroup, Buffer};

use super::bundle::{BUNDLES, Bundle, GRADIENT, MOTION, Source, Work, kind};
use super::compose::{Composer, storage};
use super::kernels::Kernel;
use super::settings::Storage;
use super::uniforms::{Columns, Differences, HEADER, Rows};
use crate::plan::{Field, LevelPlan, Packing};
use crate::scene::Normals;
use crate::sea::Cascade;

/// Words before the first plane of a buffer.
pub const HEADER_WORDS: u64 = HEADER as u64;
/// Samples that one workgroup transforms at a time.
const SAMPLES: usize = 2048;

/// What a cascade tells its levels of a frame.
pub struct Told<'a> {
    pub table: &'a Buffer,
    pub turn: u32,
    /// Factor that keeps a packing within 16 bits.
    pub scale: &'a dyn Fn(Packing) -> f32,
}

/// One grid of a cascade.
pub struct Level {
    n: usize,
    half: usize,
    /// Blocks of 4 columns of a packing.
    blocks: usize,
    table_half: usize,
    dk: f32,
    twiddles: Buffer,
    bundles: [Option<BundleBuffers>; BUNDLES.len()],
}

struct BundleBuffers {
    planes: Buffer,
    /// Jacobian, eigenvalue and normals; of other bundles than the gradient's no more than the header.
    assembled: Buffer,
    columns: BindGroup,
    rows: BindGroup,
}

impl Level {
    /// A level that has made nothing yet.
    pub fn new(composer: &Composer, cascade: &Cascade, level: u8) -> Self {
        let (n, half) = cascade.level(level);
        let twiddles: Vec<[f32; 2]> = (0..n)
            .map(|k| {
                let angle = 2.0 * std::f64::consts::PI * k as f64 / n as f64;
                [libm::cos(angle) as f32, libm::sin(angle) as f32]
            })
            .collect();
        let buffer = storage(composer.device, "twiddles", (n * 8) as u64);
        composer.device.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&twiddles));
        Self {
            n,
            half,
            blocks: (2 * half + 1).div_ceil(4),
            table_half: cascade.half,
            dk: cascade.dk() as f32,
            twiddles: buffer,
            bundles: Default::default(),
        }
    }

    /// The buffer of a source, once it has been made.
    pub fn buffer(&self, source: Source) -> Option<&Buffer> {
        match source {
            Source::Planes(bundle) => Some(&self.bundles[bundle].as_ref()?.planes),
            Source::Assembled => Some(&self.bundles[GRADIENT].as_ref()?.assembled),
            Source::Foam => None,
        }
    }

    /// Bytes of the header and so many planes.
    pub fn bytes_of(&self, planes: usize) -> u64 {
        (HEADER_WORDS + (planes * self.n * self.n) as u64) * 4
    }

    /// Adds the passes of a plan to a frame.
    pub fn compose(&mut self, composer: &mut Composer, told: &Told, plan: &LevelPlan) {
        for (index, bundle) in BUNDLES.iter().enumerate() {
            if let Some(work) = bundle.work(plan) {
                self.bundle(composer, told, index, bundle, work, plan.normals);
            }
        }
        let normals = plan.fields.contains(Field::NormalX) || plan.fields.contains(Field::NormalZ);
        let side = match plan.normals {
            Normals::CentralDifference => 0.0,
            Normals::Sobel => 0.25,
            _ => return,
        };
        if normals {
            self.differences(composer, told, side);
        }
    }

    /// Makes the buffers of a bundle, so that others can bind them.
    pub fn ensure(&mut self, composer: &Composer, table: &Buffer, index: usize) {
        if self.bundles[index].is_some() {
            return;
        }
        let device = composer.device;
        let stored: u64 = if composer.kernels.storage() == Storage::F16 { 4 } else { 8 };
        let between = storage(device, "between", 3 * (self.blocks * 4 * self.n) as u64 * stored);
        let planes = storage(device, "planes", self.bytes_of(5));
        let assembled = storage(device, "assembled", self.bytes_of(if index == GRADIENT { 4 } else { 0 }));
        let columns = composer.bind(Kernel::Columns, &[table, &self.twiddles, &between]);
        let rows = composer.bind(Kernel::Rows, &[&self.twiddles, &between, &planes, &assembled]);
        self.bundles[index] = Some(BundleBuffers { planes, assembled, columns, rows });
    }

    fn bundle(
        &mut self,
        composer: &mut Composer,
        told: &Told,
        index: usize,
        bundle: &Bundle,
        work: Work,
        normals: Normals,
    ) {
        self.ensure(composer, told.table, index);
        let Some(buffers) = &self.bundles[index] else { return };
        let lines = SAMPLES / self.n;
        let mut run = [(0, (0, false), 1.0); 3];
        let made = bundle.slots.iter().enumerate().filter(|(slot, _)| work.made[*slot]);
        let made: Vec<_> = made.filter_map(|(slot, packing)| Some((slot as u32, (*packing)?))).collect();
        for (run, (slot, packing)) in run.iter_mut().zip(&made) {
            *run = (*slot, kind(*packing), (told.scale)(*packing));
        }
        let [a, b, c] = run;
        let columns = Columns {
            turn: told.turn,
            half: self.half as u32,
            table_half: self.table_half as u32,
            blocks: self.blocks as u32,
            slot0: a.0,
            kind0: a.1.0,
            rate0: u32::from(a.1.1),
            slot1: b.0,
            kind1: b.1.0,
            rate1: u32::from(b.1.1),
            slot2: c.0,
            kind2: c.1.0,
            rate2: u32::from(c.1.1),
            dk: self.dk,
            scale0: a.2,
            scale1: b.2,
            scale2: c.2,
        };
        if !made.is_empty() {
            let groups = [(2 * self.half + 1).div_ceil(lines), made.len()];
            composer.add(Kernel::Columns, self.n, &buffers.columns, &columns.words(), groups);
        }
        let unscale = |slot: usize| bundle.slots[slot].map_or(1.0, |packing| 1.0 / (told.scale)(packing));
        let bit = |slot: usize| u32::from(work.made[slot]) << slot;
        let rows = Rows {
            frame: composer.frame,
            half: self.half as u32,
            blocks: self.blocks as u32,
            made: bit(0) | bit(1) | bit(2),
            write: work.write,
            normals: match normals {
                Normals::Diagonal => 1,
                Normals::None => 2,
                _ => 0,
            },
            unscale_a: unscale(0),
            unscale_b: unscale(1),
            unscale_single: unscale(2),
        };
        composer.add(Kernel::Rows, self.n, &buffers.rows, &rows.words(), [(self.n / 2).div_ceil(lines), 1]);
    }

    fn differences(&mut self, composer: &mut Composer, told: &Told, side: f32) {
        self.ensure(composer, told.table, GRADIENT);
        let (Some(motion), Some(gradient)) = (&self.bundles[MOTION], &self.bundles[GRADIENT]) else { return };
        let bind = composer.bind(Kernel::Differences, &[&motion.planes, &gradient.assembled]);
        // dk = 2 pi / patch.
        let spacing = 2.0 * std::f32::consts::PI / self.dk / self.n as f32;
        let [middle, side] = [1.0 - 2.0 * side, side].map(|weight| weight * 0.5 / spacing);
        let words = Differences { frame: composer.frame, n: self.n as u32, middle, side }.words();
        composer.add(Kernel::Differences, self.n, &bind, &words, [self.n.div_ceil(16); 2]);
    }
}
