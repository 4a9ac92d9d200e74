//! What the water is between frames: a small ring of decoded frames for each tile, interpolated at any server time.
//!
//! Invariant: bounded. At most [`RING`] frames a tile, only tiles of what was subscribed, and no more of that than
//! [`MAX_SAMPLES`], whatever the server says its patches are.

use std::collections::BTreeMap;

use crate::tile::{DecodedFrame, lagrange};
use crate::wire::{FrameHeader, Hello, HelloCascade, REST_TICKS, TICKS_PER_SECOND, TILE, UnitName};

/// Frames held of one tile: at 60 Hz the server is 14 ahead, and interpolation needs two behind.
pub const RING: usize = 20;
/// Most samples of one moment, all units together: nine channels of three patches of 1024 x 1024 fit.
pub const MAX_SAMPLES: u64 = 1 << 25;

/// Which tile of what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileKey {
    /// Number of the cascade.
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
    /// From another timeline.
    #[error("frame of another epoch")]
    OtherEpoch,
    /// For a tick at which its cascade is no part of the sea.
    #[error("frame of cascade {cascade} at tick {tick}, when it is no part of the sea")]
    Outside {
        /// Its cascade.
        cascade: u8,
        /// Its tick.
        tick: u64,
    },
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
    /// Cascades that `hello` names, by number.
    cascades: BTreeMap<u8, HelloCascade>,
    /// Samples a side that each subscribed (cascade, group) has at the level at which it comes.
    sizes: BTreeMap<(u8, u8), u32>,
    /// The level that was granted; a server may send a coarser one.
    levels: BTreeMap<(u8, u8), u8>,
    tiles: BTreeMap<TileKey, BTreeMap<u64, DecodedFrame>>,
}

impl Playback {
    /// A playback of these units of the sea that `hello` describes. Left out are units of cascades that it doesn't name
    /// and those that no longer fit [`MAX_SAMPLES`].
    pub fn new(hello: &Hello, units: &[UnitName]) -> Self {
        let (mut sizes, mut levels, mut total) = (BTreeMap::new(), BTreeMap::new(), 0u64);
        let cascades: BTreeMap<u8, HelloCascade> =
            hello.layout.cascades.iter().map(|cascade| (cascade.index, cascade.clone())).collect();
        for unit in units {
            let cascade = cascades.get(&unit.cascade);
            let n = cascade.and_then(|c| c.n.checked_shr(u32::from(unit.level))).unwrap_or_default();
            let samples = u64::from(n).pow(2).saturating_mul(unit.group.channels().len() as u64);
            if n > 0 && total.saturating_add(samples) <= MAX_SAMPLES {
                total += samples;
                sizes.insert((unit.cascade, unit.group.id()), n);
                levels.insert((unit.cascade, unit.group.id()), unit.level);
            }
        }
        let epoch = u64::from_str_radix(&hello.epoch, 16).unwrap_or_default();
        Self { epoch, cascades, sizes, levels, tiles: BTreeMap::new() }
    }

    /// A playback of these units after a further `hello`: what is held of cascades that go on at the same level stays.
    pub fn renewed(self, hello: &Hello, units: &[UnitName]) -> Self {
        let mut next = Self::new(hello, units);
        if next.epoch != self.epoch {
            return next;
        }
        let begun = |playback: &Self, key: &TileKey| {
            let cascade = playback.cascades.get(&key.cascade).map(|cascade| (cascade.from_tick, cascade.n));
            cascade.zip(playback.sizes.get(&(key.cascade, key.group)).copied())
        };
        for (key, ring) in &self.tiles {
            if begun(&self, key).is_some() && begun(&self, key) == begun(&next, key) {
                next.tiles.insert(*key, ring.clone());
            }
        }
        next
    }

    /// Keeps a frame. A frame held already is replaced; one older than a full ring is dropped.
    ///
    /// # Errors
    /// [`StrayFrame`] when it is not of this subscription.
    pub fn insert(&mut self, tile: DecodedFrame) -> Result<(), StrayFrame> {
        let h = &tile.header;
        if h.epoch != self.epoch {
            return Err(StrayFrame::OtherEpoch);
        }
        let there = |cascade: &HelloCascade| i64::try_from(h.tick).is_ok_and(|tick| cascade.contains(tick));
        if self.cascades.get(&h.cascade).is_some_and(|cascade| !there(cascade)) {
            return Err(StrayFrame::Outside { cascade: h.cascade, tick: h.tick });
        }
        let key = TileKey::from(h);
        if !self.is_asked(h) || h.n != h.level_n.min(TILE as u16) {
            return Err(StrayFrame::Unasked { cascade: h.cascade, group: h.group, level_n: h.level_n });
        }
        let ring = self.tiles.entry(key).or_default();
        ring.insert(h.tick, tile);
        if ring.len() > RING {
            ring.pop_first();
        }
        Ok(())
    }

