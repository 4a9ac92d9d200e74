//! A frame on its way to clients: its bytes, and what a server must know of them.

use bytes::Bytes;

use super::decode::unit_of;
use crate::wire::{FLAG_KEY, FrameError, FrameHeader, UnitName, split};

/// A frame on its way to clients.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SentFrame {
    /// Whose.
    pub unit: UnitName,
    /// Its tick.
    pub tick: i64,
    /// How many frames of the lowest rate must be held to read it;
    /// [`BETWEEN`](crate::wire::BETWEEN): those on both sides of it.
    pub depth: u8,
    /// All its bytes.
    pub bytes: Bytes,
}

impl SentFrame {
    /// A frame that was kept. Its payload is checked by its checksum alone.
    ///
    /// # Errors
    /// [`FrameError`] when it is none.
    pub fn read(bytes: Bytes) -> Result<Self, FrameError> {
        let (header, _) = split(&bytes)?;
        let depth = if header.flags & FLAG_KEY == 0 { header.depth } else { 0 };
        // A tick is at most 2^53: checked with the header.
        Ok(Self { unit: unit_of(&header), tick: header.tick as i64, depth, bytes })
    }

    /// The same frame of a sea that repeats, so many ticks later.
    ///
    /// # Panics
    /// If its bytes are no frame, or the tick is none.
    pub fn later(self, ticks: i64) -> Self {
        if ticks == 0 {
            return self;
        }
        let (header, _) = split(&self.bytes).expect("a frame that was read or made");
        let tick = self.tick + ticks;
        let mut bytes = self.bytes.to_vec();
        FrameHeader { tick: u64::try_from(tick).expect("a tick"), ..header }.seal(&mut bytes);
        Self { tick, bytes: bytes.into(), ..self }
    }
}
