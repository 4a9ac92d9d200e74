//! Bicubic samples of a surface at any rest position, all cascades summed.
//!
//! Points are reduced to a patch in f64, so that a point a million kilometres away is as good as one at the origin;
//! weights and sums are f32, like the samples.

use glam::Vec4;

use crate::backend::{CascadeSurface, Surface};
use crate::plan::{Field, FieldSet};
use crate::sea::Displacement;

/// How much more the outer two samples weigh than in the cubic through all four (Lagrange). 1 is best for long waves
/// alone; over a sea's waves down to six samples a wave, where bands end by default, this errs half as much.
const OUTER: f32 = 1.1;

/// Weights of four samples around a point, at -1, 0, 1 and 2, as polynomials in the way t from the second to the third.
/// They sum to 1, and reproduce a plane.
const KERNEL: [Vec4; 4] = [
    Vec4::new(0.0, 1.0, 0.0, 0.0),
    Vec4::new(-OUTER / 3.0, OUTER / 2.0 - 1.0, 1.0, -OUTER / 6.0),
    Vec4::new(OUTER / 2.0, -OUTER, OUTER / 2.0, 0.0),
    Vec4::new(-OUTER / 6.0, OUTER / 2.0, -OUTER / 2.0, OUTER / 6.0),
];

/// A surface that can be asked for its fields between the samples.
pub struct Sampler<'a> {
    grids: Vec<Grid<'a>>,
}

struct Grid<'a> {
    surface: &'a CascadeSurface,
    n: usize,
    /// Samples a metre.
    per_m: f64,
    dx: &'a [f32],
    dz: &'a [f32],
}

/// The 4 x 4 samples around a point of one grid.
#[derive(Clone, Copy)]
struct Taps {
    /// The first of the four columns.
    column: u32,
    /// Where the four rows begin.
    rows: [u32; 4],
    /// Ways from the second sample to the third, along x and z.
    tx: f32,
    tz: f32,
}

/// Mean square of what is lost of a wave that is read between its samples, as a share of the wave's own: by its phase from
/// one sample to the next, radians along x and z.
pub fn lost_between(phase: [f64; 2]) -> f64 {
    const PLACES: usize = 8;
    // What is read along one axis over what there is: real and imaginary part, and the square, in the mean over places.
    let read = |phase: f64| {
        let mut mean = [0.0; 3];
        for place in 0..PLACES {
            let t = (place as f64 + 0.5) / PLACES as f64;
            let (mut re, mut im) = (0.0, 0.0);
            for (weight, at) in weights(t as f32).to_array().into_iter().zip([-1.0, 0.0, 1.0, 2.0]) {
                let angle = phase * (at - t);
                re += f64::from(weight) * libm::cos(angle);
                im += f64::from(weight) * libm::sin(angle);
            }
            mean.iter_mut().zip([re, im, re * re + im * im]).for_each(|(mean, part)| *mean += part / PLACES as f64);
        }
        mean
    };
    let [[xr, xi, xx], [zr, zi, zz]] = phase.map(read);
    1.0 - 2.0 * (xr * zr - xi * zi) + xx * zz
}

impl<'a> Sampler<'a> {
    /// Of a surface's full grids; `patches_m` are the sides of its patches, metres, in the order of its cascades. A
    /// cascade without fields counts as still water.
    pub fn new(surface: &'a Surface, patches_m: impl IntoIterator<Item = f64>) -> Self {
        let grid = |(surface, patch_m): (&'a CascadeSurface, f64)| {
            let plane = |field| surface.plane(field).unwrap_or_default();
            let (n, dx, dz) = (surface.n, plane(Field::Dx), plane(Field::Dz));
            let made = Field::ALL.into_iter().any(|field| surface.plane(field).is_some());
            made.then_some(Grid { surface, n, per_m: n as f64 / patch_m, dx, dz })
        };
        Self { grids: surface.cascades.iter().zip(patches_m).filter_map(grid).collect() }
    }

