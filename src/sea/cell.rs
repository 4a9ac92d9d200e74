//! Energy of one mode: the integral of the spectrum over its cell of the wave-vector plane, by adaptive quadrature.
//!
//! Sampling the centre instead loses 3 % of Hs in a narrow swell. Points are spent only where the integrand bends.

/// Gauss-Legendre nodes and weights on [-1, 1], two and three points.
const TWO: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
const THREE: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// A cell is halved at most this often.
const MAX_DEPTH: u32 = 5;
/// Accepted difference between the two rules, relative to the cell.
const RELATIVE: f64 = 2e-3;

/// A square in the wave-vector plane, rad/m.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Centre.
    pub kx: f64,
    /// Centre.
    pub kz: f64,
    /// Half of the side.
    pub half: f64,
}

impl Cell {
    /// Integral of `density` over the cell. `split` pieces a side to begin with; differences below `negligible`
    /// are not followed up.
    pub fn integral(&self, density: &impl Fn(f64, f64) -> f64, split: u32, negligible: f64) -> f64 {
        let half = self.half / f64::from(split);
        let mut sum = 0.0;
        for i in 0..split {
            for j in 0..split {
                let at = |i: u32| -self.half + half * f64::from(2 * i + 1);
                let part = Self { kx: self.kx + at(i), kz: self.kz + at(j), half };
                sum += part.adaptive(density, MAX_DEPTH, negligible / f64::from(split * split));
            }
        }
        sum
    }

    fn adaptive(&self, density: &impl Fn(f64, f64) -> f64, depth: u32, negligible: f64) -> f64 {
        let fine = self.rule(density, &THREE);
        let coarse = self.rule(density, &TWO);
        let difference = libm::fabs(fine - coarse);
        if depth == 0 || difference <= RELATIVE * fine || difference <= negligible {
            return fine;
        }
        let half = 0.5 * self.half;
        let part = |sx: f64, sz: f64| {
            let cell = Self { kx: self.kx + sx * half, kz: self.kz + sz * half, half };
            cell.adaptive(density, depth - 1, 0.25 * negligible)
        };
        part(-1.0, -1.0) + part(1.0, -1.0) + part(-1.0, 1.0) + part(1.0, 1.0)
    }

    fn rule(&self, density: &impl Fn(f64, f64) -> f64, points: &[(f64, f64)]) -> f64 {
        let mut sum = 0.0;
        for (x, wx) in points {
            for (z, wz) in points {
                sum += wx * wz * density(self.kx + x * self.half, self.kz + z * self.half);
            }
        }
        sum * self.half * self.half
    }
}
