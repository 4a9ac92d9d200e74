//! Turns every mode to a tick: h(k, t) = h0(k) e^-i phi + conj(h0(-k)) e^+i phi, and its rate.

use rayon::prelude::*;
use rustfft::num_complex::Complex32;

use crate::sea::{CascadeModes, cos_sin};

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

impl Amplitudes {
    fn resize(&mut self, modes: usize) {
        self.re.resize(modes, 0.0);
        self.im.resize(modes, 0.0);
    }
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

    /// h(k, t) of every mode with n up to `half`, at a turn of the repeat period, metres.
    pub fn heights(&self, turn: u32, half: usize, heights: &mut Amplitudes) {
        heights.resize(self.modes(half));
        let parts = heights.re.par_chunks_mut(PART).zip(heights.im.par_chunks_mut(PART)).enumerate();
        parts.for_each(|(part, (re, im))| {
            let modes = self.part(part * PART, re.len());
            let im = &mut im[..re.len()];
            for i in 0..re.len() {
                (re[i], im[i]) = modes.height(i, modes.cos_sin(i, turn));
            }
        });
    }

    /// The same, and dh/dt of every mode, m/s.
    pub fn heights_and_rates(&self, turn: u32, half: usize, heights: &mut Amplitudes, rates: &mut Amplitudes) {
        heights.resize(self.modes(half));
        rates.resize(self.modes(half));
        let heights = heights.re.par_chunks_mut(PART).zip(heights.im.par_chunks_mut(PART));
        let rates = rates.re.par_chunks_mut(PART).zip(rates.im.par_chunks_mut(PART));
        heights.zip(rates).enumerate().for_each(|(part, ((re, im), (rate_re, rate_im)))| {
            let modes = self.part(part * PART, re.len());
            let (im, rate_re, rate_im) = (&mut im[..re.len()], &mut rate_re[..re.len()], &mut rate_im[..re.len()]);
            for i in 0..re.len() {
                let turned = modes.cos_sin(i, turn);
                (re[i], im[i]) = modes.height(i, turned);
                (rate_re[i], rate_im[i]) = modes.rate(i, turned);
            }
        });
    }

    /// Every mode as eight words: p, q, r, t, cycles, offset, angular frequency and chop; for a backend that keeps tables
    /// of its own.
    pub fn words(&self) -> impl Iterator<Item = [u32; 8]> + '_ {
        (0..self.p.len()).map(|i| {
            let [p, q, r, t] = [self.p[i], self.q[i], self.r[i], self.t[i]].map(f32::to_bits);
            [p, q, r, t, self.cycles[i], self.offsets[i], self.omegas[i].to_bits(), self.chop[i].to_bits()]
        })
    }

    fn modes(&self, half: usize) -> usize {
        (half + 1) * (2 * self.half + 1)
    }

    fn part(&self, first: usize, modes: usize) -> Part<'_> {
        let here = first..first + modes;
        Part {
            p: &self.p[here.clone()],
            q: &self.q[here.clone()],
            r: &self.r[here.clone()],
            t: &self.t[here.clone()],
            cycles: &self.cycles[here.clone()],
            offsets: &self.offsets[here.clone()],
            omegas: &self.omegas[here],
        }
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

/// Some modes of a table.
struct Part<'a> {
    p: &'a [f32],
    q: &'a [f32],
    r: &'a [f32],
    t: &'a [f32],
    cycles: &'a [u32],
    offsets: &'a [u32],
    omegas: &'a [f32],
}

impl Part<'_> {
    #[inline(always)]
    fn cos_sin(&self, i: usize, turn: u32) -> (f32, f32) {
        cos_sin(self.cycles[i].wrapping_mul(turn).wrapping_add(self.offsets[i]))
    }

    #[inline(always)]
    fn height(&self, i: usize, (c, s): (f32, f32)) -> (f32, f32) {
        (self.p[i] * c + self.q[i] * s, self.r[i] * c + self.t[i] * s)
    }

    #[inline(always)]
    fn rate(&self, i: usize, (c, s): (f32, f32)) -> (f32, f32) {
        let omega = self.omegas[i];
        (omega * (self.q[i] * c - self.p[i] * s), omega * (self.t[i] * c - self.r[i] * s))
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
    /// The highest mode in it.
    pub fn half(&self) -> usize {
        self.re.len() / 2
    }

    /// Mode `i`: amplitude, wavenumber along z, and chop over wavenumber.
    #[inline(always)]
    pub fn mode(&self, i: usize) -> (Complex32, f32, f32) {
        let kz = (i as f32 - (self.re.len() / 2) as f32) * self.dk;
        (Complex32::new(self.re[i], self.im[i]), kz, self.chop[i])
    }
}
