//! Which taps predict a plane best: least squares over a sample of its rows.

use super::predict::{Basis, TAPS, Taps, predict_in_space, predict_row};
use crate::wire::TILE;

/// Rows that are looked at: 16 x 256 samples for seven unknowns.
const ROWS: usize = 16;
/// A prior: so much variance per sample, in counts squared, is held to be noise. It also settles what is not told apart.
const NOISE: f64 = 0.01;

/// Taps for a plane of n x n counts. They depend on the counts alone, so that whoever encodes a frame writes the same.
pub fn fit(counts: &[i16], basis: Basis, n: usize) -> Taps {
    let (plain, whole) = plain(basis);
    let fitted = least_squares(counts, basis, n).and_then(|weights| Taps::nearest(weights, whole));
    let Some(fitted) = fitted else { return plain };
    // Least squares looks at the few large errors; where most samples don't change (foam) the plain way may be shorter.
    if misses(counts, basis, plain, n) <= misses(counts, basis, fitted, n) { plain } else { fitted }
}

/// The sample before, in time or in space, or the mean of both neighbours; and what weights about add up to.
fn plain(basis: Basis) -> (Taps, f64) {
    let (weights, whole) = match basis {
        Basis::Space => ([1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0], 1.0),
        Basis::Past(_) => ([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0),
        Basis::Between(..) => ([0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.5),
    };
    (Taps::nearest(weights, whole).expect("small weights are taps"), whole)
}

fn rows(n: usize) -> impl Iterator<Item = usize> {
    // Without the first two, of which space knows too little.
    (2..n).step_by(n.div_ceil(ROWS))
}

/// Sum of the distances between counts and predictions over the rows that are looked at.
fn misses(counts: &[i16], basis: Basis, taps: Taps, n: usize) -> u64 {
    let mut row = [0; TILE];
    let row = &mut row[..n];
    let mut sum = 0;
    for z in rows(n) {
        if let Basis::Space = basis {
            row.iter_mut().enumerate().for_each(|(x, sample)| *sample = predict_in_space(counts, taps, n, z, x));
        } else {
            predict_row(basis, taps, n, z, row);
        }
        let miss =
            |(count, predicted): (&i16, &i32)| (i32::from(*count) << 12).wrapping_sub(*predicted).unsigned_abs() >> 8;
        sum += counts[z * n..][..n].iter().zip(&*row).map(miss).map(u64::from).sum::<u64>();
    }
    sum
}

/// Unknown weights.
const WEIGHTS: usize = TAPS - 1;
/// What is weighed, and what it is to give.
const COLUMNS: usize = WEIGHTS + 1;

fn least_squares(counts: &[i16], basis: Basis, n: usize) -> Option<[f64; WEIGHTS]> {
    let mut sums = [[0.0; COLUMNS]; COLUMNS];
    let mut columns = [[0.0f64; TILE]; COLUMNS];
    let wrap = |z: usize, x: usize| z % n * n + x % n;
    let used = match basis {
        Basis::Space => 6,
        Basis::Past([_, second, third]) => 5 + usize::from(!second.is_empty()) + usize::from(!third.is_empty()),
        Basis::Between(..) => 5,
    };
    for z in rows(n) {
        for x in 0..n {
            let cross = [wrap(z, x), wrap(z, x + n - 1), wrap(z, x + 1), wrap(z + n - 1, x), wrap(z + 1, x)];
            match basis {
                Basis::Space => {
                    let back = [(0, 1), (1, 0), (1, 1), (1, n - 1), (0, 2), (2, 0)];
                    for (column, (up, left)) in columns.iter_mut().zip(back) {
                        column[x] = f64::from(counts[wrap(z - up, x + n - left)]);
                    }
                }
                Basis::Past(planes) => {
                    cross.iter().zip(&mut columns).for_each(|(at, column)| column[x] = f64::from(planes[0][*at]));
                    for (plane, column) in planes[1..].iter().zip(&mut columns[5..]) {
                        column[x] = plane.get(cross[0]).map_or(0.0, |sample| f64::from(*sample));
                    }
                }
                Basis::Between(before, after) => {
                    for (at, column) in cross.iter().zip(&mut columns) {
                        column[x] = f64::from(before[*at]) + f64::from(after[*at]);
                    }
                }
            }
            columns[WEIGHTS][x] = f64::from(counts[wrap(z, x)]);
        }
        for i in 0..COLUMNS {
            for j in i..COLUMNS {
                sums[i][j] += dot(&columns[i][..n], &columns[j][..n]);
            }
        }
    }
    let prior = NOISE * (rows(n).count() * n) as f64;
    solve(sums, used, prior)
}

/// A dot product in four lanes, which the compiler turns into vectors; the order of sums is fixed.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    for (a, b) in a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// Solves the normal equations, of which the upper triangle is given, by Cholesky's way without roots.
fn solve(mut a: [[f64; COLUMNS]; COLUMNS], used: usize, prior: f64) -> Option<[f64; WEIGHTS]> {
    let mut right: [f64; WEIGHTS] = std::array::from_fn(|i| a[i][WEIGHTS]);
    for (i, row) in a.iter_mut().enumerate().take(used) {
        row[i] += prior;
    }
    for i in 0..used {
        let pivot = a[i][i];
        if pivot <= 0.0 {
            return None;
        }
        for j in i + 1..used {
            let share = a[i][j] / pivot;
            let row = a[i];
            a[j][j..used].iter_mut().zip(&row[j..used]).for_each(|(below, above)| *below -= share * above);
            right[j] -= share * right[i];
        }
    }
    let mut weights = [0.0; WEIGHTS];
    for i in (0..used).rev() {
        let known: f64 = (i + 1..used).map(|j| a[i][j] * weights[j]).sum();
        weights[i] = (right[i] - known) / a[i][i];
    }
    Some(weights)
}
