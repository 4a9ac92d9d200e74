//! Frames of one unit, tick after tick: header and payload in one piece of bytes that everybody shares.
//!
//! Frames of the lowest rate are predicted from up to three before them, those between from both their neighbours, so
//! they leave later. All are coded without loss from the counts, so a frame decodes to the same counts however deep its
//! prediction reached: whoever has not followed is given other frames of the same ticks, and nobody else notices.

use std::collections::VecDeque;

use bytes::Bytes;

use super::counts::{CountedTile, EncodeError, Plane, counted_tiles, tiles_of};
use super::deflate::{deflate, residual_bytes};
use super::fit::fit;
use super::floats::float_payload;
use super::history::History;
use super::level::Tile;
use super::predict::{Basis, Taps};
use super::rans;
use super::residual::Residuals;
use super::sent::SentFrame;
use crate::pass::quantise::quantiser_step;
use crate::wire::{
    BETWEEN, Codec, FLAG_KEY, FLAG_SATURATED, FrameHeader, HEADER_BYTES, MAGIC, MAX_DEPTH, SLOWEST_INTERVAL,
    TICKS_PER_SECOND, UnitName, layer_of,
};

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

/// Encodes the frames of one unit.
#[derive(Debug)]
pub struct UnitEncoder {
    unit: UnitName,
    /// Of each tile.
    histories: Vec<History>,
    /// Frames between two of the lowest rate, until they can be predicted: in the order in which they leave.
    held: VecDeque<(Stamp, Vec<CountedTile>)>,
    /// Those of `held` that can leave.
    ready: usize,
    /// Bit d: somebody needs the next frame of the lowest rate predicted from d frames at most.
    joining: u8,
    residuals: Residuals,
}

impl UnitEncoder {
    /// An encoder that has made nothing yet.
    pub fn new(unit: UnitName) -> Self {
        let (held, residuals) = (VecDeque::new(), Residuals::default());
        Self { unit, histories: Vec::new(), held, ready: 0, joining: 0, residuals }
    }

    /// Somebody joins: the next frame of the lowest rate comes also as a key frame, and those after it as that one
    /// who joined can read them.
    pub fn join(&mut self) {
        self.joining |= 1;
    }

    /// Takes the unit at one tick and gives the frames that leave now: one for each tile, of one tick or several, the
    /// deepest predictions of a tick first. `n` is the side of the full grid; `planes` are the group's channels,
    /// `[z][x]`.
    ///
    /// # Errors
    /// [`EncodeError::NotFinite`]: nothing is made of this tick.
    ///
    /// # Panics
    /// If there are fewer planes than the group has channels, or one is not of its grid, or floats are to be made of
    /// counts.
    pub fn take(&mut self, n: usize, planes: &[Plane], stamp: Stamp) -> Result<Vec<SentFrame>, EncodeError> {
        if self.unit.codec.is_float() {
            return self.floats(n, planes, stamp);
        }
        let tiles = counted_tiles(self.unit, n, planes)?;
        if !self.unit.codec.predicts() {
            return Ok(self.frames(n, stamp, &tiles, 0));
        }
        let mut frames = Vec::new();
        if layer_of(stamp.tick) == 0 {
            while self.ready > 0 {
                self.leave(n, &mut frames);
            }
            self.lowest(n, stamp, &tiles, &mut frames);
        } else {
            if self.ready == 0 {
                // Where no frame of the lowest rate was made for so long, none will be a neighbour of these.
                self.held.retain(|(held, _)| (0..SLOWEST_INTERVAL).contains(&(stamp.tick - held.tick)));
            }
            self.held.push_back((stamp, tiles));
            self.leave(n, &mut frames);
        }
        Ok(frames)
    }

