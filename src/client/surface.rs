//! The whole water at one moment: the patches of all cascades, joined from their tiles, and their sum at any point.

use std::collections::BTreeMap;

use super::playback::{Playback, TileKey};
use crate::wire::{Group, HelloLayout, TILE};

/// A cascade whose planes were joined; a channel that never came is zero everywhere.
#[derive(Clone, Debug)]
pub struct Patch {
    patch_m: f64,
    /// By the wire's number of the group: samples a side, and its planes.
    groups: BTreeMap<u8, (usize, Vec<Vec<f32>>)>,
}

/// The water at one undisplaced point, summed over cascades.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// `dx`, `height`, `dz`, metres.
    pub displacement: [f32; 3],
    /// `slope_x`, `slope_z`.
    pub slopes: [f32; 2],
    /// `dxx`, `dzz`, `dxz`.
    pub derivatives: [f32; 3],
    /// 0 to 1.
    pub foam: f32,
}

impl Patch {
    /// The patches of every cascade at a server time, microseconds since tick 0. One that is no part of the sea then,
    /// or of which there is no frame yet, is flat.
    pub fn all(playback: &Playback, layout: &HelloLayout, server_us: i64) -> Vec<Self> {
        let empty = |cascade: &crate::wire::HelloCascade| Self { patch_m: cascade.patch_m, groups: BTreeMap::new() };
        let mut patches: Vec<Self> = layout.cascades.iter().map(empty).collect();
        let mut plane = Vec::new();
        for key in playback.keys() {
            let place = layout.cascades.iter().position(|cascade| cascade.index == key.cascade);
            let (Some(patch), Some(group)) = (place.map(|at| &mut patches[at]), Group::from_id(key.group)) else {
                continue;
            };
            let n = playback.level_n(key) as usize;
            let channels = group.channels().len();
            let (_, planes) = patch.groups.entry(key.group).or_insert_with(|| (n, vec![vec![0.0; n * n]; channels]));
            for (channel, joined) in planes.iter_mut().enumerate() {
                if playback.sample(key, channel, server_us, &mut plane).is_some() {
                    join(joined, n, key, &plane);
                }
            }
        }
        patches
    }

    /// A patch of known planes: `groups` as (group, samples a side, planes).
    pub fn of(patch_m: f64, groups: Vec<(Group, usize, Vec<Vec<f32>>)>) -> Self {
        Self { patch_m, groups: groups.into_iter().map(|(g, n, planes)| (g.id(), (n, planes))).collect() }
    }

    /// Adds this cascade at an undisplaced point to `sum`.
    pub fn add(&self, x: f64, z: f64, sum: &mut Point) {
        self.add_group(Group::Displacement, x, z, &mut sum.displacement);
        self.add_group(Group::Slopes, x, z, &mut sum.slopes);
        self.add_group(Group::Derivatives, x, z, &mut sum.derivatives);
        let mut foam = [0.0];
        self.add_group(Group::Foam, x, z, &mut foam);
        // Foam covers: two half covers leave a quarter bare.
        sum.foam = 1.0 - (1.0 - sum.foam) * (1.0 - foam[0].clamp(0.0, 1.0));
    }

    /// Adds the channels of one group, linear between the four samples around the point, the patch repeated for ever.
    pub fn add_group(&self, group: Group, x: f64, z: f64, sums: &mut [f32]) {
        let Some((n, planes)) = self.groups.get(&group.id()) else { return };
        let place = |metres: f64| {
            let at = (metres / self.patch_m).rem_euclid(1.0) * *n as f64;
            let index = at as usize % n;
            (index, (index + 1) % n, at.fract() as f32)
        };
        let ((x0, x1, fx), (z0, z1, fz)) = (place(x), place(z));
        for (sum, plane) in sums.iter_mut().zip(planes) {
            let row = |z: usize| plane[z * n + x0] * (1.0 - fx) + plane[z * n + x1] * fx;
            *sum += row(z0) * (1.0 - fz) + row(z1) * fz;
        }
    }
}

/// Copies a tile into its place in the plane of the whole patch.
fn join(plane: &mut [f32], level_n: usize, key: TileKey, tile: &[f32]) {
    let n = level_n.min(TILE);
    for (z, row) in tile.chunks_exact(n).enumerate() {
        let start = (usize::from(key.z) * n + z) * level_n + usize::from(key.x) * n;
        plane[start..start + n].copy_from_slice(row);
    }
}

impl Point {
    /// The sum of all patches at an undisplaced point.
    pub fn at(patches: &[Patch], x: f64, z: f64) -> Self {
        let mut sum = Self::default();
        patches.iter().for_each(|patch| patch.add(x, z, &mut sum));
        sum
    }

    /// The point seen from straight above at (x, z): the particle that was displaced to there. Three steps of the
    /// fixed point x0 = x - D(x0) leave centimetres where the surface doesn't fold.
    pub fn seen_at(patches: &[Patch], x: f64, z: f64) -> Self {
        let (mut x0, mut z0) = (x, z);
        for _ in 0..3 {
            let mut d = [0.0; 3];
            patches.iter().for_each(|patch| patch.add_group(Group::Displacement, x0, z0, &mut d));
            (x0, z0) = (x - f64::from(d[0]), z - f64::from(d[2]));
        }
        Self::at(patches, x0, z0)
    }

    /// The unit normal (PROTOCOL.md section 5).
    pub fn normal(&self) -> [f32; 3] {
        let ([hx, hz], [dxx, dzz, dxz]) = (self.slopes, self.derivatives);
        let n = [-(hx * (1.0 + dzz) - hz * dxz), (1.0 + dxx) * (1.0 + dzz) - dxz * dxz, -(hz * (1.0 + dxx) - hx * dxz)];
        let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
        if length > 0.0 { n.map(|c| c / length) } else { [0.0, 1.0, 0.0] }
    }
}
