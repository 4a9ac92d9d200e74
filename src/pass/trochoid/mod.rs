//! The second way to make a sea: the strongest waves of a cascade as trochoids, and gradient noise in place of the rest
//! (Thon, Dischler & Ghazanfarpour 2000, "Ocean waves synthesis using a spectrum-based turbulence function").
//!
//! The surface is a height over the world, evaluated where it is asked for: nothing is displaced sideways, and a point
//! needs no grid around it. Each wave is the surface that the orbits of a Gerstner wave make by themselves; heights and
//! slopes of waves are added in the world. What the sum of displacements has and this has not: long waves don't carry
//! short ones to and fro, so crests of the whole sea are as sharp as those of its waves and no sharper.
//!
//! Invariant: everything here is a function of (sea, tick, place), the same bits on any number of threads, and closes
//! with the repeat period.

mod noise;
mod profile;
mod wave;

use rayon::prelude::*;

use crate::pass::assemble;
use crate::plan::{Field, FieldSet};
use crate::sea::{CascadeModes, Octave, Sea, cos_sin as sea_cos_sin, kept_waves, turbulence, turn_of_tick};
use noise::{Moment, Noise};
use profile::Shape;
pub use profile::{Polynomial, Profile, Shape as ProfileShape, look_up, slope};
use wave::{
    HEIGHT, Lanes, SLOPE_X, SLOPE_Z, STRAIN_XX, STRAIN_XZ, STRAIN_ZZ, SUMS, VELOCITY_X, VELOCITY_Y, VELOCITY_Z, Wave,
};

/// Rows that one thread takes at a time.
const ROWS: usize = 4;
/// Share of the variance that one octave of noise may fold back from beyond a grid's Nyquist wavenumber ...
const FOLDED: f64 = 0.003;
/// ... and the share of its own from which on it fades, and is dropped.
const FADING: f64 = 0.2;
const DROPPED: f64 = 0.4;
/// Fields that the slopes give.
const SLOPES: FieldSet = FieldSet::of(&[Field::SlopeX, Field::SlopeZ, Field::NormalX, Field::NormalZ]);
/// Fields that the strain of the orbits gives.
const STRAINS: FieldSet = FieldSet::of(&[Field::Jacobian, Field::Eigenvalue]);

/// One cascade of a sea, ready to be evaluated at any tick and place.
#[derive(Debug)]
pub struct Trochoids {
    patch_m: f64,
    repeat: u64,
    waves: Vec<Wave>,
    octaves: Vec<Noise>,
}

/// A grid at a tick.
struct Grid<'a> {
    turn: u32,
    n: usize,
    /// x of every sample, in 2^-32 of the patch, eight at a time.
    xs: Vec<[u32; 8]>,
    /// Cosine and sine of whole waves along x, by how many in the patch.
    trig: Vec<Vec<(Lanes, Lanes)>>,
    waves: Vec<(&'a Wave, Shape<'a>)>,
    noise: Vec<noise::Field>,
}

impl Trochoids {
    /// Chooses the waves of a cascade and fits the noise to what they leave.
    pub fn new(modes: &CascadeModes, sea: &Sea) -> Self {
        let kept = kept_waves(modes, sea);
        let octaves = turbulence(modes, sea, &kept);
        let (patch_m, cascade) = (modes.cascade.patch_m, modes.cascade.index);
        let noise = |octave: Octave| Noise::new(octave, sea.seed, cascade, patch_m, sea.repeat, sea.drift.toward);
        Self {
            patch_m,
            repeat: sea.repeat,
            waves: kept.iter().map(|wave| Wave::new(wave, patch_m)).collect(),
            octaves: octaves.into_iter().map(noise).collect(),
        }
    }

