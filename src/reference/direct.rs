//! The plain sum over all modes at one point, with velocity.

use std::f64::consts::PI;

use crate::plan::Field;
use crate::sea::{CascadeModes, Mode, Sea};
use crate::wire::TICKS_PER_SECOND;
use rustfft::num_complex::Complex64;

/// Everything of the water particle that rests at one point, summed over the given cascades.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Spectral fields in the order of [`Field`]: height, dx, dz, slopes, derivatives, velocity.
    pub fields: [f64; 11],
}

/// Angle in turns that a mode has made at a tick: exactly M tick / P, and its offset.
pub(super) fn phase(mode: &Mode, tick: i64, repeat: u64) -> f64 {
    let within = i128::from(tick).rem_euclid(i128::from(repeat)) as u128;
    let cycles = (u128::from(mode.cycles) * within) % u128::from(repeat);
    cycles as f64 / repeat as f64 + f64::from(mode.offset) / 4_294_967_296.0
}

/// h(k, t) and its derivative in time.
pub(super) fn height(mode: &Mode, tick: i64, repeat: u64) -> (Complex64, Complex64) {
    let angle = 2.0 * PI * phase(mode, tick, repeat);
    let turned = Complex64::new(libm::cos(angle), -libm::sin(angle));
    let (forward, backward) = (mode.forward * turned, mode.backward * turned.conj());
    let omega = 2.0 * PI * TICKS_PER_SECOND as f64 * f64::from(mode.cycles) / repeat as f64;
    (forward + backward, Complex64::new(0.0, -omega) * (forward - backward))
}

/// What makes a field out of the height of wave vector (kx, kz): written as the derivatives it stands for, on its own,
/// so that an error in the table of the fast path shows.
pub(super) fn operator(field: Field, kx: f64, kz: f64, chop: f64) -> Complex64 {
    let (along_x, along_z) = (Complex64::new(0.0, kx), Complex64::new(0.0, kz));
    let k = libm::hypot(kx, kz);
    if k == 0.0 {
        return Complex64::ZERO;
    }
    let (dx, dz) = (along_x * (chop / k), along_z * (chop / k));
    match field {
        Field::Height => Complex64::ONE,
        Field::Dx => dx,
        Field::Dz => dz,
        Field::SlopeX => along_x,
        Field::SlopeZ => along_z,
        Field::Dxx => along_x * dx,
        Field::Dzz => along_z * dz,
        Field::Dxz => along_z * dx,
        _ => Complex64::ZERO,
    }
}

/// The moving field whose rate a velocity is; `None` for a field that is no velocity.
pub(super) fn rate_of(field: Field) -> Option<Field> {
    match field {
        Field::VelocityX => Some(Field::Dx),
        Field::VelocityY => Some(Field::Height),
        Field::VelocityZ => Some(Field::Dz),
        _ => None,
    }
}

/// The water particle that rests at (x0, z0), at a tick, from these cascades of a sea.
pub fn at(sea: &Sea, cascades: &[CascadeModes], tick: i64, x0: f64, z0: f64) -> Point {
    let mut point = Point::default();
    for cascade in cascades {
        for (kx, kz, mode) in cascade.with_wave_vectors() {
            // Modes with n > 0 stand for their conjugates, too.
            let twice = if kx == 0.0 { 1.0 } else { 2.0 };
            let angle = kx * x0 + kz * z0;
            let wave = Complex64::new(twice * libm::cos(angle), twice * libm::sin(angle));
            let (h, rate) = height(mode, tick, sea.repeat);
            let chop = sea.choppiness * mode.widening;
            for (value, field) in point.fields.iter_mut().zip(Field::SPECTRAL) {
                let (moves, source) = rate_of(field).map_or((field, h), |moves| (moves, rate));
                *value += (operator(moves, kx, kz, chop) * source * wave).re;
            }
        }
    }
    point
}
