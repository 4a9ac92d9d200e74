//! The horizontal strain of the surface, Dxx, Dzz and Dxz at choppiness 1: normal numbers, known by their covariance.

use super::dispersion::Dispersion;
use super::layout::Cascade;

/// Covariance of (Dxx, Dxz, Dzz): xx, x-xz, x-zz, xz, xz-zz, zz in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strain([f64; 6]);

/// Lower triangle of the covariance's root, row by row.
pub type Root = [f64; 6];

impl Strain {
    /// Of one mode of wave vector (kx, kz) and energy `energy`, m^2.
    pub fn of_mode(dispersion: &Dispersion, kx: f64, kz: f64, energy: f64) -> Self {
        let k = libm::hypot(kx, kz);
        if k == 0.0 {
            return Self::default();
        }
        let widened = dispersion.depth_widening(k);
        let (xx, xz, zz) = (kx * kx / k, kx * kz / k, kz * kz / k);
        let e = energy * widened * widened;
        Self([e * xx * xx, e * xx * xz, e * xx * zz, e * xz * xz, e * xz * zz, e * zz * zz])
    }

    /// Of all modes of a cascade, whose energies stand in rows of m, each of n.
    pub fn of_cascade(dispersion: &Dispersion, cascade: &Cascade, energy: &[f64]) -> Self {
        let modes = cascade.wave_vectors().zip(energy);
        modes.fold(Self::default(), |sum, ((kx, kz), e)| sum.plus(&Self::of_mode(dispersion, kx, kz, *e)))
    }

    /// Of two independent parts.
    pub fn plus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    /// With every variance multiplied.
    pub fn times(&self, factor: f64) -> Self {
        Self(self.0.map(|c| factor * c))
    }

    /// Standard deviation of the stretch Dxx + Dzz.
    pub fn stretch(&self) -> f64 {
        libm::sqrt(self.0[0] + 2.0 * self.0[2] + self.0[5])
    }

    /// Root of the covariance (Cholesky): what makes (Dxx, Dxz, Dzz) of three independent numbers.
    pub fn root(&self) -> Root {
        let [a, ab, ac, b, bc, c] = self.0;
        let divide = |x: f64, y: f64| if y > 0.0 { x / y } else { 0.0 };
        let l11 = libm::sqrt(a);
        let (l21, l31) = (divide(ab, l11), divide(ac, l11));
        let l22 = libm::sqrt((b - l21 * l21).max(0.0));
        let l32 = divide(bc - l31 * l21, l22);
        let l33 = libm::sqrt((c - l31 * l31 - l32 * l32).max(0.0));
        [l11, l21, l22, l31, l32, l33]
    }

    /// Probability that the Jacobian (1 + l Dxx)(1 + l Dzz) - (l Dxz)^2 lies below a value, at choppiness l.
    pub fn below(&self, jacobian: f64, choppiness: f64) -> f64 {
        // Two of the numbers on a grid of 8 deviations each way; the third by its normal distribution.
        const SIDE: i32 = 40;
        let [l11, l21, l22, l31, l32, l33] = self.times(choppiness * choppiness).root();
        let weight = |u: f64| libm::exp(-0.5 * u * u);
        let (mut sum, mut total) = (0.0, 0.0);
        for i in -SIDE..=SIDE {
            let u = 0.2 * f64::from(i);
            let xx = l11 * u;
            for j in -SIDE..=SIDE {
                let v = 0.2 * f64::from(j);
                let w = weight(u) * weight(v);
                let xz = l21 * u + l22 * v;
                let mean = 1.0 + l31 * u + l32 * v;
                let edge = (jacobian + xz * xz) / (1.0 + xx);
                // A deviation of nothing is a step.
                let under = 0.5 * libm::erfc((mean - edge) / (std::f64::consts::SQRT_2 * l33.max(1e-12)));
                sum += w * if 1.0 + xx > 0.0 { under } else { 1.0 - under };
                total += w;
            }
        }
        sum / total
    }
}
