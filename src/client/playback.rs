//! What the water is between frames: a small ring of decoded frames for each tile, interpolated at any server time.
//!
//! Invariant: bounded. At most [`RING`] frames a tile, and no more tiles than the subscription names.

use std::collections::BTreeMap;

use super::decode::Tile;
use crate::wire::{FrameHeader, Hello, TICKS_PER_SECOND, TILE, UnitName};

/// Frames held of one tile: at 60 Hz the server is 8 ahead, and interpolation needs two behind.
pub const RING: usize = 16;
/// Most tiles a playback holds, whatever was subscribed: 16 frames of 3 planes of 256 x 256 are 12 MiB a tile.
pub const MAX_TILES: usize = 64;

/// Which tile of what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileKey {
    /// Index of the cascade.
    pub cascade: u8,
    /// The wire's number of the group.
    pub group: u8,
    /// Position in the patch, counted in tiles.
    pub x: u16,
    /// Position in the patch, counted in tiles.
    pub z: u16,
}

impl From<&FrameHeader> for TileKey {
    fn from(h: &FrameHeader) -> Self {
        Self { cascade: h.cascade, group: h.group, x: h.tile_x, z: h.tile_z }
    }
}

/// Why a well-formed frame is of no use here.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StrayFrame {
    /// From another timeline or layout.
    #[error("frame of another {0}")]
    Other(&'static str),
    /// Of a unit or size that was not subscribed.
    #[error("frame of cascade {cascade}, group {group}, {level_n} samples a side: not subscribed")]
    Unasked {
        /// Its cascade.
        cascade: u8,
        /// Its group.
        group: u8,
        /// Samples a side of its patch.
        level_n: u16,
    },
}

/// How well a sample stands between frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Footing {
    /// Frames on both sides.
    Between,
    /// Later than every frame, or earlier: the nearest frame is held.
    Starved,
}

/// The recent frames of one subscription.
#[derive(Debug, Default)]
pub struct Playback {
    epoch: u64,
    layout: u32,
    /// Samples a side that each subscribed (cascade, group) has at its level.
    sizes: BTreeMap<(u8, u8), u32>,
    tiles: BTreeMap<TileKey, BTreeMap<u64, Tile>>,
}

impl Playback {
    /// A playback of these units of the sea that `hello` describes. Units of cascades it doesn't name are left out.
    pub fn new(hello: &Hello, units: &[UnitName]) -> Self {
        let size = |unit: &UnitName| {
            let cascade = hello.layout.cascades.get(usize::from(unit.cascade))?;
            let n = cascade.n.checked_shr(u32::from(unit.level))?;
            Some(((unit.cascade, unit.group.id()), n))
        };
        Self {
            epoch: u64::from_str_radix(&hello.epoch, 16).unwrap_or_default(),
            layout: hello.layout.generation,
            sizes: units.iter().filter_map(size).collect(),
            tiles: BTreeMap::new(),
        }
    }

    /// Keeps a frame. A frame held already is replaced; one older than a full ring is dropped.
    ///
    /// # Errors
    /// [`StrayFrame`] when it is not of this subscription.
    pub fn insert(&mut self, tile: Tile) -> Result<(), StrayFrame> {
        let h = &tile.header;
        if h.epoch != self.epoch {
            return Err(StrayFrame::Other("epoch"));
        }
        if h.layout != self.layout {
            return Err(StrayFrame::Other("layout"));
        }
        let key = TileKey::from(h);
        let asked = self.sizes.get(&(h.cascade, h.group)) == Some(&u32::from(h.level_n));
        let room = self.tiles.contains_key(&key) || self.tiles.len() < MAX_TILES;
        if !asked || !room || h.n != h.level_n.min(TILE as u16) {
            return Err(StrayFrame::Unasked { cascade: h.cascade, group: h.group, level_n: h.level_n });
        }
        let ring = self.tiles.entry(key).or_default();
        ring.insert(h.tick, tile);
        if ring.len() > RING {
            ring.pop_first();
        }
        Ok(())
    }

    /// Tiles of which there is a frame.
    pub fn keys(&self) -> impl Iterator<Item = TileKey> {
        self.tiles.keys().copied()
    }

    /// Samples a side of the patch that a tile is of.
    pub fn level_n(&self, key: TileKey) -> u32 {
        self.sizes.get(&(key.cascade, key.group)).copied().unwrap_or_default()
    }

    /// The ticks held of a tile, oldest first.
    pub fn ticks(&self, key: TileKey) -> impl Iterator<Item = u64> {
        self.tiles.get(&key).into_iter().flat_map(|ring| ring.keys().copied())
    }

    /// One channel of a tile at a server time (microseconds since tick 0), written over `out`. `None` when there is no
    /// frame or no such channel.
    ///
    /// Four-point Lagrange through the two frames before and the two after; through fewer where there are fewer.
    pub fn sample(&self, key: TileKey, channel: usize, server_us: i64, out: &mut Vec<f32>) -> Option<Footing> {
        let ring = self.tiles.get(&key)?;
        let now = ticks_of_us(server_us);
        let split_at = now.floor().max(-1.0) as i64;
        // Ticks at or before now, newest first, and after it.
        let before: Vec<_> = u64::try_from(split_at).ok().into_iter().flat_map(|t| ring.range(..=t).rev().take(2)).collect();
        let after: Vec<_> = ring.range(u64::try_from(split_at + 1).unwrap_or(0)..).take(2).collect();
        let on_frame = before.first().is_some_and(|(tick, _)| **tick as f64 == now);
        let between = on_frame || (!before.is_empty() && !after.is_empty());
        let nodes: Vec<_> = if on_frame || after.is_empty() {
            before[..1].to_vec()
        } else if before.is_empty() {
            after[..1].to_vec()
        } else {
            before.into_iter().rev().chain(after).collect()
        };
        let weights = lagrange(&nodes.iter().map(|(tick, _)| **tick as f64 - now).collect::<Vec<_>>());
        let planes: Vec<&[f32]> = nodes.iter().map(|(_, tile)| tile.plane(channel)).collect();
        if planes.iter().any(|plane| plane.is_empty() || plane.len() != planes[0].len()) {
            return None;
        }
        out.clear();
        out.extend(planes[0].iter().map(|value| value * weights[0]));
        for (plane, weight) in planes.iter().zip(&weights).skip(1) {
            out.iter_mut().zip(*plane).for_each(|(sum, value)| *sum += value * weight);
        }
        Some(if between { Footing::Between } else { Footing::Starved })
    }
}

/// Server time in ticks. 64 bits of microseconds would lose their last digits in one product: whole seconds apart.
fn ticks_of_us(us: i64) -> f64 {
    let (seconds, rest) = (us.div_euclid(1_000_000), us.rem_euclid(1_000_000));
    seconds as f64 * TICKS_PER_SECOND as f64 + rest as f64 * (TICKS_PER_SECOND as f64 / 1e6)
}

/// Weights of values at `nodes` (different, relative to now) of the polynomial through them, now.
fn lagrange(nodes: &[f64]) -> Vec<f32> {
    let weight = |i: usize| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, other)| other / (other - nodes[i])).product::<f64>() as f32
    };
    (0..nodes.len()).map(weight).collect()
}