    /// Fields of the whole patch on a grid of n x n samples at a tick: planes by `Field as usize`, each `[z][x]`, sized
    /// here for the fields asked for; the others, and foam, are left as they are.
    ///
    /// Heights over the points of the world: `Dx`, `Dz` and their derivatives are 0; `SlopeX` and `SlopeZ` are those of
    /// the surface in the world, and `NormalX` and `NormalZ` the same; velocities are those of the water at the surface;
    /// `Jacobian` and `Eigenvalue` are of the mapping of the orbits, whose squeezed water foams.
    ///
    /// What the grid can't show is not there: waves and harmonics beyond its Nyquist wavenumber, and octaves of noise
    /// that would fold back.
    ///
    /// # Panics
    /// If `n` is 0.
    pub fn fill(&self, tick: i64, n: usize, fields: FieldSet, planes: &mut [Vec<f32>; 16]) {
        let fields = fields.difference(FieldSet::of(&[Field::Foam]));
        for field in fields.iter() {
            planes[field as usize].resize(n * n, 0.0);
        }
        let grid = self.grid(tick, n);
        let wanted = |set: FieldSet| !fields.intersection(set).is_empty();
        if wanted(FieldSet::VELOCITY) {
            grid.fill::<SUMS>(fields, planes);
        } else if wanted(STRAINS) {
            grid.fill::<6>(fields, planes);
        } else if wanted(SLOPES) {
            grid.fill::<3>(fields, planes);
        } else {
            grid.fill::<1>(fields, planes);
        }
    }

    /// Every field at one point of the world, by `Field as usize`; foam is 0. What a footprint of that many metres can't
    /// show is left out, as on a grid of that spacing; 0 shows everything.
    pub fn at(&self, tick: i64, x: f64, z: f64, footprint_m: f64) -> [f32; 16] {
        self.points(tick, &[(x, z)], footprint_m)[0]
    }

    /// The same at many points (x, z).
    pub fn points(&self, tick: i64, points: &[(f64, f64)], footprint_m: f64) -> Vec<[f32; 16]> {
        let turn = turn_of_tick(tick, self.repeat);
        let samples = if footprint_m > 0.0 { self.patch_m / footprint_m } else { f64::INFINITY };
        let waves = self.shapes(samples);
        let noise = self.moments(turn, samples, &waves);
        let position = |metres: f64| ((metres / self.patch_m).rem_euclid(1.0) * 4_294_967_296.0) as u64 as u32;
        let eight = |points: &[(f64, f64)]| {
            let place = |j: usize| points[j.min(points.len() - 1)];
            let x: [u32; 8] = std::array::from_fn(|j| position(place(j).0));
            let z: [u32; 8] = std::array::from_fn(|j| position(place(j).1));
            let mut sum = [[[0.0; 8]; SUMS]];
            for (wave, shape) in &waves {
                let psi = std::array::from_fn(|j| wave.phase(turn, z[j]).wrapping_add(wave.n.wrapping_mul(x[j])));
                wave.add(shape, (1.0, 0.0), &[psi], &[cos_sin(&psi)], &mut sum);
            }
            noise.iter().for_each(|moment| moment.add_points(&x, &z, &mut sum[0]));
            let all = |j: usize| Field::ALL.map(|field| value(field, &sum[0])[j]);
            (0..points.len()).map(all).collect::<Vec<_>>()
        };
        points.par_chunks(8).flat_map_iter(eight).collect()
    }

    fn shapes(&self, samples: f64) -> Vec<(&Wave, Shape<'_>)> {
        let shown = self.waves.iter().map(|wave| (wave, wave.limit(samples))).filter(|(_, limit)| *limit > 0);
        shown.map(|(wave, limit)| (wave, wave.profile.shape(limit))).collect()
    }

    /// Octaves at a turn, each with as much of its amplitude as folds back no more than [`FOLDED`] of what is shown.
    fn moments(&self, turn: u32, samples: f64, waves: &[(&Wave, Shape)]) -> Vec<Moment> {
        let folded = |noise: &Noise| noise.octave.folded(samples);
        let shown = waves.iter().map(|(wave, _)| wave.variance).sum::<f64>()
            + self.octaves.iter().map(|noise| (1.0 - folded(noise)) * noise.octave.variance()).sum::<f64>();
        let share = |noise: &Noise| {
            let folded = folded(noise);
            let too_much = folded * noise.octave.variance() / (FOLDED * shown);
            let t = ((DROPPED - folded) / (DROPPED - FADING)).clamp(0.0, 1.0);
            t * libm::sqrt(1.0 / too_much.max(1.0))
        };
        let moments = self.octaves.iter().map(|noise| noise.at(turn, share(noise)));
        moments.filter(|moment| !moment.is_still()).collect()
    }

