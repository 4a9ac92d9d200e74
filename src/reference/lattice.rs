//! Every field at the points of a lattice of any spacing, by a separable sum: what grids are compared with between their
//! samples.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::direct::{height, operator, rate_of};
use crate::plan::Field;
use crate::sea::Sea;

/// Spectral fields, in the order of [`Field`], of the particles of one cascade that rest at every pair of `xs` and `zs`,
/// metres: rows of z, each of x, in f64.
pub fn lattice(sea: &Sea, cascade: usize, tick: i64, xs: &[f64], zs: &[f64]) -> Vec<[f64; 11]> {
    let modes = &sea.cascades[cascade];
    let (rows, half, patch_m) = (modes.rows(), modes.cascade.half as i64, modes.cascade.patch_m);
    let coefficients: Vec<[Complex64; 11]> = modes
        .with_wave_vectors()
        .map(|(kx, kz, mode)| {
            let (h, rate) = height(mode, tick, sea.repeat);
            Field::SPECTRAL.map(|field| {
                let (moves, source) = rate_of(field).map_or((field, h), |moves| (moves, rate));
                operator(moves, kx, kz, sea.choppiness * mode.widening) * source
            })
        })
        .collect();
    // Whole patches are taken off first, so that far from the origin nothing is lost.
    let wave = |cycles: i64, metres: f64| {
        let angle = 2.0 * PI * cycles as f64 * (metres / patch_m).rem_euclid(1.0);
        Complex64::new(libm::cos(angle), libm::sin(angle))
    };
    let twice = |column: i64| if column == 0 { 1.0 } else { 2.0 };
    let along_x: Vec<Vec<Complex64>> =
        xs.iter().map(|x| (0..=half).map(|n| wave(n, *x) * twice(n)).collect()).collect();
    let row = |z: &f64| {
        let along_z: Vec<Complex64> = (-half..=half).map(|m| wave(m, *z)).collect();
        let mut columns = vec![[Complex64::ZERO; 11]; half as usize + 1];
        for (column, coefficients) in columns.iter_mut().zip(coefficients.chunks_exact(rows)) {
            for (fields, turned) in coefficients.iter().zip(&along_z) {
                column.iter_mut().zip(fields).for_each(|(sum, field)| *sum += field * turned);
            }
        }
        let point = |along_x: &Vec<Complex64>| {
            let mut fields = [0.0; 11];
            for (column, turned) in columns.iter().zip(along_x) {
                fields.iter_mut().zip(column).for_each(|(sum, field)| *sum += (field * turned).re);
            }
            fields
        };
        along_x.iter().map(point).collect::<Vec<_>>()
    };
    zs.par_iter().flat_map_iter(row).collect()
}