    /// Horizontal displacement of the particle that rests at a point (x, z), metres, and its derivatives: those of what
    /// lies between the samples, so that a search on it arrives.
    pub fn displacement(&self, at: [f64; 2]) -> Displacement {
        let (mut x, mut z) = ([Vec4::ZERO; 3], [Vec4::ZERO; 3]);
        for grid in self.grids.iter().filter(|grid| !grid.dx.is_empty() && !grid.dz.is_empty()) {
            let taps = grid.taps(at);
            let (wx, wz) = (weights(taps.tx), weights(taps.tz).to_array());
            let per_m = grid.per_m as f32;
            let (sx, sz) = (slopes(taps.tx) * per_m, (slopes(taps.tz) * per_m).to_array());
            for (sums, plane) in [(&mut x, grid.dx), (&mut z, grid.dz)] {
                let (mut value, mut along_z) = (Vec4::ZERO, Vec4::ZERO);
                for i in 0..4 {
                    let row = grid.row(plane, taps.rows[i], taps.column);
                    value += row * wz[i];
                    along_z += row * sz[i];
                }
                sums[0] += value * wx;
                sums[1] += value * sx;
                sums[2] += along_z * wx;
            }
        }
        let [dx, dxx, dxz] = x.map(|sum| f64::from(sum.element_sum()));
        let [dz, dzx, dzz] = z.map(|sum| f64::from(sum.element_sum()));
        Displacement { dx, dz, dxx, dzz, dxz, dzx }
    }

    /// Fields of the particles that rest at these points (x, z), metres: by [`Field`], as many as there are points;
    /// empty where not wanted, and zero where the surface doesn't have one.
    pub fn fields(&self, at: &[[f64; 2]], wanted: FieldSet) -> [Vec<f32>; Field::ALL.len()] {
        let mut sums = Field::ALL.map(|field| vec![0.0; if wanted.contains(field) { at.len() } else { 0 }]);
        let mut taps = Vec::with_capacity(at.len());
        // A plane at a time, so that its samples stay near the processor while all points read them.
        for grid in &self.grids {
            taps.clear();
            taps.extend(at.iter().map(|at| grid.taps(*at)));
            for field in wanted.iter() {
                let Some(plane) = grid.surface.plane(field) else { continue };
                for (sum, taps) in sums[field as usize].iter_mut().zip(&taps) {
                    *sum += grid.sample(plane, taps);
                }
            }
        }
        sums
    }
}

impl Grid<'_> {
    fn taps(&self, [x, z]: [f64; 2]) -> Taps {
        let ((x, tx), (z, tz)) = (split(x * self.per_m), split(z * self.per_m));
        let wrap = |sample: i64| (sample & (self.n as i64 - 1)) as u32;
        let rows = [-1, 0, 1, 2].map(|row| wrap(z.wrapping_add(row)) * self.n as u32);
        Taps { column: wrap(x.wrapping_sub(1)), rows, tx, tz }
    }

    #[inline]
    fn sample(&self, plane: &[f32], taps: &Taps) -> f32 {
        let wz = weights(taps.tz).to_array();
        let row = |i: usize| self.row(plane, taps.rows[i], taps.column) * wz[i];
        (row(0) + row(1) + row(2) + row(3)).dot(weights(taps.tx))
    }

    /// Four samples of a row, from a column on, around the edge if need be.
    #[inline]
    fn row(&self, plane: &[f32], row: u32, column: u32) -> Vec4 {
        let (row, column) = (row as usize, column as usize);
        if column + 4 <= self.n {
            return Vec4::from_slice(&plane[row + column..row + column + 4]);
        }
        let at = |i: usize| plane[row + ((column + i) & (self.n - 1))];
        Vec4::new(at(0), at(1), at(2), at(3))
    }
}

/// The whole number below, and the rest.
#[inline]
fn split(value: f64) -> (i64, f32) {
    let toward_zero = value as i64;
    let below = toward_zero.saturating_sub(i64::from(value < toward_zero as f64));
    (below, (value - below as f64) as f32)
}

#[inline]
fn weights(t: f32) -> Vec4 {
    ((KERNEL[3] * t + KERNEL[2]) * t + KERNEL[1]) * t + KERNEL[0]
}

/// Their derivatives.
#[inline]
fn slopes(t: f32) -> Vec4 {
    (KERNEL[3] * (3.0 * t) + KERNEL[2] * 2.0) * t + KERNEL[1]
}
