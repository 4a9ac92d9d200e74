//! What leaves the device of a frame: fields as counts, quantised there, and fields as samples.

use std::collections::{BTreeMap, BTreeSet};

use wgpu::{BindingResource, Buffer, BufferBinding};

use super::bundle::{Source, place};
use super::cascade::CascadeBuffers;
use super::compose::{Composer, storage};
use super::device::Device;
use super::kernels::Kernel;
use super::level::HEADER_WORDS;
use super::readback::Piece;
use super::uniforms::Quantise;
use crate::backend::BackendError;
use crate::plan::{CascadePlan, Counted, Field, FieldSet};

/// Jobs begin at multiples of so many, where a binding may begin.
const JOBS_ALIGNED: usize = 8;
/// Most jobs of one frame that room is made for at first.
const JOBS: u64 = 1024;

/// Room for the times of a frame.
const TIMES: u64 = 256;

/// Buffers that quantising fills; they grow with what is wanted.
pub struct Outlet {
    jobs: Buffer,
    counts: Buffer,
    found: Buffer,
}

/// A copy to the staging buffer, in words.
struct Copy {
    from: Buffer,
    at: u64,
    to: usize,
    words: usize,
}

/// Copies of one frame, and what they mean.
#[derive(Default)]
pub struct Leaving {
    copies: Vec<Copy>,
    pub pieces: Vec<Piece>,
    /// Words in all.
    pub words: usize,
}

impl Leaving {
    fn add(&mut self, from: &Buffer, at: u64, words: usize) -> usize {
        let to = self.words;
        self.copies.push(Copy { from: from.clone(), at, to, words });
        self.words += words;
        to
    }

    /// Records every copy.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, staging: &Buffer) {
        for Copy { from, at, to, words } in &self.copies {
            encoder.copy_buffer_to_buffer(from, at * 4, staging, *to as u64 * 4, *words as u64 * 4);
        }
    }
}

impl Outlet {
    pub fn new(device: &Device) -> Self {
        let (jobs, counts) = (storage(device, "jobs", JOBS * 32), storage(device, "counts", 4096));
        Self { jobs, counts, found: storage(device, "found", JOBS * 4) }
    }

    /// What is found about counts, which begins every frame with nothing.
    pub fn found(&self) -> &Buffer {
        &self.found
    }

    /// Adds quantising of what is wanted to a frame, and lists all that leaves.
    pub fn compose(
        &mut self,
        composer: &mut Composer,
        cascades: &[CascadeBuffers],
        plans: &[CascadePlan],
    ) -> Result<Leaving, BackendError> {
        let mut leaving = Leaving::default();
        let mut sources: BTreeSet<(usize, u8, Source)> = BTreeSet::new();
        let mut jobs: BTreeMap<(usize, u8, Source), Vec<Quantise>> = BTreeMap::new();
        let mut counts: Vec<(usize, Counted, usize, usize)> = Vec::new();
        let mut words = 0;
        for (index, (cascade, plan)) in cascades.iter().zip(plans).enumerate() {
            let Some(wanted) = &plan.wanted else {
                for level in &plan.levels {
                    add_samples(&mut leaving, &mut sources, index, cascade, level.level, level.fields);
                }
                continue;
            };
            let made = |level: u8| {
                let planned = plan.levels.iter().find(|planned| planned.level == level);
                planned.map_or(FieldSet::NONE, |planned| planned.fields)
            };
            let samples = wanted.samples.intersection(made(0));
            add_samples(&mut leaving, &mut sources, index, cascade, 0, samples);
            for of in &wanted.counts {
                // Foam is made on the full grid, and averaged for the others.
                let from = if of.field == Field::Foam { 0 } else { of.level };
                if !made(from).contains(of.field)
                    || counts.iter().any(|(known, counted, ..)| (*known, counted) == (index, of))
                {
                    continue;
                }
                let (source, plane) = place(of.field);
                let n = cascade.cascade.n >> from;
                let side = cascade.cascade.n >> of.level;
                sources.insert((index, from, source));
                jobs.entry((index, from, source)).or_default().push(Quantise {
                    plane: plane as u32,
                    n: n as u32,
                    stride: (n / side) as u32,
                    words: words as u32,
                    found: counts.len() as u32,
                    inverse_step: 1.0 / of.step,
                    share: of.share,
                    none: 0,
                });
                counts.push((index, *of, words, side * side));
                words += side * side / 2;
            }
        }
        // Names first, so that nothing is read of a frame that was not made.
        for (cascade, level, source) in sources {
            if let Some(buffer) = cascades[cascade].buffer(level, source) {
                let at = leaving.add(buffer, 0, 1);
                leaving.pieces.insert(0, Piece::Header { at });
            }
        }
        let limits = composer.device.device.limits();
        let all = leaving.words + words + counts.len();
        if all as u64 * 4 + TIMES > limits.max_buffer_size || words as u64 * 4 > limits.max_storage_buffer_binding_size
        {
            return Err(BackendError::Unsupported("more is wanted of a frame than the device holds at a time"));
        }
        if !counts.is_empty() {
            self.quantise(composer, cascades, &jobs, words, counts.len());
            let (at, found) = (leaving.add(&self.counts, 0, words), leaving.add(&self.found, 0, counts.len()));
            let piece = |(place, (cascade, of, words, count))| Piece::Counts {
                cascade,
                of,
                at: at + words,
                count,
                found: found + place,
            };
            leaving.pieces.extend(counts.into_iter().enumerate().map(piece));
        }
        Ok(leaving)
    }

