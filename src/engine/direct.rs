//! The strongest modes of a sea at a tick, summed one by one at any point: no grid, and no error but what was left out.

use std::f64::consts::PI;

use rustfft::num_complex::Complex64;

use crate::sea::{CascadeModes, Displacement, Mode, Sea, turn_of_tick};

/// The modes of a sea, turned to a tick.
pub struct DirectSum {
    cascades: Vec<Cascade>,
    /// Root mean square of the height that the modes left out would add, metres.
    pub omitted_rms_m: f64,
}

struct Cascade {
    dk: f64,
    half: usize,
    /// In the order of `CascadeModes::modes`.
    waves: Vec<Wave>,
}

struct Wave {
    column: u32,
    row: u32,
    kx: f64,
    kz: f64,
    /// Choppiness, widening included, over the wavenumber.
    chop: f64,
    /// h(k, t), metres, and its rate, m/s; those of n > 0 stand for their conjugates, too.
    height: Complex64,
    rate: Complex64,
}

/// Height, its slopes and the velocity of a particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Metres.
    pub height: f64,
    /// Derivatives of the height along x and z.
    pub slope: [f64; 2],
    /// m/s.
    pub velocity: [f64; 3],
}

impl DirectSum {
    /// The strongest modes that hold a share of the sea's energy, 0 to 1, at a tick.
    pub fn new(sea: &Sea, tick: i64, share: f64) -> Self {
        let energy = |modes: &CascadeModes, i: usize| {
            let mode = &modes.modes[i];
            twice(i / modes.rows()) * (mode.forward.norm_sqr() + mode.backward.norm_sqr())
        };
        let all = |(c, modes): (usize, &CascadeModes)| -> Vec<(f64, usize, usize)> {
            (0..modes.modes.len()).map(|i| (energy(modes, i), c, i)).filter(|(energy, ..)| *energy > 0.0).collect()
        };
        let mut kept: Vec<_> = sea.cascades.iter().enumerate().flat_map(all).collect();
        let total: f64 = kept.iter().map(|(energy, ..)| energy).sum();
        let mut omitted = 0.0;
        if share < 1.0 {
            kept.sort_by(|a, b| b.0.total_cmp(&a.0));
            let (mut sum, mut most) = (0.0, 0);
            while sum < share * total && most < kept.len() {
                sum += kept[most].0;
                most += 1;
            }
            kept.truncate(most);
            omitted = (total - sum).max(0.0);
        }
        kept.sort_by_key(|(_, cascade, mode)| (*cascade, *mode));
        let turn = turn_of_tick(tick, sea.repeat);
        let cascade = |(c, modes): (usize, &CascadeModes)| {
            let (dk, half, rows) = (modes.cascade.dk(), modes.cascade.half, modes.rows());
            let here = kept.iter().filter(|(_, cascade, _)| *cascade == c);
            let waves = here.map(|(.., i)| Wave::new(&modes.modes[*i], i / rows, i % rows, half, dk, sea, turn));
            Cascade { dk, half, waves: waves.collect() }
        };
        let cascades = sea.cascades.iter().enumerate().map(cascade).filter(|cascade| !cascade.waves.is_empty());
        Self { cascades: cascades.collect(), omitted_rms_m: omitted.sqrt() }
    }

    /// Modes that are summed.
    pub fn modes(&self) -> usize {
        self.cascades.iter().map(|cascade| cascade.waves.len()).sum()
    }

    /// Horizontal displacement of the particle that rests at a point.
    pub fn displacement(&self, at: [f64; 2]) -> Displacement {
        let mut sum = Displacement::default();
        self.each(at, |wave, phase| {
            let h = wave.height * phase;
            let (x, z) = (wave.chop * wave.kx, wave.chop * wave.kz);
            sum.dx -= x * h.im;
            sum.dz -= z * h.im;
            sum.dxx -= x * wave.kx * h.re;
            sum.dzz -= z * wave.kz * h.re;
            sum.dxz -= x * wave.kz * h.re;
        });
        Displacement { dzx: sum.dxz, ..sum }
    }

    /// What else moves of the particle that rests at a point.
    pub fn motion(&self, at: [f64; 2]) -> Motion {
        let mut sum = Motion::default();
        self.each(at, |wave, phase| {
            let (h, rate) = (wave.height * phase, wave.rate * phase);
            sum.height += h.re;
            sum.slope[0] -= wave.kx * h.im;
            sum.slope[1] -= wave.kz * h.im;
            sum.velocity[0] -= wave.chop * wave.kx * rate.im;
            sum.velocity[1] += rate.re;
            sum.velocity[2] -= wave.chop * wave.kz * rate.im;
        });
        sum
    }

    /// Every wave with e^{i k.x}: a product of one factor for its column and one for its row.
    fn each(&self, [x, z]: [f64; 2], mut add: impl FnMut(&Wave, Complex64)) {
        for cascade in &self.cascades {
            let unit = |n: f64, x: f64| {
                let angle = n * cascade.dk * x;
                Complex64::new(libm::cos(angle), libm::sin(angle))
            };
            let half = cascade.half;
            let columns: Vec<Complex64> = (0..=half).map(|n| unit(n as f64, x)).collect();
            let rows: Vec<Complex64> = (0..=2 * half).map(|m| unit(m as f64 - half as f64, z)).collect();
            for wave in &cascade.waves {
                add(wave, columns[wave.column as usize] * rows[wave.row as usize]);
            }
        }
    }
}

impl Wave {
    fn new(mode: &Mode, column: usize, row: usize, half: usize, dk: f64, sea: &Sea, turn: u32) -> Self {
        let (kx, kz) = (column as f64 * dk, (row as f64 - half as f64) * dk);
        let turns = f64::from(mode.cycles.wrapping_mul(turn).wrapping_add(mode.offset)) / 4_294_967_296.0;
        let turned = Complex64::new(libm::cos(2.0 * PI * turns), -libm::sin(2.0 * PI * turns)) * twice(column);
        let (forward, backward) = (mode.forward * turned, mode.backward * turned.conj());
        Self {
            column: column as u32,
            row: row as u32,
            kx,
            kz,
            // The mode without a wavenumber is nothing.
            chop: sea.choppiness * mode.widening / libm::hypot(kx, kz).max(f64::MIN_POSITIVE),
            height: forward + backward,
            rate: Complex64::new(0.0, -mode.omega(sea.repeat)) * (forward - backward),
        }
    }
}

/// Modes with n > 0 stand for their conjugates, too.
fn twice(column: usize) -> f64 {
    if column == 0 { 1.0 } else { 2.0 }
}
