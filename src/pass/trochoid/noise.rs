//! Octaves of gradient noise at a tick, in f32: along rows of a grid, and at single points.

use std::sync::OnceLock;

use super::wave::{
    HEIGHT, Lanes, SLOPE_X, SLOPE_Z, STRAIN_XX, STRAIN_XZ, STRAIN_ZZ, VELOCITY_X, VELOCITY_Y, VELOCITY_Z,
};
use crate::sea::{Octave, cos_sin, lattice_direction};
use crate::wire::TICKS_PER_SECOND;

/// One octave as f32, with the factor of each of its fields.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    pub octave: Octave,
    seed: u64,
    cascade: u8,
    /// Cells per metre.
    density: f32,
    /// What a unit of height moves the water sideways, m/s by m.
    run: [f32; 2],
    /// Velocity of drift, m/s.
    drift: [f32; 2],
    /// What a unit of height strains along either axis.
    strain: f32,
}

/// An octave at a tick: where its lattice is, and how two draws of its vectors mix.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    noise: Noise,
    /// Factor on the unit noise, metres.
    amplitude: f32,
    offset: [u32; 2],
    keys: [u64; 2],
    /// Shares of both draws, their squares summing to 1.
    shares: [f32; 2],
}

/// An octave's lattice at a tick, and where the samples of a row lie in it.
#[derive(Debug)]
pub struct Field {
    moment: Moment,
    lattice: Vec<[f32; 2]>,
    columns: Vec<Place>,
}

/// A place in a lattice along one axis.
#[derive(Clone, Copy, Debug)]
struct Place {
    cell: u32,
    /// Share of the cell, 0 to 1.
    at: f32,
    /// Weight of the next lattice point, and its derivative.
    fade: f32,
    rate: f32,
}

impl Place {
    /// At a position in 2^-32 of the patch.
    fn new(position: u32, cells: u32) -> Self {
        let product = u64::from(position) * u64::from(cells);
        let t = product as u32 as f32 * (1.0 / 4_294_967_296.0);
        let fade = t * t * t * (10.0 - t * (15.0 - 6.0 * t));
        let rate = 30.0 * t * t * (1.0 - t) * (1.0 - t);
        Self { cell: (product >> 32) as u32, at: t, fade, rate }
    }
}

impl Noise {
    pub fn new(octave: Octave, seed: u64, cascade: u8, patch_m: f64, repeat: u64, toward: [f64; 2]) -> Self {
        let repeat_s = repeat as f64 / TICKS_PER_SECOND as f64;
        Self {
            octave,
            seed,
            cascade,
            density: (f64::from(octave.cells) / patch_m) as f32,
            run: toward.map(|toward| (octave.omega * octave.chop * toward) as f32),
            drift: octave.drift.map(|patches| (f64::from(patches) * patch_m / repeat_s) as f32),
            // Waves of all directions: half of k along either axis.
            strain: (-0.5 * octave.chop * octave.k) as f32,
        }
    }

    /// At a turn of the repeat period, with so much of its amplitude.
    pub fn at(&self, turn: u32, share: f64) -> Moment {
        let octave = &self.octave;
        let product = u64::from(turn) * u64::from(octave.changes);
        let (change, t) = ((product >> 32) as u32, product as u32 as f32 * (1.0 / 4_294_967_296.0));
        // One draw alone has nothing to become.
        let fade = if octave.changes == 1 { 0.0 } else { t * t * t * (10.0 - t * (15.0 - 6.0 * t)) };
        let level = 1.0 / ((1.0 - fade) * (1.0 - fade) + fade * fade).sqrt();
        let key = |change| octave.key(self.seed, self.cascade, change);
        Moment {
            noise: *self,
            amplitude: (octave.amplitude * share) as f32,
            offset: octave.drift.map(|patches| (patches as u32).wrapping_mul(turn)),
            keys: [key(change), key(if change + 1 >= octave.changes { 0 } else { change + 1 })],
            shares: [(1.0 - fade) * level, fade * level],
        }
    }
}

impl Moment {
    /// Whether there is nothing of it.
    pub fn is_still(&self) -> bool {
        self.amplitude == 0.0
    }

    fn vector(&self, directions: &[[f32; 2]; 256], x: u32, z: u32) -> [f32; 2] {
        let [a, b] = self.keys.map(|key| directions[usize::from(lattice_direction(key, x, z))]);
        [0, 1].map(|axis| self.shares[0] * a[axis] + self.shares[1] * b[axis])
    }

    /// For all rows of `columns` samples at x in 2^-32 of the patch.
    pub fn field(self, xs: &[[u32; 8]]) -> Field {
        let (cells, directions) = (self.noise.octave.cells, directions());
        let lattice = (0..cells).flat_map(|z| (0..cells).map(move |x| self.vector(directions, x, z))).collect();
        let place = |x: &u32| Place::new(x.wrapping_sub(self.offset[0]), cells);
        Field { moment: self, lattice, columns: xs.as_flattened().iter().map(place).collect() }
    }

