//! What a client has of a unit: a surface encoded, decoded and put together again.

use crate::backend::CascadeSurface;
use crate::plan::fields_of;
use crate::tile::{Plane, Stamp, UnitEncoder, decode};
use crate::wire::{FrameHeader, Group, UnitName};

/// Planes of a unit's group, whole and `[z][x]`, after decoding; `None` where the surface has not all its fields.
pub fn received(surface: &CascadeSurface, unit: UnitName) -> Option<Vec<Vec<f32>>> {
    let planes = planes(surface, unit)?;
    // A tick of the lowest rate: frames of others would wait for their neighbours, and all decode to the same counts.
    let stamp = Stamp { tick: 0, epoch: 1, sequence: 0, layout: 0 };
    let frames = UnitEncoder::new(unit).take(surface.n, &planes, stamp).ok()?;
    let mut whole = vec![Vec::new(); planes.len()];
    for frame in frames {
        let decoded = decode(&frame.bytes).ok()?;
        for (tile, plane) in decoded.planes.iter().zip(&mut whole) {
            paste(tile, &decoded.header, plane);
        }
    }
    Some(whole)
}

/// The channels of a unit as a surface has them.
pub fn planes(surface: &CascadeSurface, unit: UnitName) -> Option<Vec<Plane<'_>>> {
    // Foam is made on the full grid, and averaged for the others.
    let level = if unit.group == Group::Foam { 0 } else { unit.level };
    fields_of(unit.group).iter().map(|field| surface.plane_at(level, *field).map(Plane::Samples)).collect()
}

/// Puts a tile into its place on the whole grid.
fn paste(tile: &[f32], header: &FrameHeader, plane: &mut Vec<f32>) {
    let (side, n) = (usize::from(header.n), usize::from(header.level_n));
    plane.resize(n * n, 0.0);
    let corner = usize::from(header.tile_z) * side * n + usize::from(header.tile_x) * side;
    for (z, row) in tile.chunks_exact(side).enumerate() {
        plane[corner + z * n..][..side].copy_from_slice(row);
    }
}
