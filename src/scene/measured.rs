//! A directional spectrum as a buoy reports it, checked.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};

/// One frequency of a record. Directions are where the waves come **from**, degrees clockwise from north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredBin {
    /// Centre frequency, Hz.
    pub frequency_hz: f64,
    /// Wave density, m^2/Hz.
    pub density: f64,
    /// Directions; `None` when one of the four numbers is missing, and the bin then spreads evenly.
    pub direction: Option<Spread>,
}

/// The first two Fourier coefficients of the spreading, in polar form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean direction, degrees.
    pub alpha1_deg: f64,
    /// Principal direction, degrees.
    pub alpha2_deg: f64,
    /// First coefficient, 0 to 1.
    pub r1: f64,
    /// Second coefficient, 0 to 1.
    pub r2: f64,
}

/// How a spreading function is made of the four numbers of a frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DirectionMethod {
    /// Maximum entropy (Lygre & Krogstad 1986): keeps both coefficients, is never negative.
    #[default]
    MaximumEntropy,
    /// The series of two terms, clipped where it is negative and normalised anew: shifts directions by degrees.
    Fourier,
}

/// A whole record: at least two bins in ascending frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSpectrum {
    /// Shared, since every state of a sea carries its record along.
    bins: Arc<[MeasuredBin]>,
    directions: DirectionMethod,
}

impl MeasuredSpectrum {
    /// Most bins a record may have.
    pub const MAX_BINS: usize = 1024;

    /// Least ratio of neighbouring frequencies.
    pub const LEAST_RATIO: f64 = 1.01;

    /// Checks a record.
    ///
    /// # Errors
    /// [`SceneError::Bound`] when there are fewer than 2 or more than 1024 bins, when frequencies are not
    /// ascending by 1 % and more from above 0 to 100 Hz, or a number is out of bounds.
    pub fn new(bins: Vec<MeasuredBin>) -> Result<Self, SceneError> {
        if !(2..=Self::MAX_BINS).contains(&bins.len()) {
            let bound = format!("2 to {} frequencies", Self::MAX_BINS);
            return Err(SceneError::bound("measured.bins", bins.len(), bound));
        }
        let mut last = 0.0;
        for (i, bin) in bins.iter().enumerate() {
            let check = |name: &str, value: f64, low: f64, high: f64| {
                within(&format!("measured.bins[{i}].{name}"), value, low, high)
            };
            let frequency = check("frequency_hz", bin.frequency_hz, 1e-4, 100.0)?;
            // Nearer ones would make a spike that no grid resolves.
            if frequency < last * Self::LEAST_RATIO {
                let field = format!("measured.bins[{i}].frequency_hz");
                let bound = format!("at least {} times {last}, the one before", Self::LEAST_RATIO);
                return Err(SceneError::bound(field, frequency, bound));
            }
            last = frequency;
            check("density", bin.density, 0.0, 1e5)?;
            if let Some(spread) = bin.direction {
                check("alpha1", spread.alpha1_deg, -360.0, 360.0)?;
                check("alpha2", spread.alpha2_deg, -360.0, 360.0)?;
                check("r1", spread.r1, 0.0, 1.0)?;
                check("r2", spread.r2, 0.0, 1.0)?;
            }
        }
        Ok(Self { bins: bins.into(), directions: DirectionMethod::default() })
    }

    /// The same record with its directions made otherwise.
    pub fn with_directions(self, directions: DirectionMethod) -> Self {
        Self { directions, ..self }
    }

    /// How its directions are made.
    pub fn directions(&self) -> DirectionMethod {
        self.directions
    }

    /// The bins, in ascending frequency.
    pub fn bins(&self) -> &[MeasuredBin] {
        &self.bins
    }

    /// Zeroth moment, m^2: the sum of S df, where a bin reaches half-way to its neighbours (and as far outward at
    /// the ends, but not below a quarter of the first frequency).
    pub fn m0(&self) -> f64 {
        (0..self.bins.len()).map(|i| self.energy(i)).sum()
    }

    /// Frequency of the highest density, Hz.
    pub fn peak_hz(&self) -> f64 {
        self.bins.iter().max_by(|a, b| a.density.total_cmp(&b.density)).map_or(0.1, |bin| bin.frequency_hz)
    }

    /// Energy of a bin, m^2.
    pub fn energy(&self, i: usize) -> f64 {
        self.bins[i].density * self.width_hz(i)
    }

    /// Mean direction that the waves come from, degrees clockwise from north, and spread, degrees (Kuik et al. 1988),
    /// of the whole record: from its first Fourier coefficients, weighted with S df. `None` where no bin with energy
    /// has a direction.
    pub fn direction_and_spread_deg(&self) -> Option<(f64, f64)> {
        let (mut east, mut north, mut total) = (0.0, 0.0, 0.0);
        for (i, bin) in self.bins.iter().enumerate() {
            let energy = self.energy(i);
            let (r1, from) = bin.direction.map_or((0.0, 0.0), |s| (s.r1, s.alpha1_deg.to_radians()));
            east += energy * r1 * libm::sin(from);
            north += energy * r1 * libm::cos(from);
            total += energy;
        }
        let r1 = libm::hypot(east, north) / total;
        (r1 > 0.0).then(|| {
            let from = libm::atan2(east, north).to_degrees().rem_euclid(360.0);
            (from, libm::sqrt(2.0 * (1.0 - r1)).to_degrees())
        })
    }

    fn width_hz(&self, i: usize) -> f64 {
        let f = |i: usize| self.bins[i].frequency_hz;
        let last = self.bins.len() - 1;
        let below = if i > 0 { f(i) - f(i - 1) } else { (f(1) - f(0)).min(0.5 * f(0)) };
        let above = if i < last { f(i + 1) - f(i) } else { f(last) - f(last - 1) };
        0.5 * (below + above)
    }
}
