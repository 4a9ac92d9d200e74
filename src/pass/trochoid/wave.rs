//! Adds one trochoid to a row of samples, eight at a time.

use super::profile::{Polynomial, Profile, Shape, TERMS, look_up, slope};
use crate::sea::TrochoidWave;

/// Eight samples.
pub type Lanes = [f32; 8];

/// What is summed over waves and noise, in this order; only the first 1, 3 or 6 where no more is wanted.
pub const SUMS: usize = 9;
/// Height, m.
pub const HEIGHT: usize = 0;
/// Its derivative along x.
pub const SLOPE_X: usize = 1;
/// Its derivative along z.
pub const SLOPE_Z: usize = 2;
/// Strain of the orbits, d Dx / dx.
pub const STRAIN_XX: usize = 3;
/// d Dz / dz.
pub const STRAIN_ZZ: usize = 4;
/// d Dx / dz.
pub const STRAIN_XZ: usize = 5;
/// Velocity of the water along x, m/s.
pub const VELOCITY_X: usize = 6;
/// Velocity upward, m/s.
pub const VELOCITY_Y: usize = 7;
/// Velocity along z, m/s.
pub const VELOCITY_Z: usize = 8;

/// A trochoid as f32, with the factor of each of its fields.
#[derive(Clone, Debug)]
pub struct Wave {
    pub n: u32,
    pub m: i32,
    /// Advance per turn of the repeat period, as a wrapping count of cycles.
    cycles: u32,
    phase: u32,
    pub profile: Profile,
    /// Variance of its height, m^2.
    pub variance: f64,
    radius: f32,
    kx: f32,
    kz: f32,
    /// Vertical velocity where sin(theta) is 1, m/s.
    rise: f32,
    /// Horizontal velocity where cos(theta) is 1, m/s.
    run: [f32; 2],
    /// Strain where cos(theta) is 1: xx, zz, xz.
    strain: [f32; 3],
}

impl Wave {
    /// Rounds a wave of a patch to f32.
    pub fn new(wave: &TrochoidWave, patch_m: f64) -> Self {
        let dk = 2.0 * std::f64::consts::PI / patch_m;
        let (kx, kz) = (f64::from(wave.n) * dk, f64::from(wave.m) * dk);
        let k = libm::hypot(kx, kz);
        let (ex, ez) = (kx / k, kz / k);
        // The particle is at x - (s/k) e sin(theta), theta = k.x - along w t.
        let speed = wave.along * wave.omega;
        let run = speed * wave.steepness / k;
        let squeeze = -wave.steepness;
        Self {
            n: wave.n.unsigned_abs(),
            m: wave.m,
            cycles: if wave.along > 0.0 { wave.cycles.wrapping_neg() } else { wave.cycles },
            phase: wave.phase,
            profile: Profile::new(wave.steepness),
            variance: 0.5 * wave.amplitude * wave.amplitude,
            radius: wave.radius as f32,
            kx: (kx * wave.radius) as f32,
            kz: (kz * wave.radius) as f32,
            rise: (speed * wave.radius) as f32,
            run: [(run * ex) as f32, (run * ez) as f32],
            strain: [(squeeze * ex * ex) as f32, (squeeze * ez * ez) as f32, (squeeze * ex * ez) as f32],
        }
    }

    /// psi at x = 0 and z (in 2^-32 of the patch), at a turn of the repeat period.
    pub fn phase(&self, turn: u32, z: u32) -> u32 {
        self.phase.wrapping_add(self.cycles.wrapping_mul(turn)).wrapping_add((self.m as u32).wrapping_mul(z))
    }

    /// Highest harmonic that a grid of so many samples a side of the patch shows.
    pub fn limit(&self, samples: f64) -> usize {
        let finest = f64::from(self.n.max(self.m.unsigned_abs()));
        // Strictly below half the samples.
        ((0.5 * samples / finest).ceil() - 1.0).clamp(0.0, 1e6) as usize
    }

