//! The tiles that a level of detail is cut into, and averages for the one field that is no sum of waves.

use crate::wire::TILE;

/// Tiles along a side of a level with `n` samples a side.
pub fn tiles_per_side(n: usize) -> usize {
    n.div_ceil(TILE)
}

/// Row `row` of a tile, out of a plane of `n` x `n`.
pub fn row_of<T>(plane: &[T], n: usize, tile: Tile, row: usize) -> &[T] {
    &plane[(tile.z * tile.side + row) * n + tile.x * tile.side..][..tile.side]
}

/// Row `row` of a tile of averages around every `stride`-th sample of a plane of `n` x `n`: for foam, whose edges are no
/// band-limited waves. Weights fall linearly to nothing at the neighbouring samples, so the averages add up to the whole.
pub fn averages(plane: &[f32], n: usize, stride: usize, tile: Tile, row: usize) -> impl Iterator<Item = f32> {
    let reach = stride as isize;
    let weight = move |d: isize| (reach - d.abs()) as f32 / (reach * reach) as f32;
    let at = move |centre: usize, d: isize| (centre as isize + d).rem_euclid(n as isize) as usize;
    let z = (tile.z * tile.side + row) * stride;
    let average = move |x: usize| {
        let along =
            |dz: isize| -> f32 { (1 - reach..reach).map(|dx| weight(dx) * plane[at(z, dz) * n + at(x, dx)]).sum() };
        (1 - reach..reach).map(|dz| weight(dz) * along(dz)).sum::<f32>().min(1.0)
    };
    (tile.x * tile.side..(tile.x + 1) * tile.side).map(move |x| average(x * stride))
}

/// A square window of a level.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// Samples a side.
    pub side: usize,
    /// Position in tiles.
    pub x: usize,
    /// Position in tiles.
    pub z: usize,
}
