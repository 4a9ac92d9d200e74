//! A frame back to numbers.

use std::collections::BTreeMap;

use thiserror::Error;

use super::deflate::{inflate, restore};
use super::floats::floats;
use super::history::{Counts, History};
use super::predict::Taps;
use super::rans::{Damaged, PlaneDecoder, read_taps};
use crate::wire::{Codec, ErrorClass, FrameError, FrameHeader, Group, UnitName, layer_of, split};

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
        unit_of(&self.header)
    }
}

/// The unit of a header that was read.
pub fn unit_of(header: &FrameHeader) -> UnitName {
    UnitName {
        cascade: header.cascade,
        level: header.level,
        class: ErrorClass::from_id(header.class).expect("checked when it was read"),
        group: Group::from_id(header.group).expect("checked when it was read"),
        codec: Codec::from_id(header.codec).expect("checked when it was read"),
    }
}

/// Why a frame gives no numbers.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DecodeError {
    /// It is no frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// It is predicted from a frame that is not held.
    #[error("predicted from a frame that is not held")]
    Missing,
    /// Its payload is none.
    #[error("payload: {0}")]
    Payload(&'static str),
}

impl From<Damaged> for DecodeError {
    fn from(damaged: Damaged) -> Self {
        Self::Payload(damaged.0)
    }
}

/// A tile of a unit.
type TileOf = (UnitName, u16, u16);

/// Decodes the frames of one connection in the order in which they came.
///
/// Invariant: bounded. What is kept for predictions is four frames of a tile, of no more samples in all than it was
/// made for.
#[derive(Debug, Default)]
pub struct Decoder {
    most_samples: usize,
    held: BTreeMap<TileOf, Held>,
    planes: PlaneDecoder,
}

#[derive(Debug)]
struct Held {
    history: History,
    samples: usize,
    epoch: u64,
}

impl Decoder {
    /// A decoder that keeps the recent frames of units with at most so many samples at one tick.
    pub fn new(most_samples: usize) -> Self {
        Self { most_samples, ..Self::default() }
    }

    /// Forgets the frames of units that are not wanted any more.
    pub fn retain(&mut self, wanted: impl Fn(&UnitName) -> bool) {
        self.held.retain(|(unit, ..), _| wanted(unit));
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// [`DecodeError`]; the frame is of no use then, and what was decoded before stands.
    pub fn decode(&mut self, frame: &[u8]) -> Result<DecodedFrame, DecodeError> {
        let (header, payload) = split(frame)?;
        let (unit, n) = (unit_of(&header), usize::from(header.n));
        let samples = n * n;
        if unit.codec.is_float() {
            let values = floats(unit.codec, payload);
            if values.iter().any(|value| !value.is_finite()) {
                return Err(DecodeError::Payload("a value that is not finite"));
            }
            return Ok(DecodedFrame { header, planes: values.chunks_exact(samples).map(<[f32]>::to_vec).collect() });
        }
        let channels = usize::from(header.channels);
        let counts: Counts = match unit.codec {
            Codec::Rans | Codec::Deflate => self.predicted(&header, unit, payload)?,
            _ => payload.as_chunks::<2>().0.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect(),
        };
        let plane = |(counts, step): (&[i16], f32)| counts.iter().map(|count| f32::from(*count) * step).collect();
        let planes = counts.chunks_exact(samples).zip(header.step).map(plane).collect();
        if unit.codec.predicts() && layer_of(header.tick as i64) < 2 {
            self.keep(&header, unit, counts, samples * channels);
        }
        Ok(DecodedFrame { header, planes })
    }

    fn predicted(&mut self, header: &FrameHeader, unit: UnitName, payload: &[u8]) -> Result<Counts, DecodeError> {
        let (n, channels, tick) = (usize::from(header.n), usize::from(header.channels), header.tick as i64);
        let samples = n * n;
        let none = History::default();
        let held = self.held.get(&(unit, header.tile_x, header.tile_z));
        let held = held.filter(|held| held.samples == samples * channels && held.epoch == header.epoch);
        let history = held.map_or(&none, |held| &held.history);
        let basis = |channel| history.basis(tick, header.depth, channel, samples).ok_or(DecodeError::Missing);
        let mut counts = vec![0i16; channels * samples];
        let mut left = payload;
        if unit.codec == Codec::Rans {
            for (channel, counts) in counts.chunks_exact_mut(samples).enumerate() {
                let (taps, wide) = read_taps(&mut left)?;
                if wide {
                    return Err(DecodeError::Payload("wide, which only deflate is"));
                }
                let used = self.planes.decode(left, basis(channel)?, taps, n, counts)?;
                left = &left[used..];
            }
            if !left.is_empty() {
                return Err(DecodeError::Payload("bytes after the last plane"));
            }
            return Ok(counts.into());
        }
        let taps: Vec<(Taps, bool)> = (0..channels).map(|_| read_taps(&mut left)).collect::<Result<_, _>>()?;
        if header.depth == 0 && taps.iter().any(|(taps, _)| *taps != Taps::default()) {
            return Err(DecodeError::Payload("taps where they are fixed"));
        }
        let planes = |wide: bool| samples * (1 + usize::from(wide));
        let size: usize = taps.iter().map(|(_, wide)| planes(*wide)).sum();
        let residuals = inflate(left, size)?;
        if residuals.len() != size {
            return Err(DecodeError::Payload("fewer residuals than samples"));
        }
        let mut left = residuals.as_slice();
        for (channel, ((taps, wide), counts)) in taps.into_iter().zip(counts.chunks_exact_mut(samples)).enumerate() {
            let (bytes, rest) = left.split_at(planes(wide));
            let (low, high) = bytes.split_at(samples);
            restore(low, wide.then_some(high), basis(channel)?, taps, n, counts);
            left = rest;
        }
        Ok(counts.into())
    }

    fn keep(&mut self, header: &FrameHeader, unit: UnitName, counts: Counts, samples: usize) {
        let key = (unit, header.tile_x, header.tile_z);
        let others = self.held.iter().filter(|(other, _)| **other != key).map(|(_, held)| held.samples);
        // More than was asked for: what comes of it can't be predicted from.
        if others.sum::<usize>() + samples > self.most_samples {
            self.held.remove(&key);
            return;
        }
        let new = || Held { history: History::default(), samples, epoch: header.epoch };
        let held = self.held.entry(key).or_insert_with(new);
        if held.samples != samples || held.epoch != header.epoch {
            *held = new();
        }
        held.history.keep(header.tick as i64, counts);
    }
}

/// Reads a frame that stands by itself.
///
/// # Errors
/// [`DecodeError`] for bytes that are no frame, or for one that is predicted from others.
pub fn decode(frame: &[u8]) -> Result<DecodedFrame, DecodeError> {
    Decoder::default().decode(frame)
}
