//! A frame's bytes as numbers: checked by `wire`, then each count times its channel's step.

use crate::wire::{FrameError, FrameHeader, split};

/// A decoded frame: one tile of one unit at one tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// What the frame says of itself.
    pub header: FrameHeader,
    /// The planes of its channels, one after the other, each n x n with x running fastest.
    pub samples: Vec<f32>,
}

impl Tile {
    /// Reads a frame.
    ///
    /// # Errors
    /// [`FrameError`] for every frame that PROTOCOL.md section 5 says must be dropped.
    pub fn decode(frame: &[u8]) -> Result<Self, FrameError> {
        let (header, payload) = split(frame)?;
        let plane = usize::from(header.n) * usize::from(header.n);
        let (counts, _) = payload.as_chunks::<2>();
        let samples = counts
            .chunks_exact(plane)
            .zip(header.step)
            .flat_map(|(counts, step)| counts.iter().map(move |count| f32::from(i16::from_le_bytes(*count)) * step))
            .collect();
        Ok(Self { header, samples })
    }

    /// The plane of one channel; empty for a channel that isn't there.
    pub fn plane(&self, channel: usize) -> &[f32] {
        let plane = usize::from(self.header.n) * usize::from(self.header.n);
        self.samples.chunks_exact(plane).nth(channel).unwrap_or_default()
    }
}
