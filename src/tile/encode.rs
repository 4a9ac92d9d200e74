//! Frames of one unit at one tick: header and payload in one piece of bytes that everybody shares.

use bytes::Bytes;
use thiserror::Error;

use super::level::{Tile, averages, row_of, tiles_per_side};
use crate::pass::quantise::{Found, quantise, quantiser_step};
use crate::wire::{CODEC_I16, FLAG_KEY, FLAG_SATURATED, FrameHeader, Group, HEADER_BYTES, MAGIC, TILE, UnitName};

/// What a frame says beside its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// The tick.
    pub tick: i64,
    /// Identity of the timeline.
    pub epoch: u64,
    /// Newest change in effect at the tick.
    pub sequence: u64,
    /// Generation of the layout.
    pub layout: u32,
}

/// A channel of a unit, before tiles are cut.
#[derive(Clone, Copy, Debug)]
pub enum Plane<'a> {
    /// Samples of the unit's level, but foam's of the full grid.
    Samples(&'a [f32]),
    /// Counts of the unit's level and step, and what was found while they were made.
    Counts(&'a [i16], Found),
}

/// Why no frame was made. A frame with a wrong number is never sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// A sample was not a number, or infinite.
    #[error("{channel} holds a value that is not finite")]
    NotFinite {
        /// The channel's name.
        channel: &'static str,
    },
}

/// Encodes one unit: one frame per tile. `n` is the side of the full grid; `planes` are the group's channels, `[z][x]`.
///
/// # Errors
/// [`EncodeError::NotFinite`].
///
/// # Panics
/// If there are fewer planes than the group has channels, or one is not of its grid.
pub fn encode(unit: UnitName, n: usize, planes: &[Plane], stamp: Stamp) -> Result<Vec<Bytes>, EncodeError> {
    let level_n = n >> unit.level;
    let tiles = tiles_per_side(level_n);
    let side = level_n.min(TILE);
    (0..tiles * tiles).map(|i| encode_tile(unit, n, planes, stamp, Tile { side, x: i % tiles, z: i / tiles })).collect()
}

fn encode_tile(unit: UnitName, n: usize, planes: &[Plane], stamp: Stamp, tile: Tile) -> Result<Bytes, EncodeError> {
    let channels = unit.group.channels();
    let plane_bytes = tile.side * tile.side * 2;
    let mut frame = vec![0; HEADER_BYTES + channels.len() * plane_bytes];
    let step = quantiser_step(unit.class, unit.group);
    let (stride, level_n) = (1 << unit.level, n >> unit.level);
    let mut flags = FLAG_KEY;
    let payload = frame[HEADER_BYTES..].chunks_exact_mut(plane_bytes);
    for ((counts, plane), channel) in payload.zip(planes).zip(channels) {
        let mut found = Found::default();
        for (row, counts) in counts.chunks_exact_mut(tile.side * 2).enumerate() {
            found = found.and(match (*plane, unit.group, stride) {
                (Plane::Counts(made, found), ..) => {
                    let row = row_of(made, level_n, tile, row);
                    for (bytes, count) in counts.as_chunks_mut::<2>().0.iter_mut().zip(row) {
                        *bytes = count.to_le_bytes();
                    }
                    // Found of the whole plane, told of the tiles that hold the largest count.
                    let clamped = found.saturated && row.iter().any(|count| count.unsigned_abs() == 32767);
                    Found { saturated: clamped, ..found }
                }
                (Plane::Samples(plane), Group::Foam, 2..) => {
                    quantise(averages(plane, n, stride, tile, row), step, counts)
                }
                (Plane::Samples(plane), ..) => {
                    quantise(row_of(plane, level_n, tile, row).iter().copied(), step, counts)
                }
            });
        }
        if found.not_finite {
            return Err(EncodeError::NotFinite { channel });
        }
        if found.saturated {
            flags |= FLAG_SATURATED;
        }
    }
    let per_channel = |value: f32| std::array::from_fn(|i| if i < channels.len() { value } else { 0.0 });
    let header = FrameHeader {
        magic: MAGIC,
        header_bytes: HEADER_BYTES as u16,
        cascade: unit.cascade,
        level: unit.level,
        class: unit.class.id(),
        group: unit.group.id(),
        codec: CODEC_I16,
        flags,
        n: tile.side as u16,
        level_n: level_n as u16,
        tile_x: tile.x as u16,
        tile_z: tile.z as u16,
        channels: channels.len() as u16,
        zero_a: 0,
        tick: stamp.tick as u64,
        epoch: stamp.epoch,
        sequence: stamp.sequence,
        layout: stamp.layout,
        payload_bytes: (channels.len() * plane_bytes) as u32,
        step: per_channel(step),
        max_error: per_channel(unit.class.max_error(unit.group)),
        crc: 0,
        zero_b: 0,
    };
    header.seal(&mut frame);
    Ok(Bytes::from(frame))
}
