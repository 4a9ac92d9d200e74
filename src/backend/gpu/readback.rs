//! Brings frames back: a ring of staging buffers, each with the tick that it belongs to and what lies where in it.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use wgpu::{Buffer, BufferUsages, MapMode, SubmissionIndex};

use super::device::Device;
use super::kernels::Kernel;
use super::uniforms::{DONE, ODD, WIDE};
use crate::backend::{BackendError, Counts, Surface};
use crate::pass::quantise::Found;
use crate::plan::{Counted, Field};

/// Staging buffers that are kept for later frames.
const KEPT: usize = 4;

/// Something in a staging buffer, at a place counted in words.
pub enum Piece {
    /// A field as counts, n x n of them, and what was found about it.
    Counts { cascade: usize, of: Counted, at: usize, count: usize, found: usize },
    /// Samples of a field.
    Samples { cascade: usize, level: u8, field: Field, at: usize, count: usize },
    /// The name that a frame's kernels left beside what they made.
    Header { at: usize },
    /// When each of these kernels began and ended, in ticks of the device's clock.
    Times { at: usize, kernels: Vec<Kernel> },
}

/// A frame on its way back.
struct Pending {
    tick: i64,
    frame: u32,
    staging: Option<Buffer>,
    words: usize,
    pieces: Vec<Piece>,
    mapped: Arc<OnceLock<Result<(), String>>>,
    submitted: SubmissionIndex,
}

/// How long each kernel of a frame took, in ticks of the device's clock.
pub type Times = Vec<(Kernel, u64)>;

/// Frames on their way, oldest first.
#[derive(Default)]
pub struct Ring {
    free: Vec<Buffer>,
    pending: VecDeque<Pending>,
}

impl Ring {
    /// A staging buffer of so many words; `None` where nothing comes back.
    pub fn staging(&mut self, device: &Device, words: usize) -> Option<Buffer> {
        let bytes = words as u64 * 4;
        if words == 0 {
            return None;
        }
        if let Some(at) = self.free.iter().position(|buffer| buffer.size() >= bytes) {
            return Some(self.free.swap_remove(at));
        }
        // The smallest makes room.
        self.free.sort_by_key(|buffer| std::cmp::Reverse(buffer.size()));
        self.free.truncate(KEPT - 1);
        Some(device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size: bytes.next_power_of_two().min(device.device.limits().max_buffer_size),
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        }))
    }

    /// Notes a frame that was submitted, and asks for its staging buffer.
    pub fn push(
        &mut self,
        tick: i64,
        frame: u32,
        staging: Option<Buffer>,
        words: usize,
        pieces: Vec<Piece>,
        submitted: SubmissionIndex,
    ) {
        let mapped = Arc::new(OnceLock::new());
        if let Some(buffer) = &staging {
            let answer = Arc::clone(&mapped);
            buffer.slice(..words as u64 * 4).map_async(MapMode::Read, move |result| {
                let _ = answer.set(result.map_err(|error| error.to_string()));
            });
        }
        self.pending.push_back(Pending { tick, frame, staging, words, pieces, mapped, submitted });
    }

    /// Frames on their way.
    pub fn len(&self) -> usize {
        self.pending.len()
    }

    /// Waits for the oldest frame and puts it on a surface; its times, where it has any, come back. Nothing when none is
    /// on its way.
    pub fn collect(&mut self, device: &Device, surface: &mut Surface) -> Option<Result<Times, BackendError>> {
        let pending = self.pending.pop_front()?;
        let (staging, result) = unpack(device, pending, surface);
        if let Some(buffer) = staging {
            self.free.push(buffer);
            self.free.truncate(KEPT);
        }
        Some(result)
    }

    /// Expects another name of the newest frame than its kernels leave.
    #[cfg(test)]
    pub fn misname(&mut self) {
        self.pending.iter_mut().for_each(|pending| pending.frame += 1);
    }

    /// Forgets all frames on their way.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

fn unpack(device: &Device, pending: Pending, surface: &mut Surface) -> (Option<Buffer>, Result<Times, BackendError>) {
    let Pending { tick, frame, staging, words, pieces, mapped, submitted } = pending;
    if let Err(error) = device.wait(submitted) {
        return (None, Err(error));
    }
    clear(surface);
    surface.tick = tick;
    let Some(staging) = staging else { return (None, Ok(Vec::new())) };
    let lost = |what: &str| BackendError::DeviceLost(format!("reading frame {frame} of tick {tick} back: {what}"));
    match mapped.get() {
        Some(Ok(())) => {}
        Some(Err(error)) => return (None, Err(lost(error))),
        None => return (None, Err(lost("it was not mapped"))),
    }
    let mut times = Vec::new();
    {
        let view = match staging.slice(..words as u64 * 4).get_mapped_range() {
            Ok(view) => view,
            Err(error) => return (None, Err(lost(&error.to_string()))),
        };
        let (whole, _) = view.as_chunks::<4>();
        let word = |at: usize| u32::from_le_bytes(whole[at]);
        for piece in pieces {
            match piece {
                Piece::Header { at } => {
                    let found = f32::from_bits(word(at));
                    // What no kernel wrote is zero, or of an older frame.
                    if found != frame as f32 {
                        return (None, Err(lost(&format!("a kernel left {found} as its name"))));
                    }
                }
                Piece::Counts { cascade, of, at, count, found } => {
                    if word(found) & DONE == 0 {
                        return (None, Err(lost("counts were not made")));
                    }
                    let values = view[at * 4..at * 4 + count * 2].as_chunks::<2>().0;
                    let values = values.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect();
                    let found = Found { saturated: word(found) & WIDE != 0, not_finite: word(found) & ODD != 0 };
                    surface.cascades[cascade].counts.push(Counts { of, values, found });
                }
                Piece::Samples { cascade, level, field, at, count } => {
                    let plane = &mut surface.cascades[cascade].planes(level)[field as usize];
                    plane.extend(whole[at..at + count].iter().map(|bytes| f32::from_le_bytes(*bytes)));
                }
                Piece::Times { at, kernels } => {
                    let ticks = |i: usize| u64::from(word(at + 2 * i)) | u64::from(word(at + 2 * i + 1)) << 32;
                    let took = |(i, kernel)| (kernel, ticks(2 * i + 1).saturating_sub(ticks(2 * i)));
                    times = kernels.into_iter().enumerate().map(took).collect();
                }
            }
        }
    }
    staging.unmap();
    (Some(staging), Ok(times))
}

/// Empties a surface; its memory waits for the next frame.
pub fn clear(surface: &mut Surface) {
    for cascade in &mut surface.cascades {
        cascade.counts.clear();
        cascade.levels.iter_mut().flatten().for_each(Vec::clear);
    }
}
