//! From modes to grids: inverse transforms in two dimensions that skip the empty rows and columns.
//!
//! A band that ends at a third of Nyquist leaves two thirds of the columns empty. The first pass goes down the
//! columns that hold something, the second along all rows: half-complex to one real field, or complex to two.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner};
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};

use super::evolve::{Amplitudes, EvolveTable};
use super::operator;
use crate::plan::Packing;

/// Rows that are gathered together, so that each cache line of the columns is read once.
const BLOCK: usize = 8;
/// Rows of a part that one thread takes: small grids are one part, since fields run side by side anyway.
const PART: usize = 256;
/// Columns lie this much farther apart than their length: at powers of two all of a row would share a few cache sets.
const PAD: usize = 8;

/// The inverse transform of one grid size and band.
pub struct Transform {
    n: usize,
    half: usize,
    whole: Arc<dyn Fft<f32>>,
    real: Arc<dyn ComplexToReal<f32>>,
}

/// Memory that one transform at a time works in.
#[derive(Default)]
pub struct Workspace {
    /// Columns after the first pass, each of all z: n and, in a packed transform beside it, -n.
    columns: Vec<Complex32>,
    parts: Vec<Part>,
}

#[derive(Default)]
struct Part {
    scratch: Vec<Complex32>,
    rows: Vec<Complex32>,
}

impl Transform {
    /// A transform to n x n samples of modes (n, m) up to `half` each way.
    pub fn new(n: usize, half: usize) -> Self {
        let whole = FftPlanner::new().plan_fft_inverse(n);
        let real = RealFftPlanner::new().plan_fft_inverse(n);
        Self { n, half, whole, real }
    }

    /// The sum over all modes: of one field into `planes[0]`, of two into both, each n x n, `[z][x]`.
    ///
    /// # Panics
    /// If a plane is not n x n, or the modes are not those the transform was made for.
    pub fn run(
        &self,
        packing: Packing,
        table: &EvolveTable,
        amplitudes: &Amplitudes,
        work: &mut Workspace,
        planes: [&mut [f32]; 2],
    ) {
        self.columns(packing, table, amplitudes, work);
        self.rows(packing, work, planes);
    }

    /// The first pass: modes of the packing's fields into columns, and these along z.
    pub fn columns(&self, packing: Packing, table: &EvolveTable, amplitudes: &Amplitudes, work: &mut Workspace) {
        let (n, stride) = (self.n, self.n + PAD);
        let lanes = lanes(packing);
        work.columns.resize(lanes * (self.half + 1) * stride, Complex32::ZERO);
        let count = n.div_ceil(PART);
        work.parts.resize_with(count.max(work.parts.len()), Part::default);
        let share = (self.half + 1).div_ceil(count);
        let scratch = self.whole.get_inplace_scratch_len().max(self.real.get_scratch_len());
        for part in &mut work.parts[..count] {
            part.scratch.resize(scratch.max(part.scratch.len()), Complex32::ZERO);
            part.rows.resize((BLOCK * n).max(part.rows.len()), Complex32::ZERO);
        }
        let pieces = work.columns.par_chunks_mut(share * lanes * stride).zip(&mut work.parts).enumerate();
        pieces.for_each(|(piece, (columns, part))| {
            for (i, places) in columns.chunks_exact_mut(lanes * stride).enumerate() {
                let x = piece * share + i;
                let column = table.column(amplitudes, x, self.half);
                match packing {
                    Packing::HalfComplex(field) => operator::single(field, &column, &mut places[..n]),
                    Packing::Packed(field, _) => {
                        let (forward, backward) = places.split_at_mut(stride);
                        operator::packed(field, &column, &mut forward[..n], &mut backward[..n]);
                        if x > 0 {
                            self.whole.process_with_scratch(&mut backward[..n], &mut part.scratch);
                        }
                    }
                }
                self.whole.process_with_scratch(&mut places[..n], &mut part.scratch);
            }
        });
    }

    /// The second pass: along x, to real samples.
    pub fn rows(&self, packing: Packing, work: &mut Workspace, planes: [&mut [f32]; 2]) {
        let (n, columns) = (self.n, &work.columns[..]);
        let [a, b] = planes;
        let share = PART.min(n) * n;
        match packing {
            Packing::HalfComplex(_) => {
                a.par_chunks_mut(share).zip(&mut work.parts).enumerate().for_each(|(index, (rows, part))| {
                    for (block, rows) in rows.chunks_mut(BLOCK * n).enumerate() {
                        self.half_complex_rows(columns, index * PART + block * BLOCK, part, rows);
                    }
                });
            }
            Packing::Packed(..) => {
                let rows = a.par_chunks_mut(share).zip(b.par_chunks_mut(share));
                rows.zip(&mut work.parts).enumerate().for_each(|(index, ((a, b), part))| {
                    let blocks = a.chunks_mut(BLOCK * n).zip(b.chunks_mut(BLOCK * n)).enumerate();
                    for (block, (a, b)) in blocks {
                        self.packed_rows(columns, index * PART + block * BLOCK, part, a, b);
                    }
                });
            }
        }
    }

    fn half_complex_rows(&self, columns: &[Complex32], first: usize, part: &mut Part, rows: &mut [f32]) {
        let (n, half, width) = (self.n, self.half, self.n / 2 + 1);
        let spectra = &mut part.rows[..BLOCK * width];
        for (x, column) in columns.chunks_exact(n + PAD).enumerate() {
            for (spectrum, value) in spectra.chunks_exact_mut(width).zip(&column[first..first + BLOCK]) {
                spectrum[x] = *value;
            }
        }
        for (spectrum, row) in spectra.chunks_exact_mut(width).zip(rows.chunks_exact_mut(n)) {
            spectrum[half + 1..].fill(Complex32::ZERO);
            // The column n = 0 is Hermitian, so this is rounding only.
            spectrum[0].im = 0.0;
            self.real.process_with_scratch(spectrum, row, &mut part.scratch).expect("sizes are the transform's own");
        }
    }

    fn packed_rows(&self, columns: &[Complex32], first: usize, part: &mut Part, a: &mut [f32], b: &mut [f32]) {
        let (n, half) = (self.n, self.half);
        let rows = &mut part.rows[..BLOCK * n];
        for (x, pair) in columns.chunks_exact(2 * (n + PAD)).enumerate() {
            let (forward, backward) = (&pair[first..first + BLOCK], &pair[n + PAD + first..][..BLOCK]);
            for ((row, forward), backward) in rows.chunks_exact_mut(n).zip(forward).zip(backward) {
                row[x] = *forward;
                if x > 0 {
                    row[n - x] = *backward;
                }
            }
        }
        for row in rows.chunks_exact_mut(n) {
            row[half + 1..n - half].fill(Complex32::ZERO);
        }
        self.whole.process_with_scratch(rows, &mut part.scratch);
        for ((value, a), b) in rows.iter().zip(a).zip(b) {
            (*a, *b) = (value.re, value.im);
        }
    }
}

/// Columns beside each other for one n >= 0.
fn lanes(packing: Packing) -> usize {
    match packing {
        Packing::HalfComplex(_) => 1,
        Packing::Packed(..) => 2,
    }
}
