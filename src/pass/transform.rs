//! From modes to a grid: an inverse real transform in two dimensions that skips the empty rows and columns.
//!
//! A band that ends at a third of Nyquist leaves two thirds of the columns empty. The first pass goes down the
//! columns that hold something, the second along all rows, half-complex to real.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner};
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};

/// Rows that are gathered together, so that each cache line of the columns is read once.
const BLOCK: usize = 8;
/// Rows of a part that one thread takes: small grids are one part, since fields run side by side anyway.
const PART: usize = 256;

/// The inverse transform of one grid size and band.
pub struct Transform {
    n: usize,
    half: usize,
    columns: Arc<dyn Fft<f32>>,
    rows: Arc<dyn ComplexToReal<f32>>,
}

/// Memory that one transform at a time works in.
pub struct Workspace {
    /// Columns after the first pass: n = 0..=half, each of all z.
    columns: Vec<Complex32>,
    parts: Vec<Part>,
}

struct Part {
    column_scratch: Vec<Complex32>,
    row_scratch: Vec<Complex32>,
    spectra: Vec<Complex32>,
}

impl Transform {
    /// A transform to n x n samples of modes (n, m) up to `half` each way.
    pub fn new(n: usize, half: usize) -> Self {
        let columns = FftPlanner::new().plan_fft_inverse(n);
        let rows = RealFftPlanner::new().plan_fft_inverse(n);
        Self { n, half, columns, rows }
    }

    /// Memory for one transform.
    pub fn workspace(&self) -> Workspace {
        let part = || Part {
            column_scratch: vec![Complex32::ZERO; self.columns.get_inplace_scratch_len()],
            row_scratch: self.rows.make_scratch_vec(),
            spectra: vec![Complex32::ZERO; BLOCK * (self.n / 2 + 1)],
        };
        Workspace {
            columns: vec![Complex32::ZERO; (self.half + 1) * self.n],
            parts: (0..self.n.div_ceil(PART)).map(|_| part()).collect(),
        }
    }

    /// Sum over all modes of `factor` h e^{i k x}, or with `odd` of i `factor` h e^{i k x}: `field` is n x n, `[z][x]`.
    ///
    /// # Panics
    /// If a slice is not of the size the transform was made for.
    pub fn run(&self, heights: &[Complex32], factors: &[f32], odd: bool, work: &mut Workspace, field: &mut [f32]) {
        let (n, side) = (self.n, 2 * self.half + 1);
        let Workspace { columns, parts } = work;
        let share = (self.half + 1).div_ceil(parts.len());
        let pieces = columns.par_chunks_mut(share * n).zip(heights.par_chunks(share * side));
        pieces.zip(factors.par_chunks(share * side)).zip(&mut *parts).for_each(
            |(((columns, heights), factors), part)| {
                let lines = columns.chunks_exact_mut(n).zip(heights.chunks_exact(side)).zip(factors.chunks_exact(side));
                for ((column, heights), factors) in lines {
                    self.scatter(heights, factors, odd, column);
                    self.columns.process_with_scratch(column, &mut part.column_scratch);
                }
            },
        );
        let columns = &*columns;
        field.par_chunks_mut(PART.min(n) * n).zip(parts).enumerate().for_each(|(index, (rows, part))| {
            for (block, rows) in rows.chunks_mut(BLOCK * n).enumerate() {
                self.gather(columns, index * PART + block * BLOCK, part, rows);
            }
        });
    }

    /// One column's modes, m = -half..=half, at their places; the rest empty.
    fn scatter(&self, heights: &[Complex32], factors: &[f32], odd: bool, column: &mut [Complex32]) {
        let (half, n) = (self.half, self.n);
        let value = |i: usize| {
            let h = heights[i] * factors[i];
            if odd { Complex32::new(-h.im, h.re) } else { h }
        };
        column[half + 1..n - half].fill(Complex32::ZERO);
        for (m, place) in column[..=half].iter_mut().enumerate() {
            *place = value(half + m);
        }
        for (m, place) in column[n - half..].iter_mut().enumerate() {
            *place = value(m);
        }
    }

    /// Rows `first..` out of the columns, to real samples.
    fn gather(&self, columns: &[Complex32], first: usize, part: &mut Part, rows: &mut [f32]) {
        let (n, half, width) = (self.n, self.half, self.n / 2 + 1);
        for spectrum in part.spectra.chunks_exact_mut(width) {
            spectrum[half + 1..].fill(Complex32::ZERO);
        }
        for (x, column) in columns.chunks_exact(n).enumerate() {
            for (spectrum, value) in part.spectra.chunks_exact_mut(width).zip(&column[first..]) {
                spectrum[x] = *value;
            }
        }
        for (spectrum, row) in part.spectra.chunks_exact_mut(width).zip(rows.chunks_exact_mut(n)) {
            // The column n = 0 is Hermitian, so this is rounding only.
            spectrum[0].im = 0.0;
            self.rows
                .process_with_scratch(spectrum, row, &mut part.row_scratch)
                .expect("sizes are the transform's own");
        }
    }
}