    fn grid(&self, tick: i64, n: usize) -> Grid<'_> {
        let turn = turn_of_tick(tick, self.repeat);
        let at = |i: usize| (((i as u64) << 32) / n as u64) as u32;
        let xs: Vec<[u32; 8]> = (0..n.div_ceil(8)).map(|i| std::array::from_fn(|j| at(i * 8 + j))).collect();
        let waves = self.shapes(n as f64);
        let most = waves.iter().map(|(wave, _)| wave.n).max().unwrap_or(0);
        let trig = |whole: u32| xs.iter().map(|xs| cos_sin(&xs.map(|x| x.wrapping_mul(whole)))).collect();
        let trig = (0..=most).into_par_iter().map(trig).collect();
        let noise = self.moments(turn, n as f64, &waves).into_par_iter().map(|moment| moment.field(&xs)).collect();
        Grid { turn, n, trig, waves, noise, xs }
    }
}

impl Grid<'_> {
    /// Summing the first `A` fields of waves and noise is enough for `fields`.
    fn fill<const A: usize>(&self, fields: FieldSet, planes: &mut [Vec<f32>; 16]) {
        let n = self.n;
        let mut parts = planes.each_mut().map(|plane| plane.chunks_mut(ROWS * n));
        let parts: Vec<(usize, [&mut [f32]; 16])> = (0..n.div_ceil(ROWS))
            .map(|part| {
                let rows = std::array::from_fn(|field| match fields.contains(Field::ALL[field]) {
                    true => parts[field].next().unwrap_or_default(),
                    false => <&mut [f32]>::default(),
                });
                (part * ROWS, rows)
            })
            .collect();
        let width = self.xs.len();
        let work = || (vec![[[0.0; 8]; A]; ROWS * width], Vec::new());
        parts.into_par_iter().for_each_init(work, |(sums, lines), (first, parts)| {
            let rows = ROWS.min(n - first);
            self.sum(first, &mut sums[..rows * width], lines);
            for field in fields.iter() {
                let rows = parts[field as usize].chunks_exact_mut(n).zip(sums.chunks_exact(width));
                for (row, sums) in rows {
                    for (samples, sum) in row.chunks_mut(8).zip(sums) {
                        samples.copy_from_slice(&value(field, sum)[..samples.len()]);
                    }
                }
            }
        });
    }

    /// Rows from `first` on: waves first, one after the other, then noise.
    fn sum<const A: usize>(&self, first: usize, sums: &mut [[Lanes; A]], lines: &mut Vec<[f32; 4]>) {
        sums.fill([[0.0; 8]; A]);
        let z = |row: usize| ((((first + row) as u64) << 32) / self.n as u64) as u32;
        let width = self.xs.len();
        let mut turns = Vec::new();
        for (wave, shape) in &self.waves {
            for (row, sums) in sums.chunks_exact_mut(width).enumerate() {
                let phase = wave.phase(self.turn, z(row));
                if matches!(shape, Shape::Table(_)) {
                    turns.clear();
                    turns.extend(self.xs.iter().map(|xs| xs.map(|x| phase.wrapping_add(wave.n.wrapping_mul(x)))));
                }
                wave.add(shape, sea_cos_sin(phase), &turns, &self.trig[wave.n as usize], sums);
            }
        }
        for octave in &self.noise {
            sums.chunks_exact_mut(width).enumerate().for_each(|(row, sums)| octave.add_row(z(row), lines, sums));
        }
    }
}

/// Cosines and sines of eight angles in 2^-32 of a turn.
fn cos_sin(turns: &[u32; 8]) -> (Lanes, Lanes) {
    let both = turns.map(sea_cos_sin);
    (both.map(|(cos, _)| cos), both.map(|(_, sin)| sin))
}

/// A field out of the sums.
fn value<const A: usize>(field: Field, sum: &[Lanes; A]) -> Lanes {
    let of = |which: usize| sum.get(which).copied().unwrap_or_default();
    let strain = |j: usize| [STRAIN_XX, STRAIN_ZZ, STRAIN_XZ].map(|which| of(which)[j]);
    match field {
        Field::Height => of(HEIGHT),
        Field::SlopeX | Field::NormalX => of(SLOPE_X),
        Field::SlopeZ | Field::NormalZ => of(SLOPE_Z),
        Field::VelocityX => of(VELOCITY_X),
        Field::VelocityY => of(VELOCITY_Y),
        Field::VelocityZ => of(VELOCITY_Z),
        Field::Jacobian => std::array::from_fn(|j| assemble::determinant(strain(j))),
        Field::Eigenvalue => std::array::from_fn(|j| assemble::smaller_eigenvalue(strain(j))),
        Field::Dx | Field::Dz | Field::Dxx | Field::Dzz | Field::Dxz | Field::Foam => [0.0; 8],
    }
}