    /// A frame of the lowest rate.
    fn lowest(&mut self, n: usize, stamp: Stamp, tiles: &[CountedTile], frames: &mut Vec<SentFrame>) {
        if self.histories.len() != tiles.len() {
            self.histories = vec![History::default(); tiles.len()];
        }
        let depths = self.histories.iter().zip(tiles).map(|(past, tile)| past.depth(stamp.tick, tile.counts.len()));
        let depth = depths.min().unwrap_or(0);
        frames.extend(self.frames(n, stamp, tiles, depth));
        if stamp.tick % TICKS_PER_SECOND == 0 {
            // For recordings, and for whoever has fallen behind.
            self.join();
        }
        let joining = self.joining;
        for less in (0..depth).rev().filter(|less| joining >> less & 1 == 1) {
            frames.extend(self.frames(n, stamp, tiles, less));
        }
        self.joining = self.joining << 1 & ((1 << MAX_DEPTH) - 1);
        self.keep(stamp.tick, tiles);
        // What lies between this one and the one before can leave from now on: halves before quarters.
        self.held.retain(|(held, _)| (0..SLOWEST_INTERVAL).contains(&(stamp.tick - held.tick)) && depth > 0);
        self.held.make_contiguous().sort_by_key(|(held, _)| (layer_of(held.tick), held.tick));
        self.ready = self.held.len();
    }

    /// The next frame that can leave, if there is one.
    fn leave(&mut self, n: usize, frames: &mut Vec<SentFrame>) {
        if self.ready == 0 {
            return;
        }
        self.ready -= 1;
        let Some((stamp, tiles)) = self.held.pop_front() else { return };
        // Where a neighbour was passed over there is nothing to predict from.
        let samples = tiles.iter().map(|tile| tile.tile.side.pow(2));
        let mut each = self.histories.iter().zip(samples);
        if each.all(|(history, samples)| history.basis(stamp.tick, BETWEEN, 0, samples).is_some()) {
            frames.extend(self.frames(n, stamp, &tiles, BETWEEN));
            self.keep(stamp.tick, &tiles);
        }
    }

    fn keep(&mut self, tick: i64, tiles: &[CountedTile]) {
        for (history, tile) in self.histories.iter_mut().zip(tiles) {
            history.keep(tick, tile.counts.clone());
        }
    }

    fn frames(&mut self, n: usize, stamp: Stamp, tiles: &[CountedTile], depth: u8) -> Vec<SentFrame> {
        let Self { unit, histories, residuals, .. } = self;
        let unit = *unit;
        let none = History::default();
        let frame = |(i, tile): (usize, &CountedTile)| {
            let mut bytes = vec![0; HEADER_BYTES];
            match unit.codec {
                Codec::Rans | Codec::Deflate => {
                    let history = histories.get(i).unwrap_or(&none);
                    let side = tile.tile.side;
                    let basis = |channel| history.basis(stamp.tick, depth, channel, side * side).expect("it is held");
                    match unit.codec {
                        Codec::Rans => write_rans(&tile.counts, side, basis, residuals, &mut bytes),
                        _ => write_deflate(&tile.counts, side, basis, &mut bytes),
                    }
                }
                _ => bytes.extend(tile.counts.iter().flat_map(|count| count.to_le_bytes())),
            }
            let look = Look {
                step: quantiser_step(unit.class, unit.group),
                max_error: [unit.class.max_error(unit.group); 3],
                flags: if tile.saturated { FLAG_SATURATED } else { 0 },
                depth,
            };
            SentFrame { unit, tick: stamp.tick, depth, bytes: seal(unit, n, stamp, tile.tile, look, bytes) }
        };
        tiles.iter().enumerate().map(frame).collect()
    }

    fn floats(&self, n: usize, planes: &[Plane], stamp: Stamp) -> Result<Vec<SentFrame>, EncodeError> {
        let samples = planes.iter().map(|plane| match plane {
            Plane::Samples(samples) => *samples,
            Plane::Counts(..) => panic!("floats are made of samples"),
        });
        let planes: Vec<&[f32]> = samples.collect();
        let frame = |tile: Tile| {
            let (payload, max_error) = float_payload(self.unit, n, &planes, tile)?;
            let mut bytes = vec![0; HEADER_BYTES];
            bytes.extend(payload);
            let look = Look { step: 1.0, max_error, flags: 0, depth: 0 };
            let bytes = seal(self.unit, n, stamp, tile, look, bytes);
            Ok(SentFrame { unit: self.unit, tick: stamp.tick, depth: 0, bytes })
        };
        tiles_of(self.unit, n).map(frame).collect()
    }
}