    fn quantise(
        &mut self,
        composer: &mut Composer,
        cascades: &[CascadeBuffers],
        jobs: &BTreeMap<(usize, u8, Source), Vec<Quantise>>,
        words: usize,
        found: usize,
    ) {
        let device = composer.device;
        let grown = |buffer: &mut Buffer, label: &str, bytes: usize| {
            if buffer.size() < bytes as u64 {
                let most = device.device.limits().max_storage_buffer_binding_size;
                *buffer = storage(device, label, (bytes as u64).next_power_of_two().min(most));
            }
        };
        let places: usize = jobs.values().map(|jobs| jobs.len().next_multiple_of(JOBS_ALIGNED)).sum();
        grown(&mut self.jobs, "jobs", places * 32);
        grown(&mut self.counts, "counts", words * 4);
        grown(&mut self.found, "found", found * 4);
        let mut told: Vec<[u32; 8]> = Vec::with_capacity(places);
        for ((cascade, level, source), jobs) in jobs {
            let Some(buffer) = cascades[*cascade].buffer(*level, *source) else { continue };
            let here = BufferBinding { offset: (told.len() * 32) as u64, ..self.jobs.as_entire_buffer_binding() };
            let resources = [
                BindingResource::Buffer(here),
                buffer.as_entire_binding(),
                self.counts.as_entire_binding(),
                self.found.as_entire_binding(),
            ];
            let bind = composer.bind_resources(Kernel::Quantise, resources.into_iter());
            let most = jobs.iter().map(|job| (job.n / job.stride).pow(2) as usize / 2).max().unwrap_or(0);
            composer.add(Kernel::Quantise, 0, &bind, &[], [most.div_ceil(256), jobs.len()]);
            told.extend(jobs.iter().map(|job| job.words()));
            told.resize(told.len().next_multiple_of(JOBS_ALIGNED), [0; 8]);
        }
        device.queue.write_buffer(&self.jobs, 0, bytemuck::cast_slice(&told));
    }
}

fn add_samples(
    leaving: &mut Leaving,
    sources: &mut BTreeSet<(usize, u8, Source)>,
    index: usize,
    cascade: &CascadeBuffers,
    level: u8,
    fields: FieldSet,
) {
    let n = cascade.cascade.n >> level;
    for field in fields.iter() {
        let (source, plane) = place(field);
        let Some(buffer) = cascade.buffer(level, source) else { continue };
        sources.insert((index, level, source));
        let at = leaving.add(buffer, HEADER_WORDS + (plane * n * n) as u64, n * n);
        leaving.pieces.push(Piece::Samples { cascade: index, level, field, at, count: n * n });
    }
}
