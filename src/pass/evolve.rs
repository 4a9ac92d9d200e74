//! Turns every mode to a tick: h(k, t) = h0(k) e^-i phi + conj(h0(-k)) e^+i phi, and its derivatives in k space.

use rustfft::num_complex::{Complex32, Complex64};

use crate::plan::Field;
use crate::sea::{CascadeModes, cos_sin_q24};

/// A cascade's modes as f32, with the factor that makes each field out of the height.
#[derive(Debug, Default)]
pub struct EvolveTable {
    modes: Vec<TurningMode>,
    /// Angular frequency of each mode, rad/s.
    omegas: Vec<f32>,
    /// Of height, displacement, slopes and derivatives, in the order of `modes`.
    factors: [Vec<f32>; 8],
}

#[derive(Clone, Copy, Debug)]
struct TurningMode {
    forward: Complex32,
    backward: Complex32,
    cycles: u32,
    offset: u32,
}

impl EvolveTable {
    /// Rounds a cascade's modes to f32. `choppiness` goes into every sideways field.
    pub fn new(cascade: &CascadeModes, choppiness: f64, repeat: u64) -> Self {
        let single = |z: Complex64| Complex32::new(z.re as f32, z.im as f32);
        let turning = cascade.modes.iter().map(|mode| TurningMode {
            forward: single(mode.forward),
            backward: single(mode.backward),
            cycles: mode.cycles,
            offset: mode.offset,
        });
        let factors = std::array::from_fn(|field| {
            let factor = |(kx, kz, mode): (f64, f64, &crate::sea::Mode)| {
                factor(Field::SPECTRAL[field], kx, kz, choppiness * mode.widening) as f32
            };
            cascade.with_wave_vectors().map(factor).collect()
        });
        let omegas = cascade.modes.iter().map(|mode| mode.omega(repeat) as f32).collect();
        Self { modes: turning.collect(), omegas, factors }
    }

    /// h(k, t) of every mode at a turn of the repeat period, metres.
    pub fn heights(&self, turn: u32, heights: &mut [Complex32]) {
        for (height, mode) in heights.iter_mut().zip(&self.modes) {
            let (c, s) = mode.cos_sin(turn);
            let (a, b) = (mode.forward, mode.backward);
            *height = Complex32::new((a.re + b.re) * c + (a.im - b.im) * s, (a.im + b.im) * c + (b.re - a.re) * s);
        }
    }

    /// dh/dt of every mode, m/s: -i w times the part that travels along +k, +i w times the other.
    pub fn rates(&self, turn: u32, rates: &mut [Complex32]) {
        for ((rate, mode), omega) in rates.iter_mut().zip(&self.modes).zip(&self.omegas) {
            let (c, s) = mode.cos_sin(turn);
            let (a, b) = (mode.forward, mode.backward);
            let (re, im) = ((a.re - b.re) * c + (a.im + b.im) * s, (a.im - b.im) * c - (a.re + b.re) * s);
            *rate = Complex32::new(omega * im, -omega * re);
        }
    }

    /// Factor of each mode for a spectral field, and whether it stands beside an i. A velocity is the rate of what
    /// moves: its factor is that of the displacement.
    ///
    /// # Panics
    /// If `field` is not spectral.
    pub fn factors(&self, field: Field) -> (&[f32], bool) {
        let moves = match field {
            Field::VelocityX => Field::Dx,
            Field::VelocityY => Field::Height,
            Field::VelocityZ => Field::Dz,
            field => field,
        };
        (&self.factors[moves as usize], is_odd(moves))
    }
}

impl TurningMode {
    #[inline]
    fn cos_sin(&self, turn: u32) -> (f32, f32) {
        const Q24: f32 = 1.0 / 16_777_216.0;
        let (cos, sin) = cos_sin_q24(self.cycles.wrapping_mul(turn).wrapping_add(self.offset));
        (cos as f32 * Q24, sin as f32 * Q24)
    }
}

/// An odd number of derivatives: the factor stands beside an i.
fn is_odd(field: Field) -> bool {
    matches!(field, Field::Dx | Field::Dz | Field::SlopeX | Field::SlopeZ)
}

/// Real factor that makes `field` out of the height of wave vector (kx, kz); `chop` is choppiness times widening.
///
/// D = i (k / |k|) h, so crests sharpen; its derivatives are i k of that (Tessendorf 2001, eq. 44, with our sign).
fn factor(field: Field, kx: f64, kz: f64, chop: f64) -> f64 {
    let k = libm::sqrt(kx * kx + kz * kz);
    if k == 0.0 {
        return 0.0;
    }
    match field {
        Field::Height => 1.0,
        Field::Dx => chop * kx / k,
        Field::Dz => chop * kz / k,
        Field::SlopeX => kx,
        Field::SlopeZ => kz,
        Field::Dxx => -chop * kx * kx / k,
        Field::Dzz => -chop * kz * kz / k,
        Field::Dxz => -chop * kx * kz / k,
        _ => 0.0,
    }
}