/// Taps and coded residuals of all channels.
fn write_rans<'a>(
    counts: &[i16],
    n: usize,
    basis: impl Fn(usize) -> Basis<'a>,
    residuals: &mut Residuals,
    bytes: &mut Vec<u8>,
) {
    for (channel, counts) in counts.chunks_exact(n * n).enumerate() {
        let basis = basis(channel);
        let taps = fit(counts, basis, n);
        write_taps(taps, false, bytes);
        residuals.take(counts, basis, taps, n);
        rans::encode(residuals, bytes);
    }
}

/// Taps of all channels, then all their residuals in one deflate stream.
fn write_deflate<'a>(counts: &[i16], n: usize, basis: impl Fn(usize) -> Basis<'a>, bytes: &mut Vec<u8>) {
    let mut residuals = Vec::with_capacity(counts.len());
    for (channel, counts) in counts.chunks_exact(n * n).enumerate() {
        let basis = basis(channel);
        // In space the taps of this coding are fixed.
        let taps = if let Basis::Space = basis { Taps::default() } else { fit(counts, basis, n) };
        let wide = residual_bytes(counts, basis, taps, n, &mut residuals);
        write_taps(taps, wide, bytes);
    }
    deflate(&residuals, bytes);
}

fn write_taps(taps: Taps, wide: bool, bytes: &mut Vec<u8>) {
    taps.0.iter().for_each(|tap| bytes.extend(tap.to_le_bytes()));
    bytes.extend([u8::from(wide), 0, 0, 0]);
}

/// What a header says of samples.
struct Look {
    step: f32,
    max_error: [f32; 3],
    flags: u8,
    depth: u8,
}

/// Writes the header over the front of `bytes`, whose rest is the payload.
fn seal(unit: UnitName, n: usize, stamp: Stamp, tile: Tile, look: Look, mut bytes: Vec<u8>) -> Bytes {
    let channels = unit.group.channels().len();
    let header = FrameHeader {
        magic: MAGIC,
        header_bytes: HEADER_BYTES as u16,
        cascade: unit.cascade,
        level: unit.level,
        class: unit.class.id(),
        group: unit.group.id(),
        codec: unit.codec.id(),
        flags: look.flags | if look.depth == 0 { FLAG_KEY } else { 0 },
        n: tile.side as u16,
        level_n: (n >> unit.level) as u16,
        tile_x: tile.x as u16,
        tile_z: tile.z as u16,
        channels: channels as u16,
        depth: look.depth,
        zero_a: 0,
        tick: stamp.tick as u64,
        epoch: stamp.epoch,
        sequence: stamp.sequence,
        layout: stamp.layout,
        payload_bytes: (bytes.len() - HEADER_BYTES) as u32,
        step: std::array::from_fn(|i| if i < channels { look.step } else { 0.0 }),
        max_error: std::array::from_fn(|i| if i < channels { look.max_error[i] } else { 0.0 }),
        crc: 0,
        zero_b: 0,
    };
    header.seal(&mut bytes);
    Bytes::from(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{ErrorClass, Group};

    #[test]
    fn what_waits_for_a_neighbour_that_never_comes_is_let_go() {
        let (class, group) = (ErrorClass::Millimetre, Group::Height);
        let mut encoder = UnitEncoder::new(UnitName { cascade: 0, level: 0, class, group, codec: Codec::Rans });
        let (still, spoilt) = (vec![0.0; 64], vec![f32::NAN; 64]);
        for tick in (0..48_000).step_by(120) {
            // Each frame of the lowest rate is refused, those between are not.
            let plane = if layer_of(tick) == 0 { &spoilt } else { &still };
            let taken = encoder.take(8, &[Plane::Samples(plane)], Stamp { tick, epoch: 1, sequence: 0, layout: 0 });
            assert!(taken.is_err() || taken.is_ok_and(|frames| frames.is_empty()));
            assert!(encoder.held.len() <= 4, "{} at tick {tick}", encoder.held.len());
        }
    }
}