    /// Adds it to eight points.
    pub fn add_points<const A: usize>(&self, x: &[u32; 8], z: &[u32; 8], sum: &mut [Lanes; A]) {
        let (cells, directions) = (self.noise.octave.cells, directions());
        let next = |cell: u32| if cell + 1 == cells { 0 } else { cell + 1 };
        let mut local = [[0.0; 8]; 3];
        for j in 0..8 {
            let across = Place::new(x[j].wrapping_sub(self.offset[0]), cells);
            let down = Place::new(z[j].wrapping_sub(self.offset[1]), cells);
            let line = |x: u32| {
                line(&down, self.vector(directions, x, down.cell), self.vector(directions, x, next(down.cell)))
            };
            between(&across, &line(across.cell), &line(next(across.cell)), j, &mut local);
        }
        self.add(&local, sum);
    }

    /// Every field out of the unit noise and its derivatives by x and z, in cells.
    #[inline(always)]
    fn add<const A: usize>(&self, [value, dx, dz]: &[Lanes; 3], sum: &mut [Lanes; A]) {
        let mut add = |field: usize, factor: f32, values: &Lanes| {
            sum[field] = std::array::from_fn(|j| sum[field][j] + factor * values[j]);
        };
        let (metres, noise) = (self.amplitude, &self.noise);
        let slope = metres * noise.density;
        add(HEIGHT, metres, value);
        if A > SLOPE_Z {
            add(SLOPE_X, slope, dx);
            add(SLOPE_Z, slope, dz);
        }
        if A > STRAIN_XZ {
            add(STRAIN_XX, metres * noise.strain, value);
            add(STRAIN_ZZ, metres * noise.strain, value);
        }
        if A > VELOCITY_Z {
            add(VELOCITY_X, metres * noise.run[0], value);
            // What drifts rises where it is steep ahead.
            add(VELOCITY_Y, -slope * noise.drift[0], dx);
            add(VELOCITY_Y, -slope * noise.drift[1], dz);
            add(VELOCITY_Z, metres * noise.run[1], value);
        }
    }
}

impl Field {
    /// Adds it to the row at z, in 2^-32 of the patch. `lines` is memory to work in.
    pub fn add_row<const A: usize>(&self, z: u32, lines: &mut Vec<[f32; 4]>, sums: &mut [[Lanes; A]]) {
        let cells = self.moment.noise.octave.cells as usize;
        let down = Place::new(z.wrapping_sub(self.moment.offset[1]), cells as u32);
        let above = &self.lattice[down.cell as usize * cells..][..cells];
        let below = &self.lattice[(down.cell as usize + 1) % cells * cells..][..cells];
        lines.clear();
        lines.extend(above.iter().zip(below).map(|(above, below)| line(&down, *above, *below)));
        lines.push(lines[0]);
        for (sum, places) in sums.iter_mut().zip(self.columns.chunks_exact(8)) {
            let mut local = [[0.0; 8]; 3];
            for (j, place) in places.iter().enumerate() {
                let cell = place.cell as usize;
                between(place, &lines[cell], &lines[cell + 1], j, &mut local);
            }
            self.moment.add(&local, sum);
        }
    }
}

/// Noise along z between two lattice points, as a + b of what lies along x, and the derivatives of both.
#[inline]
fn line(down: &Place, above: [f32; 2], below: [f32; 2]) -> [f32; 4] {
    let (b, v, dv) = (down.at, down.fade, down.rate);
    let (up, low) = (b * above[1], (b - 1.0) * below[1]);
    [
        above[0] + v * (below[0] - above[0]),
        up + v * (low - up),
        dv * (below[0] - above[0]),
        above[1] + v * (below[1] - above[1]) + dv * (low - up),
    ]
}

/// Noise between two lines, and its derivatives by x and z in cells, at one of eight places.
#[inline(always)]
fn between(across: &Place, left: &[f32; 4], right: &[f32; 4], j: usize, local: &mut [Lanes; 3]) {
    let (a, u, du) = (across.at, across.fade, across.rate);
    let (p, q) = (left[0] * a + left[1], right[0] * (a - 1.0) + right[1]);
    let (pz, qz) = (left[2] * a + left[3], right[2] * (a - 1.0) + right[3]);
    local[0][j] = p + u * (q - p);
    local[1][j] = du * (q - p) + left[0] + u * (right[0] - left[0]);
    local[2][j] = pz + u * (qz - pz);
}

/// The unit vectors that a lattice point may have.
fn directions() -> &'static [[f32; 2]; 256] {
    static DIRECTIONS: OnceLock<[[f32; 2]; 256]> = OnceLock::new();
    DIRECTIONS.get_or_init(|| {
        std::array::from_fn(|i| {
            let (cos, sin) = cos_sin((i as u32) << 24);
            [cos, sin]
        })
    })
}
