//! A frame back to numbers.

use crate::wire::{ErrorClass, FrameError, FrameHeader, Group, UnitName, split};

/// One tile of one unit at one tick.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedFrame {
    /// All the frame says about itself.
    pub header: FrameHeader,
    /// Channels in the order of the group, each n x n, `[z][x]`.
    pub planes: Vec<Vec<f32>>,
}

impl DecodedFrame {
    /// The unit it belongs to.
    pub fn unit(&self) -> UnitName {
        UnitName {
            cascade: self.header.cascade,
            level: self.header.level,
            class: ErrorClass::from_id(self.header.class).expect("checked when it was read"),
            group: Group::from_id(self.header.group).expect("checked when it was read"),
        }
    }
}

/// Reads a frame.
///
/// # Errors
/// [`FrameError`] for bytes that are no frame.
pub fn decode(frame: &[u8]) -> Result<DecodedFrame, FrameError> {
    let (header, payload) = split(frame)?;
    let plane_bytes = usize::from(header.n) * usize::from(header.n) * 2;
    let plane = |(counts, step): (&[u8], f32)| -> Vec<f32> {
        counts.as_chunks::<2>().0.iter().map(|bytes| f32::from(i16::from_le_bytes(*bytes)) * step).collect()
    };
    let planes = payload.chunks_exact(plane_bytes).zip(header.step).map(plane).collect();
    Ok(DecodedFrame { header, planes })
}