    /// Whether a frame is of a unit that was granted; where its level is another than that of those before it, they are
    /// let go.
    fn is_asked(&mut self, h: &FrameHeader) -> bool {
        let of = (h.cascade, h.group);
        let (Some(size), Some(level)) = (self.sizes.get_mut(&of), self.levels.get(&of)) else { return false };
        if *size == u32::from(h.level_n) {
            return true;
        }
        let whole = self.cascades.get(&h.cascade).map_or(0, |cascade| cascade.n);
        if h.level < *level || whole.checked_shr(h.level.into()) != Some(u32::from(h.level_n)) {
            return false;
        }
        *size = h.level_n.into();
        self.tiles.retain(|key, _| (key.cascade, key.group) != of);
        true
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
    /// frame or no such channel, and when the cascade is no part of the sea: then it counts as nothing.
    ///
    /// Four-point Lagrange through the two frames before and the two after; through fewer where there are fewer.
    pub fn sample(&self, key: TileKey, channel: usize, server_us: i64, out: &mut Vec<f32>) -> Option<Footing> {
        let (nodes, footing) = self.nodes(key, server_us)?;
        let weights = lagrange(&nodes.iter().map(|(from_now, _)| *from_now).collect::<Vec<_>>());
        let weights: Vec<f32> = weights.into_iter().map(|weight| weight as f32).collect();
        let planes: Vec<&[f32]> =
            nodes.iter().map(|(_, tile)| tile.planes.get(channel).map_or(&[][..], Vec::as_slice)).collect();
        if planes.iter().any(|plane| plane.is_empty() || plane.len() != planes[0].len()) {
            return None;
        }
        out.clear();
        out.extend(planes[0].iter().map(|value| value * weights[0]));
        for (plane, weight) in planes.iter().zip(&weights).skip(1) {
            out.iter_mut().zip(*plane).for_each(|(sum, value)| *sum += value * weight);
        }
        Some(footing)
    }

    /// Whether a tile has frames on both sides of a server time; `None` when it has none at all, or needs none.
    pub fn footing(&self, key: TileKey, server_us: i64) -> Option<Footing> {
        Some(self.nodes(key, server_us)?.1)
    }

    /// Forgets every frame that no sample at `server_us` or later needs.
    pub fn forget_before(&mut self, server_us: i64) {
        let Ok(now) = u64::try_from(ticks_of_us(server_us).floor() as i64) else { return };
        let over = |number: u8| {
            let until = self.cascades.get(&number).and_then(|cascade| cascade.until_tick);
            until.is_some_and(|until| until <= now as i64)
        };
        self.tiles.retain(|key, _| !over(key.cascade));
        for ring in self.tiles.values_mut() {
            if let Some(second) = ring.range(..=now).rev().nth(1).map(|(tick, _)| *tick) {
                *ring = ring.split_off(&second);
            }
        }
    }

    /// The frames that a sample at a server time goes through, each with its ticks from then.
    fn nodes(&self, key: TileKey, server_us: i64) -> Option<(Vec<(f64, &DecodedFrame)>, Footing)> {
        let ring = self.tiles.get(&key)?;
        let now = ticks_of_us(server_us);
        let passed = now.floor().max(-1.0) as i64;
        let until = self.cascades.get(&key.cascade).and_then(|cascade| cascade.until_tick);
        let from = self.cascades.get(&key.cascade).map_or(0, |cascade| cascade.from_tick);
        // A sea that began at tick 0 has nothing before it that could be another.
        if (from > 0 && now < from as f64) || until.is_some_and(|until| now >= until as f64) {
            return None;
        }
        // The last frames before a cascade ends are zero: there is nothing to wait for.
        let rests = |tick: u64| until.is_some_and(|until| tick as i64 >= until.saturating_sub(REST_TICKS));
        // Nearest first.
        let before: Vec<_> = u64::try_from(passed).into_iter().flat_map(|t| ring.range(..=t).rev().take(2)).collect();
        let after: Vec<_> = ring.range(u64::try_from(passed + 1).unwrap_or(0)..).take(2).collect();
        let on_frame = before.first().is_some_and(|(tick, _)| **tick as f64 == now);
        let (nodes, footing) = match (before.first(), after.first()) {
            (Some(nearest), _) if on_frame => (vec![*nearest], Footing::Between),
            (Some(_), Some(_)) => (before.into_iter().rev().chain(after).collect(), Footing::Between),
            (Some(nearest), None) if rests(*nearest.0) => (vec![*nearest], Footing::Between),
            (Some(nearest), None) | (None, Some(nearest)) => (vec![*nearest], Footing::Starved),
            (None, None) => return None,
        };
        Some((nodes.into_iter().map(|(tick, tile)| (*tick as f64 - now, tile)).collect(), footing))
    }
}

/// Server time in ticks. 64 bits of microseconds would lose their last digits in one product: whole seconds apart.
fn ticks_of_us(us: i64) -> f64 {
    let (seconds, rest) = (us.div_euclid(1_000_000), us.rem_euclid(1_000_000));
    seconds as f64 * TICKS_PER_SECOND as f64 + rest as f64 * (TICKS_PER_SECOND as f64 / 1e6)
}
