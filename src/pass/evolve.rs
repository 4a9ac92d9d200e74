//! Turns every mode to a tick: h(k, t) = h0(k) e^-i phi + conj(h0(-k)) e^+i phi, and its rate.

use rayon::prelude::*;
use rustfft::num_complex::Complex32;

use crate::sea::{CascadeModes, cos_sin_q24};

/// Modes that one thread takes.
const PART: usize = 4096;

/// A cascade's modes as f32. With phase phi, h = (p cos + q sin) + i (r cos + t sin).
#[derive(Debug, Default)]
pub struct EvolveTable {
    half: usize,
    /// Spacing of wavenumbers, rad/m.
    dk: f32,
    p: Vec<f32>,
    q: Vec<f32>,
    r: Vec<f32>,
    t: Vec<f32>,
    cycles: Vec<u32>,
    offsets: Vec<u32>,
    /// Angular frequencies, rad/s.
    omegas: Vec<f32>,
    /// Choppiness times widening over wavenumber, metres.
    chop: Vec<f32>,
}

/// Amplitudes of every mode at one tick, in the order of [`CascadeModes::modes`].
#[derive(Debug, Default)]
pub struct Amplitudes {
    /// Real parts.
    pub re: Vec<f32>,
    /// Imaginary parts.
    pub im: Vec<f32>,
}

impl EvolveTable {
    /// Rounds a cascade's modes to f32. `choppiness` goes into every sideways field.
    pub fn new(cascade: &CascadeModes, choppiness: f64, repeat: u64) -> Self {
        let modes = &cascade.modes;
        let of = |value: fn(f64, f64, f64, f64) -> f64| {
            let (a, b) = (|i: usize| modes[i].forward, |i: usize| modes[i].backward);
            (0..modes.len()).map(|i| value(a(i).re, a(i).im, b(i).re, b(i).im) as f32).collect()
        };
        let chop = |(kx, kz, mode): (f64, f64, &crate::sea::Mode)| {
            let k = libm::sqrt(kx * kx + kz * kz);
            if k > 0.0 { (choppiness * mode.widening / k) as f32 } else { 0.0 }
        };
        Self {
            half: cascade.cascade.half,
            dk: cascade.cascade.dk() as f32,
            p: of(|a, _, b, _| a + b),
            q: of(|_, a, _, b| a - b),
            r: of(|_, a, _, b| a + b),
            t: of(|a, _, b, _| b - a),
            cycles: modes.iter().map(|mode| mode.cycles).collect(),
            offsets: modes.iter().map(|mode| mode.offset).collect(),
            omegas: modes.iter().map(|mode| mode.omega(repeat) as f32).collect(),
            chop: cascade.with_wave_vectors().map(chop).collect(),
        }
    }

    /// h(k, t) of every mode at a turn of the repeat period, metres.
    pub fn heights(&self, turn: u32, heights: &mut Amplitudes) {
        self.turned(turn, heights, |[p, q, r, t], _, c, s| (p * c + q * s, r * c + t * s));
    }

    /// dh/dt of every mode, m/s.
    pub fn rates(&self, turn: u32, rates: &mut Amplitudes) {
        self.turned(turn, rates, |[p, q, r, t], omega, c, s| (omega * (q * c - p * s), omega * (t * c - r * s)));
    }

    fn turned(
        &self,
        turn: u32,
        amplitudes: &mut Amplitudes,
        at: impl Fn([f32; 4], f32, f32, f32) -> (f32, f32) + Sync,
    ) {
        const Q24: f32 = 1.0 / 16_777_216.0;
        let modes = self.p.len();
        amplitudes.re.resize(modes, 0.0);
        amplitudes.im.resize(modes, 0.0);
        let parts = amplitudes.re.par_chunks_mut(PART).zip(amplitudes.im.par_chunks_mut(PART)).enumerate();
        parts.for_each(|(part, (re, im))| {
            let here = part * PART..part * PART + re.len();
            let (p, q, r, t) =
                (&self.p[here.clone()], &self.q[here.clone()], &self.r[here.clone()], &self.t[here.clone()]);
            let (cycles, offsets) = (&self.cycles[here.clone()], &self.offsets[here.clone()]);
            let omegas = &self.omegas[here];
            let im = &mut im[..re.len()];
            for i in 0..re.len() {
                let (cos, sin) = cos_sin_q24(cycles[i].wrapping_mul(turn).wrapping_add(offsets[i]));
                (re[i], im[i]) = at([p[i], q[i], r[i], t[i]], omegas[i], cos as f32 * Q24, sin as f32 * Q24);
            }
        });
    }

    /// The modes of column n, m = -half..=half, that a grid of `half` holds: amplitudes and what makes other fields
    /// of them.
    pub fn column<'a>(&'a self, amplitudes: &'a Amplitudes, n: usize, half: usize) -> Column<'a> {
        let first = n * (2 * self.half + 1) + self.half - half;
        let here = first..first + 2 * half + 1;
        Column {
            kx: n as f32 * self.dk,
            dk: self.dk,
            re: &amplitudes.re[here.clone()],
            im: &amplitudes.im[here.clone()],
            chop: &self.chop[here],
        }
    }
}

/// Modes (n, m) of one n, m = -half..=half.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// Wavenumber along x, rad/m.
    pub kx: f32,
    /// Spacing of wavenumbers along z, rad/m.
    pub dk: f32,
    re: &'a [f32],
    im: &'a [f32],
    chop: &'a [f32],
}

impl Column<'_> {
    /// Modes in it.
    pub fn len(&self) -> usize {
        self.re.len()
    }

    /// Mode `i`: amplitude, wavenumber along z, and chop over wavenumber.
    #[inline(always)]
    pub fn mode(&self, i: usize) -> (Complex32, f32, f32) {
        let kz = (i as f32 - (self.re.len() / 2) as f32) * self.dk;
        (Complex32::new(self.re[i], self.im[i]), kz, self.chop[i])
    }
}
