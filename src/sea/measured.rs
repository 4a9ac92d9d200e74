//! A buoy's record as a directional spectrum: density between bins by straight lines, directions by maximum entropy.
//!
//! Straight lines through the bins' densities integrate to the record's own sum of S df, so Hs is kept.
//! The maximum-entropy form (Lygre & Krogstad 1986) keeps both measured Fourier coefficients and is never negative.

use std::f64::consts::{FRAC_PI_2, PI};

use rustfft::num_complex::Complex64;

use crate::scene::{MeasuredBin, MeasuredSpectrum, Spread};

/// How near to a single direction a spreading may come: past it the form is a spike that no grid resolves.
const MOST_FOCUSED: f64 = 0.98;

/// A record ready to be evaluated.
#[derive(Clone, Debug)]
pub struct MeasuredSea {
    bins: Vec<Bin>,
    infeasible: usize,
    missing: usize,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    omega: f64,
    /// S(w), m^2 s.
    density: f64,
    /// Second-order autoregressive form of the spreading: numerator and two coefficients.
    power: f64,
    phi1: Complex64,
    phi2: Complex64,
}

impl MeasuredSea {
    /// Prepares a record.
    pub fn new(record: &MeasuredSpectrum) -> Self {
        let (mut infeasible, mut missing) = (0, 0);
        let mut bins: Vec<Bin> = (record.bins().iter())
            .map(|bin| {
                let (r, changed) = bin.direction.map_or(([Complex64::ZERO; 2], false), coefficients);
                infeasible += usize::from(changed);
                missing += usize::from(bin.direction.is_none() && bin.density > 0.0);
                Bin::new(bin, r)
            })
            .collect();
        // Beyond its ends the density falls to nothing over one more spacing.
        let (first, last) = (bins[0], bins[bins.len() - 1]);
        let below = (2.0 * first.omega - bins[1].omega).max(0.5 * first.omega);
        let above = 2.0 * last.omega - bins[bins.len() - 2].omega;
        bins.insert(0, Bin { omega: below, density: 0.0, ..first });
        bins.push(Bin { omega: above, density: 0.0, ..last });
        Self { bins, infeasible, missing }
    }

    /// S(w) D(w, theta), m^2 s / rad; (cos theta, sin theta) = (x, z) is the unit vector of travel.
    pub fn density(&self, omega: f64, toward: (f64, f64)) -> f64 {
        let i = self.bins.partition_point(|bin| bin.omega <= omega);
        if i == 0 || i == self.bins.len() {
            return 0.0;
        }
        let (low, high) = (&self.bins[i - 1], &self.bins[i]);
        let t = (omega - low.omega) / (high.omega - low.omega);
        let part = |bin: &Bin, weight: f64| {
            let energy = weight * bin.density;
            if energy > 0.0 { energy * bin.spreading(toward) } else { 0.0 }
        };
        part(low, 1.0 - t) + part(high, t)
    }

    /// Range of angular frequency that holds energy, rad/s.
    pub fn range(&self) -> (f64, f64) {
        (self.bins[0].omega, self.bins[self.bins.len() - 1].omega)
    }

    /// Bins whose coefficients no spreading can have; their second was brought to the nearest that one can.
    pub fn infeasible(&self) -> usize {
        self.infeasible
    }

    /// Bins with energy but without directions; they spread evenly.
    pub fn missing(&self) -> usize {
        self.missing
    }
}

/// First two Fourier coefficients over the angle of travel, made feasible; whether that changed them.
fn coefficients(spread: Spread) -> ([Complex64; 2], bool) {
    // Waves from alpha (clockwise from north) travel toward atan2(z, x) = alpha + 90 degrees.
    let travel = |from_deg: f64| from_deg.to_radians() + FRAC_PI_2;
    let (a1, a2) = (travel(spread.alpha1_deg), travel(spread.alpha2_deg));
    let r1 = spread.r1.min(MOST_FOCUSED);
    let c1 = Complex64::new(r1 * libm::cos(a1), r1 * libm::sin(a1));
    let c2 = Complex64::new(spread.r2 * libm::cos(2.0 * a2), spread.r2 * libm::sin(2.0 * a2));
    // Feasible: |c2 - c1^2| <= 1 - |c1|^2.
    let (centre, radius) = (c1 * c1, MOST_FOCUSED * (1.0 - c1.norm_sqr()));
    let off = c2 - centre;
    let distance = libm::sqrt(off.norm_sqr());
    if distance <= radius { ([c1, c2], r1 != spread.r1) } else { ([c1, centre + off * (radius / distance)], true) }
}

impl Bin {
    fn new(bin: &MeasuredBin, [c1, c2]: [Complex64; 2]) -> Self {
        let phi1 = (c1 - c2 * c1.conj()) / (1.0 - c1.norm_sqr());
        let phi2 = c2 - c1 * phi1;
        let power = (1.0 - phi1 * c1.conj() - phi2 * c2.conj()).re;
        Self { omega: 2.0 * PI * bin.frequency_hz, density: bin.density / (2.0 * PI), power, phi1, phi2 }
    }

    /// D(theta), 1/rad.
    fn spreading(&self, (x, z): (f64, f64)) -> f64 {
        let turn = Complex64::new(x, -z);
        let whitened = 1.0 - self.phi1 * turn - self.phi2 * turn * turn;
        self.power / (2.0 * PI * whitened.norm_sqr())
    }
}
