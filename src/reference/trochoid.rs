//! Trochoids and noise at one point in f64: Kepler's equation by Newton's method, noise as its formula says, plain sums.

use std::f64::consts::PI;

use crate::sea::{Octave, TrochoidWave, lattice_direction};

/// Sums over waves at one point of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Orbits {
    /// Height, metres.
    pub height: f64,
    /// Its derivatives along x and z.
    pub slope: [f64; 2],
    /// Velocity of the water at the surface (x, up, z), m/s.
    pub velocity: [f64; 3],
    /// Strain of the orbits: d Dx / dx, d Dz / dz, d Dx / dz.
    pub strain: [f64; 3],
}

/// theta of psi = theta - s sin(theta), s from 0 to 1: Newton's method, kept between the bounds that are known.
pub fn kepler(s: f64, psi: f64) -> f64 {
    let turns = (psi / (2.0 * PI)).round();
    let psi = psi - 2.0 * PI * turns;
    let (mut low, mut high) = (psi - s, psi + s);
    let mut theta = psi;
    for _ in 0..200 {
        let error = theta - s * libm::sin(theta) - psi;
        if error > 0.0 {
            high = theta
        } else {
            low = theta
        }
        let next = theta - error / (1.0 - s * libm::cos(theta));
        // A cusp's derivative is 0.
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - theta).abs() < 1e-16 {
            break;
        }
        theta = next;
    }
    theta + 2.0 * PI * turns
}

/// The sum of trochoids of a patch at a point of the world, at a tick of a sea that repeats after `repeat` ticks.
pub fn trochoids(waves: &[TrochoidWave], patch_m: f64, repeat: u64, tick: i64, x: f64, z: f64) -> Orbits {
    let mut sum = Orbits::default();
    for wave in waves {
        let (kx, kz) = (2.0 * PI * f64::from(wave.n) / patch_m, 2.0 * PI * f64::from(wave.m) / patch_m);
        let k = libm::hypot(kx, kz);
        let (ex, ez) = (kx / k, kz / k);
        let turns = share(tick, repeat, wave.cycles);
        let psi = kx * x + kz * z + 2.0 * PI * (f64::from(wave.phase) / 4_294_967_296.0 - wave.along * turns);
        let (r, s) = (wave.radius, wave.steepness);
        let theta = kepler(s, psi);
        let (cos, sin) = (libm::cos(theta), libm::sin(theta));
        sum.height += r * (cos + 0.5 * s);
        let slope = -r * k * sin / (1.0 - s * cos);
        sum.slope = [sum.slope[0] + slope * ex, sum.slope[1] + slope * ez];
        // Rates of -(s/k) sin(theta) along k and r cos(theta) upward, at theta = k.x0 - along w t.
        let rate = -wave.along * wave.omega;
        let along = -s / k * cos * rate;
        sum.velocity[0] += along * ex;
        sum.velocity[1] += -r * sin * rate;
        sum.velocity[2] += along * ez;
        for (sum, e) in sum.strain.iter_mut().zip([ex * ex, ez * ez, ex * ez]) {
            *sum -= s * cos * e;
        }
    }
    sum
}

/// The height of octaves of noise, metres.
pub fn noise(
    octaves: &[Octave],
    (seed, cascade): (u64, u8),
    patch_m: f64,
    repeat: u64,
    tick: i64,
    x: f64,
    z: f64,
) -> f64 {
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mut sum = 0.0;
    for octave in octaves {
        let cells = f64::from(octave.cells);
        let drifted = |metres: f64, patches: i32| {
            let turns = share(tick, repeat, patches.unsigned_abs()) * f64::from(patches.signum());
            (metres / patch_m - turns).rem_euclid(1.0) * cells
        };
        let (x, z) = (drifted(x, octave.drift[0]), drifted(z, octave.drift[1]));
        let within = i128::from(tick).rem_euclid(i128::from(repeat)) as f64;
        let moment = within / repeat as f64 * f64::from(octave.changes);
        let f = if octave.changes == 1 { 0.0 } else { fade(moment.fract()) };
        let mut value = 0.0;
        for (later, weight) in [(0, 1.0 - f), (1, f)] {
            let key = octave.key(seed, cascade, (moment.floor() as u32 + later) % octave.changes);
            for (right, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let (column, row) = (x.floor() as u32 + right, z.floor() as u32 + down);
                let direction = lattice_direction(key, column % octave.cells, row % octave.cells);
                let angle = 2.0 * PI * f64::from(direction) / 256.0;
                let (dx, dz) = (x - f64::from(column), z - f64::from(row));
                let window = (1.0 - fade(dx.abs())) * (1.0 - fade(dz.abs()));
                value += weight * window * (libm::cos(angle) * dx + libm::sin(angle) * dz);
            }
        }
        sum += octave.amplitude * value / libm::sqrt((1.0 - f) * (1.0 - f) + f * f);
    }
    sum
}

/// Share of a turn beyond whole ones after `cycles` cycles a repeat.
fn share(tick: i64, repeat: u64, cycles: u32) -> f64 {
    let within = i128::from(tick).rem_euclid(i128::from(repeat)) as u128;
    ((u128::from(cycles) * within) % u128::from(repeat)) as f64 / repeat as f64
}
