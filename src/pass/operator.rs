//! From heights to the spectra of other fields: every field is its factor times the height of the mode.
//!
//! D = i (k / |k|) h, so crests sharpen; slopes are i k h, derivatives i k D (Tessendorf 2001, eq. 44, with our sign).
//! A velocity is the same of the rate of h. Two fields a and b share a transform as a + i b.

use rustfft::num_complex::Complex32;

use super::evolve::Column;
use crate::plan::Field;

/// Writes column n of `field` in the order of a transform along z, m = 0, 1, .. -2, -1.
///
/// # Panics
/// If `field` is none that stands alone.
pub fn single(field: Field, column: &Column, place: &mut [Complex32]) {
    match field {
        Field::Height | Field::VelocityY => fill(column, place, |h, _, _, _| h),
        Field::Dxz => fill(column, place, |h, kx, kz, chop| h * (-kx * kz * chop)),
        _ => unreachable!("{field:?} has a partner"),
    }
}

/// Writes column n, and column -n, of a + i b; `backward` of n = 0 is left alone.
///
/// # Panics
/// If `a` is not the first of two partners.
pub fn packed(a: Field, column: &Column, forward: &mut [Complex32], backward: &mut [Complex32]) {
    // An i beside the factor turns the height by a quarter.
    let odd = |h: Complex32| Complex32::new(-h.im, h.re);
    match a {
        Field::Dx | Field::VelocityX => {
            fill_pair(column, forward, backward, |h, kx, kz, chop| (odd(h), kx * chop, kz * chop));
        }
        Field::SlopeX => fill_pair(column, forward, backward, |h, kx, kz, _| (odd(h), kx, kz)),
        Field::Dxx => fill_pair(column, forward, backward, |h, kx, kz, chop| (h, -kx * kx * chop, -kz * kz * chop)),
        _ => unreachable!("{a:?} has no partner"),
    }
}

fn fill(column: &Column, place: &mut [Complex32], value: impl Fn(Complex32, f32, f32, f32) -> Complex32) {
    let (half, n) = (column.half(), place.len());
    let value = |i: usize| {
        let (h, kz, chop) = column.mode(i);
        value(h, column.kx, kz, chop)
    };
    place[half + 1..n - half].fill(Complex32::ZERO);
    for (i, place) in place[..=half].iter_mut().enumerate() {
        *place = value(half + i);
    }
    for (i, place) in place[n - half..].iter_mut().enumerate() {
        *place = value(i);
    }
}

fn fill_pair(
    column: &Column,
    forward: &mut [Complex32],
    backward: &mut [Complex32],
    value: impl Fn(Complex32, f32, f32, f32) -> (Complex32, f32, f32),
) {
    let (half, n) = (column.half(), forward.len());
    // With h = u + i v: a + i b at k, and at -k, where both are the conjugates, conj(a - i b).
    let value = |i: usize| {
        let (h, kz, chop) = column.mode(i);
        let (h, a, b) = value(h, column.kx, kz, chop);
        (
            Complex32::new(h.re * a - h.im * b, h.im * a + h.re * b),
            Complex32::new(h.re * a + h.im * b, h.re * b - h.im * a),
        )
    };
    forward[half + 1..n - half].fill(Complex32::ZERO);
    if column.kx == 0.0 {
        // Both ways along z stand in this one column.
        for (i, place) in forward[..=half].iter_mut().enumerate() {
            *place = value(half + i).0;
        }
        for (i, place) in forward[n - half..].iter_mut().enumerate() {
            *place = value(i).0;
        }
        return;
    }
    backward[half + 1..n - half].fill(Complex32::ZERO);
    (forward[0], backward[0]) = value(half);
    for (i, (forward, backward)) in forward[1..=half].iter_mut().zip(backward[n - half..].iter_mut().rev()).enumerate()
    {
        (*forward, *backward) = value(half + 1 + i);
    }
    for (i, (forward, backward)) in forward[n - half..].iter_mut().zip(backward[1..=half].iter_mut().rev()).enumerate()
    {
        (*forward, *backward) = value(i);
    }
}
