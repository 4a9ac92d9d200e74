//! The plain way: counts of the same step as Swellcast's, 2-D Lorenzo prediction within the frame, zstd level 1.

use swellcast::pass::quantise::quantise;
use zstd::bulk::{Compressor, Decompressor};

use crate::{CHANNELS, N, Peer};

/// All channels, each with its step.
pub struct Lorenzo {
    steps: [f32; CHANNELS],
    counts: Vec<i16>,
    /// Of each channel all low bytes of its residuals, then all high ones: packed better and faster than pairs.
    planes: Vec<u8>,
    packed: Vec<u8>,
    compressor: Compressor<'static>,
    decompressor: Decompressor<'static>,
}

impl Lorenzo {
    pub fn new(steps: [f32; CHANNELS]) -> Self {
        let bytes = 2 * CHANNELS * N * N;
        Self {
            steps,
            counts: vec![0; N * N],
            planes: vec![0; bytes],
            packed: Vec::with_capacity(zstd::zstd_safe::compress_bound(bytes)),
            compressor: Compressor::new(1).expect("zstd has a level 1"),
            decompressor: Decompressor::new().expect("zstd opens"),
        }
    }
}

impl Peer for Lorenzo {
    fn encode(&mut self, channels: &[Vec<f32>]) -> usize {
        for ((channel, step), bytes) in channels.iter().zip(self.steps).zip(self.planes.chunks_exact_mut(2 * N * N)) {
            let found = quantise(channel.iter().copied(), step, &mut self.counts);
            assert!(!found.saturated && !found.not_finite);
            let (low, high) = bytes.split_at_mut(N * N);
            let rows = low.chunks_exact_mut(N).zip(high.chunks_exact_mut(N));
            let mut above: &[i16] = &[0; N];
            for (row, (low, high)) in self.counts.chunks_exact(N).zip(rows) {
                let mut left = 0;
                for x in 0..N {
                    let rise = row[x].wrapping_sub(above[x]);
                    let residual = rise.wrapping_sub(left);
                    left = rise;
                    // Small ones of either sign become small numbers.
                    let folded = residual << 1 ^ residual >> 15;
                    [low[x], high[x]] = folded.to_le_bytes();
                }
                above = row;
            }
        }
        self.packed.clear();
        self.compressor.compress_to_buffer(&self.planes, &mut self.packed).expect("there is room")
    }

    fn decode(&mut self, channels: &mut [Vec<f32>]) {
        self.decompressor.decompress_to_buffer(&self.packed, &mut self.planes[..]).expect("it was packed above");
        for ((channel, step), bytes) in channels.iter_mut().zip(self.steps).zip(self.planes.chunks_exact(2 * N * N)) {
            let (low, high) = bytes.split_at(N * N);
            let rows = low.chunks_exact(N).zip(high.chunks_exact(N));
            let mut counts = [0i16; N];
            for (row, (low, high)) in channel.chunks_exact_mut(N).zip(rows) {
                let mut rise = 0i16;
                for x in 0..N {
                    let folded = u16::from_le_bytes([low[x], high[x]]);
                    rise = rise.wrapping_add((folded >> 1) as i16 ^ -((folded & 1) as i16));
                    counts[x] = counts[x].wrapping_add(rise);
                    row[x] = f32::from(counts[x]) * step;
                }
            }
        }
    }
}
