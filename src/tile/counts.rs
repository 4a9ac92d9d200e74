//! The tiles of a unit at one tick as counts: cut out of its planes, and quantised where they are not yet.

use thiserror::Error;

use super::history::Counts;
use super::level::{Tile, averages, row_of, tiles_per_side};
use crate::pass::quantise::{Found, quantise, quantiser_step};
use crate::wire::{Group, TILE, UnitName};

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

/// A tile of counts.
#[derive(Clone, Debug)]
pub struct CountedTile {
    /// Which.
    pub tile: Tile,
    /// All its channels.
    pub counts: Counts,
    /// Some sample was clamped.
    pub saturated: bool,
}

/// The tiles of a level of `n >> level` samples a side.
pub fn tiles_of(unit: UnitName, n: usize) -> impl Iterator<Item = Tile> {
    let level_n = n >> unit.level;
    let tiles = tiles_per_side(level_n);
    (0..tiles * tiles).map(move |i| Tile { side: level_n.min(TILE), x: i % tiles, z: i / tiles })
}

/// Counts of every tile of a unit. `n` is the side of the full grid; `planes` are the group's channels, `[z][x]`.
///
/// # Errors
/// [`EncodeError::NotFinite`].
///
/// # Panics
/// If there are fewer planes than the group has channels, or one is not of its grid.
pub fn counted_tiles(unit: UnitName, n: usize, planes: &[Plane]) -> Result<Vec<CountedTile>, EncodeError> {
    tiles_of(unit, n).map(|tile| counted_tile(unit, n, planes, tile)).collect()
}

fn counted_tile(unit: UnitName, n: usize, planes: &[Plane], tile: Tile) -> Result<CountedTile, EncodeError> {
    let channels = unit.group.channels();
    let mut counts = vec![0i16; channels.len() * tile.side * tile.side];
    let step = quantiser_step(unit.class, unit.group);
    let (stride, level_n) = (1 << unit.level, n >> unit.level);
    let mut saturated = false;
    for ((counts, plane), channel) in counts.chunks_exact_mut(tile.side * tile.side).zip(planes).zip(channels) {
        let mut found = Found::default();
        for (row, counts) in counts.chunks_exact_mut(tile.side).enumerate() {
            found = found.and(match (*plane, unit.group, stride) {
                (Plane::Counts(made, found), ..) => {
                    counts.copy_from_slice(row_of(made, level_n, tile, row));
                    // Found of the whole plane, told of the tiles that hold the largest count.
                    let clamped = found.saturated && counts.iter().any(|count| count.unsigned_abs() == 32767);
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
        saturated |= found.saturated;
    }
    Ok(CountedTile { tile, counts: counts.into(), saturated })
}