    /// Adds it to a row whose samples have the cosines and sines of psi - `at`.
    pub fn add<const A: usize>(
        &self,
        shape: &Shape,
        at: (f32, f32),
        turns: &[[u32; 8]],
        trig: &[(Lanes, Lanes)],
        sums: &mut [[Lanes; A]],
    ) {
        let polynomial = match shape {
            Shape::Table(table) => {
                for (sum, turns) in sums.iter_mut().zip(turns) {
                    self.add_table(table, turns, sum);
                }
                return;
            }
            Shape::Series(polynomial) => polynomial,
        };
        match polynomial.degree {
            0 => {}
            1 => self.add_series::<1, A>(polynomial, at, trig, sums),
            2 => self.add_series::<2, A>(polynomial, at, trig, sums),
            3 => self.add_series::<3, A>(polynomial, at, trig, sums),
            4 => self.add_series::<4, A>(polynomial, at, trig, sums),
            5 | 6 => self.add_series::<6, A>(polynomial, at, trig, sums),
            7 | 8 => self.add_series::<8, A>(polynomial, at, trig, sums),
            _ => self.add_series::<TERMS, A>(polynomial, at, trig, sums),
        }
    }

    fn add_series<const D: usize, const A: usize>(
        &self,
        polynomial: &Polynomial,
        (cos, sin): (f32, f32),
        trig: &[(Lanes, Lanes)],
        sums: &mut [[Lanes; A]],
    ) {
        let a = &polynomial.coefficients;
        for (sum, (cx, sx)) in sums.iter_mut().zip(trig) {
            let c: Lanes = std::array::from_fn(|j| cos * cx[j] - sin * sx[j]);
            let mut y = [a[D]; 8];
            let mut dy = [0.0; 8];
            for d in (0..D).rev() {
                if A > 1 {
                    dy = std::array::from_fn(|j| dy[j] * c[j] + y[j]);
                }
                y = std::array::from_fn(|j| y[j] * c[j] + a[d]);
            }
            let slope = std::array::from_fn(|j| -(sin * cx[j] + cos * sx[j]) * dy[j]);
            self.add_shape(&y, &slope, sum);
        }
    }

    fn add_table<const A: usize>(&self, table: &[[f32; 2]], psi: &[u32; 8], sum: &mut [Lanes; A]) {
        let s = self.profile.steepness;
        let shape = psi.map(|psi| look_up(table, psi));
        self.add_shape(&shape.map(|(cos, _)| cos + 0.5 * s), &shape.map(|(cos, sin)| slope(s, cos, sin)), sum);
    }

    /// Every field out of y = cos(theta) + s/2 and its derivative by psi.
    #[inline(always)]
    fn add_shape<const A: usize>(&self, y: &Lanes, slope: &Lanes, sum: &mut [Lanes; A]) {
        let mut add = |field: usize, factor: f32, values: &Lanes| {
            sum[field] = std::array::from_fn(|j| sum[field][j] + factor * values[j]);
        };
        add(HEIGHT, self.radius, y);
        if A > SLOPE_Z {
            add(SLOPE_X, self.kx, slope);
            add(SLOPE_Z, self.kz, slope);
        }
        let s = self.profile.steepness;
        let cos: Lanes = std::array::from_fn(|j| y[j] - 0.5 * s);
        if A > STRAIN_XZ {
            add(STRAIN_XX, self.strain[0], &cos);
            add(STRAIN_ZZ, self.strain[1], &cos);
            add(STRAIN_XZ, self.strain[2], &cos);
        }
        if A > VELOCITY_Z {
            // d theta / d psi = 1 / (1 - s cos(theta)).
            let sin = std::array::from_fn(|j| -slope[j] * (1.0 - s * cos[j]));
            add(VELOCITY_X, self.run[0], &cos);
            add(VELOCITY_Y, self.rise, &sin);
            add(VELOCITY_Z, self.run[1], &cos);
        }
    }
}
