//! A buoy's record as a directional spectrum: density between bins by straight lines, directions by maximum entropy.
//!
//! Straight lines through the bins' densities integrate to the record's own sum of S df, so Hs is kept.
//! The maximum-entropy form (Lygre & Krogstad 1986) keeps both measured Fourier coefficients and is never negative. The
//! series of the coefficients alone is, in most bins of real records: clipped, it turns and widens the sea.

use std::f64::consts::{FRAC_PI_2, PI};

use rustfft::num_complex::Complex64;

use crate::scene::{DirectionMethod, MeasuredSpectrum, Spread};

/// How near to a single direction a spreading may come: past it the form is a spike that no grid resolves.
const MOST_FOCUSED: f64 = 0.98;

/// A record ready to be evaluated.
#[derive(Clone, Debug)]
pub struct MeasuredSea {
    bins: Vec<Bin>,
    infeasible: usize,
    missing: usize,
    clipping: Option<Clipping>,
}

/// What clipping the Fourier series did to a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clipping {
    /// Bins with energy whose series went negative.
    pub bins: usize,
    /// By how much the mean direction of the whole record turned, degrees.
    pub direction_deg: f64,
    /// By how much its spread grew, degrees.
    pub spread_deg: f64,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    omega: f64,
    /// S(w), m^2 s.
    density: f64,
    form: Form,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    /// Second-order autoregressive form of the spreading: numerator and two coefficients.
    Entropy { power: f64, phi1: Complex64, phi2: Complex64 },
    /// The series of two terms where it is positive, and what makes its integral 1.
    Series { c1: Complex64, c2: Complex64, scale: f64 },
}

impl MeasuredSea {
    /// Prepares a record.
    pub fn new(record: &MeasuredSpectrum) -> Self {
        let (mut infeasible, mut missing) = (0, 0);
        let series = record.directions() == DirectionMethod::Fourier;
        let mut bins: Vec<Bin> = (record.bins().iter())
            .map(|bin| {
                missing += usize::from(bin.direction.is_none() && bin.density > 0.0);
                let form = match bin.direction {
                    Some(spread) if series => Form::series(raw_coefficients(spread)),
                    Some(spread) => {
                        infeasible += usize::from(bin.density > 0.0 && !feasible(spread));
                        Form::entropy(focused(spread))
                    }
                    None => Form::entropy([Complex64::ZERO; 2]),
                };
                Bin { omega: 2.0 * PI * bin.frequency_hz, density: bin.density / (2.0 * PI), form }
            })
            .collect();
        let clipping = series.then(|| clipping(record, &bins)).flatten();
        // Beyond its ends the density falls to nothing over one more spacing.
        let (first, last) = (bins[0], bins[bins.len() - 1]);
        let below = (2.0 * first.omega - bins[1].omega).max(0.5 * first.omega);
        let above = 2.0 * last.omega - bins[bins.len() - 2].omega;
        bins.insert(0, Bin { omega: below, density: 0.0, ..first });
        bins.push(Bin { omega: above, density: 0.0, ..last });
        Self { bins, infeasible, missing, clipping }
    }

    /// S(w) D(w, theta), m^2 s / rad; (cos theta, sin theta) = (x, z) is the unit vector of travel.
    pub fn density(&self, omega: f64, toward: (f64, f64)) -> f64 {
        self.between(omega, |bin| if bin.density > 0.0 { bin.density * bin.form.spreading(toward) } else { 0.0 })
    }

    /// S(w), m^2 s, over all directions.
    pub fn over_frequency(&self, omega: f64) -> f64 {
        self.between(omega, |bin| bin.density)
    }

    /// What the bins on both sides of a frequency have, joined by a straight line.
    fn between(&self, omega: f64, value: impl Fn(&Bin) -> f64) -> f64 {
        let i = self.bins.partition_point(|bin| bin.omega <= omega);
        if i == 0 || i == self.bins.len() {
            return 0.0;
        }
        let (low, high) = (&self.bins[i - 1], &self.bins[i]);
        let t = (omega - low.omega) / (high.omega - low.omega);
        (1.0 - t) * value(low) + t * value(high)
    }

    /// Range of angular frequency that holds energy, rad/s.
    pub fn range(&self) -> (f64, f64) {
        (self.bins[0].omega, self.bins[self.bins.len() - 1].omega)
    }

    /// Bins with energy whose coefficients no spreading can have; they were brought to the nearest that one can.
    pub fn infeasible(&self) -> usize {
        self.infeasible
    }

    /// What clipping did, for a Fourier series.
    pub fn clipping(&self) -> Option<Clipping> {
        self.clipping
    }

    /// Bins with energy but without directions; they spread evenly.
    pub fn missing(&self) -> usize {
        self.missing
    }
}

