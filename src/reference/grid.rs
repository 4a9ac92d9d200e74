//! Whole grids by a separable sum, O(N^3): first along z for each column, then along x for each row.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::direct::{height, operator, rate_of};
use crate::plan::Field;
use crate::sea::Sea;

/// Spectral fields of one cascade at a tick, each n x n `[z][x]`, in f64.
pub fn fields(sea: &Sea, cascade: usize, tick: i64, wanted: &[Field]) -> Vec<Vec<f64>> {
    let modes = &sea.cascades[cascade];
    let (n, rows, half) = (modes.cascade.n, modes.rows(), modes.cascade.half);
    let moving: Vec<(Complex64, Complex64)> = modes.modes.iter().map(|mode| height(mode, tick, sea.repeat)).collect();
    // e^{2 pi i j / n}: every angle that occurs is one of these.
    let unit: Vec<Complex64> = (0..n)
        .map(|j| {
            let angle = 2.0 * PI * j as f64 / n as f64;
            Complex64::new(libm::cos(angle), libm::sin(angle))
        })
        .collect();
    let one = |field: Field| {
        let coefficients: Vec<Complex64> = (modes.with_wave_vectors().zip(&moving))
            .map(|((kx, kz, mode), (h, rate))| {
                let (moves, source) = rate_of(field).map_or((field, h), |moves| (moves, rate));
                operator(moves, kx, kz, sea.choppiness * mode.widening) * source
            })
            .collect();
        let row = |z: usize| {
            let column = |nx: usize| -> Complex64 {
                let along = |row: usize| coefficients[nx * rows + row] * unit[(row + n * n - half) % n * z % n];
                (0..rows).map(along).sum()
            };
            let columns: Vec<Complex64> = (0..=half).map(column).collect();
            let sample = |x: usize| -> f64 {
                let twice = |nx: usize| if nx == 0 { 1.0 } else { 2.0 };
                columns.iter().enumerate().map(|(nx, c)| twice(nx) * (c * unit[nx * x % n]).re).sum()
            };
            (0..n).map(sample).collect::<Vec<f64>>()
        };
        (0..n).into_par_iter().flat_map_iter(row).collect()
    };
    wanted.iter().map(|field| one(*field)).collect()
}
