//! One octave of gradient noise: what it is, how its random numbers come about, and its spectrum.
//!
//! Lattice points carry unit vectors g; between them the noise is sum g.(x - p) W(x - p) with W(x) = w(x) w(z) and
//! w(t) = 1 - (6 t^5 - 15 t^4 + 10 t^3) (Perlin 2002). Vectors lie in the plane and change with time from one
//! drawn vector to the next, so that noise at any moment is the noise of two dimensions. A slice through noise of three
//! would hold long waves (Cook & DeRose 2005).

use std::sync::OnceLock;

use super::noise::mix;

/// Steps of the tables of the kernel's transform, radians a cell.
const STEP: f64 = 0.1;
/// Entries of those: beyond 40 there is less than 1e-6 of the energy.
const ENTRIES: usize = 401;

/// Variance of an octave of unit amplitude.
pub const OCTAVE_VARIANCE: f64 = 0.046_53;
/// Mean wavenumber of an octave's energy, in turns a cell.
pub const OCTAVE_CENTRE: f64 = 0.615;

/// One octave of noise on a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octave {
    /// Its number, which its random vectors depend on; 0 for the finest.
    pub number: u32,
    /// Lattice cells a side of the patch.
    pub cells: u32,
    /// Factor on the unit noise, metres.
    pub amplitude: f64,
    /// Whole patches that it drifts along x and z in a repeat period.
    pub drift: [i32; 2],
    /// Vectors drawn for a lattice point in a repeat period.
    pub changes: u32,
    /// Wavenumber of its centre, rad/m.
    pub k: f64,
    /// Angular frequency that waves of that length have, rad/s.
    pub omega: f64,
    /// Choppiness times the ratio of horizontal to vertical orbit that waves of that length have.
    pub chop: f64,
}

impl Octave {
    /// Key of all vectors drawn for the moment `change`, below `changes`.
    pub fn key(&self, seed: u64, cascade: u8, change: u32) -> u64 {
        let name = (u64::from(cascade) << 32) | u64::from(self.number);
        mix(mix(mix(seed ^ 0x7472_6f63_686f_6964) ^ name) ^ u64::from(change))
    }

    /// Share of its energy that a grid of so many samples a side of the patch folds back.
    pub fn folded(&self, samples: f64) -> f64 {
        let table = kernel();
        let last = &table[ENTRIES - 1];
        let place = (std::f64::consts::PI * samples / f64::from(self.cells) / STEP).min((ENTRIES - 1) as f64);
        let (below, share) = (&table[place as usize], place.fract());
        let next = table.get(place as usize + 1).unwrap_or(last);
        let inside = |part: fn(&Kernel) -> f64| (part(below) + share * (part(next) - part(below))) / part(last);
        (1.0 - inside(|kernel| kernel.even_below) * inside(|kernel| kernel.odd_below)).max(0.0)
    }

    /// Its variance, m^2.
    pub fn variance(&self) -> f64 {
        OCTAVE_VARIANCE * self.amplitude * self.amplitude
    }
}

/// Direction of the vector of a lattice point, in 256ths of a turn.
#[inline]
pub fn lattice_direction(key: u64, x: u32, z: u32) -> u8 {
    // Finaliser of MurmurHash3 (Appleby 2011).
    let h = (key as u32) ^ x.wrapping_mul(0x9e37_79b1) ^ z.wrapping_mul(0x85eb_ca77).rotate_left(16);
    let h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    let h = (h ^ (h >> 13) ^ ((key >> 32) as u32)).wrapping_mul(0xc2b2_ae35);
    ((h ^ (h >> 16)) >> 24) as u8
}

/// Squares of the transforms of w(t) and of t w(t) at `q` radians a cell.
///
/// With random vectors, mode (n, m) of an octave of unit amplitude and L cells a side has the mean energy
/// (A(q) B(p) + B(q) A(p)) / (2 L^2), q = 2 pi n / L, p = 2 pi m / L.
pub fn kernel_energies(q: f64) -> (f64, f64) {
    let place = q.abs() / STEP;
    let i = place as usize;
    if i + 1 >= ENTRIES {
        return (0.0, 0.0);
    }
    let (low, high, share) = (&kernel()[i], &kernel()[i + 1], place - i as f64);
    (low.even + share * (high.even - low.even), low.odd + share * (high.odd - low.odd))
}

/// Energies of w(t) and of t w(t) at one q, and their integrals up to it.
#[derive(Clone, Copy, Debug, Default)]
struct Kernel {
    even: f64,
    odd: f64,
    even_below: f64,
    odd_below: f64,
}

fn kernel() -> &'static [Kernel] {
    static TABLE: OnceLock<Vec<Kernel>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut last = None;
        let entry = |i: usize| {
            let (even, odd) = transform(i as f64 * STEP);
            let before: Kernel = last.unwrap_or(Kernel { even, odd, ..Kernel::default() });
            let width = if i == 0 { 0.0 } else { 0.5 * STEP };
            let now = Kernel {
                even,
                odd,
                even_below: before.even_below + width * (even + before.even),
                odd_below: before.odd_below + width * (odd + before.odd),
            };
            last = Some(now);
            now
        };
        (0..ENTRIES).map(entry).collect()
    })
}

/// Simpson's rule over half the kernel, which is even, or odd.
fn transform(q: f64) -> (f64, f64) {
    const STEPS: usize = 128;
    let (mut even, mut odd) = (0.0, 0.0);
    for i in 0..=STEPS {
        let t = i as f64 / STEPS as f64;
        let weight = if i == 0 || i == STEPS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        let window = weight * (1.0 - t * t * t * (10.0 - t * (15.0 - 6.0 * t)));
        even += window * libm::cos(q * t);
        odd += window * t * libm::sin(q * t);
    }
    let scale = 2.0 / (3.0 * STEPS as f64);
    ((scale * even) * (scale * even), (scale * odd) * (scale * odd))
}