/// First two Fourier coefficients over the angle of travel, as measured.
fn raw_coefficients(spread: Spread) -> [Complex64; 2] {
    // Waves from alpha (clockwise from north) travel toward atan2(z, x) = alpha + 90 degrees.
    let travel = |from_deg: f64| from_deg.to_radians() + FRAC_PI_2;
    let (a1, a2) = (travel(spread.alpha1_deg), travel(spread.alpha2_deg));
    let c1 = Complex64::new(spread.r1 * libm::cos(a1), spread.r1 * libm::sin(a1));
    let c2 = Complex64::new(spread.r2 * libm::cos(2.0 * a2), spread.r2 * libm::sin(2.0 * a2));
    [c1, c2]
}

/// Whether some spreading has these coefficients: |c2 - c1^2| <= 1 - |c1|^2.
fn feasible(spread: Spread) -> bool {
    let [c1, c2] = raw_coefficients(spread);
    libm::sqrt((c2 - c1 * c1).norm_sqr()) <= 1.0 - c1.norm_sqr() + 1e-9
}

/// The coefficients, brought to the nearest that a spreading can have and that is no spike.
fn focused(spread: Spread) -> [Complex64; 2] {
    let r1 = spread.r1.min(MOST_FOCUSED);
    let [c1, c2] = raw_coefficients(Spread { r1, ..spread });
    let (centre, radius) = (c1 * c1, MOST_FOCUSED * (1.0 - c1.norm_sqr()));
    let off = c2 - centre;
    let distance = libm::sqrt(off.norm_sqr());
    if distance <= radius { [c1, c2] } else { [c1, centre + off * (radius / distance)] }
}

/// Angles over which a clipped series is integrated.
const ANGLES: u32 = 720;

fn around() -> impl Iterator<Item = (f64, f64)> {
    (0..ANGLES).map(|i| {
        let theta = 2.0 * PI * f64::from(i) / f64::from(ANGLES);
        (libm::cos(theta), libm::sin(theta))
    })
}

impl Form {
    fn entropy([c1, c2]: [Complex64; 2]) -> Self {
        let phi1 = (c1 - c2 * c1.conj()) / (1.0 - c1.norm_sqr());
        let phi2 = c2 - c1 * phi1;
        let power = (1.0 - phi1 * c1.conj() - phi2 * c2.conj()).re;
        Self::Entropy { power, phi1, phi2 }
    }

    fn series([c1, c2]: [Complex64; 2]) -> Self {
        let plain = Self::Series { c1, c2, scale: 1.0 };
        let sum: f64 = around().map(|toward| plain.spreading(toward)).sum();
        Self::Series { c1, c2, scale: f64::from(ANGLES) / (2.0 * PI * sum) }
    }

    /// D(theta), 1/rad.
    fn spreading(&self, (x, z): (f64, f64)) -> f64 {
        let turn = Complex64::new(x, -z);
        match *self {
            Self::Entropy { power, phi1, phi2 } => {
                let whitened = 1.0 - phi1 * turn - phi2 * turn * turn;
                power / (2.0 * PI * whitened.norm_sqr())
            }
            Self::Series { c1, c2, scale } => scale * ((0.5 + (c1 * turn).re + (c2 * turn * turn).re) / PI).max(0.0),
        }
    }

    /// First Fourier coefficient of the form as it is evaluated.
    fn first_coefficient(&self) -> Complex64 {
        let term = |(x, z)| Complex64::new(x, z) * self.spreading((x, z));
        around().map(term).sum::<Complex64>() * (2.0 * PI / f64::from(ANGLES))
    }
}

/// What clipping did to the whole record; `None` where it has no direction.
fn clipping(record: &MeasuredSpectrum, bins: &[Bin]) -> Option<Clipping> {
    let (from, spread) = record.direction_and_spread_deg()?;
    let m0 = record.m0();
    let (mut clipped, mut mean) = (0, Complex64::ZERO);
    for (i, bin) in bins.iter().enumerate().filter(|(_, bin)| bin.density > 0.0) {
        clipped += usize::from(matches!(bin.form, Form::Series { scale, .. } if scale < 1.0 - 1e-9));
        mean += bin.form.first_coefficient() * (record.energy(i) / m0);
    }
    let turned = libm::atan2(mean.im, mean.re).to_degrees() - 90.0 - from;
    Some(Clipping {
        bins: clipped,
        direction_deg: (turned + 180.0).rem_euclid(360.0) - 180.0,
        spread_deg: libm::sqrt(2.0 * (1.0 - libm::sqrt(mean.norm_sqr())).max(0.0)).to_degrees() - spread,
    })
}
