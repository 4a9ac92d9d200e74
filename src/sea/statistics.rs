//! What a sea is like in numbers: heights, periods, slopes and directions, from the energies of its modes.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::Serialize;

use super::dispersion::Dispersion;
use super::layout::Cascade;
use super::strain::Strain;
use crate::scene::wmo_sea_state;

/// Frequencies are told apart by this ratio.
pub const FREQUENCY_BIN: f64 = 1.03;

/// Statistics of a sea: expectations over all phases, not of one moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Significant wave height of the modes, 4 sqrt(m0), metres.
    pub hs_m: f64,
    /// The same of the spectrum that is wanted, resolved or not.
    pub wanted_hs_m: f64,
    /// Zeroth moment of the modes, m^2.
    pub m0_m2: f64,
    /// Zeroth moment of the spectrum that is wanted, m^2.
    pub wanted_m0_m2: f64,
    /// Sea state by WMO code 3700.
    pub sea_state: u8,
    /// Peak period, seconds, to 3 %; null for a flat sea.
    pub tp_s: Option<f64>,
    /// Mean zero-crossing period 2 pi sqrt(m0 / m2), seconds; null for a flat sea.
    pub tz_s: Option<f64>,
    /// Mean square of the slope of the surface at rest, resolved waves only.
    pub mean_square_slope: f64,
    /// Significant steepness 2 pi Hs / (g Tz^2); null for a flat sea.
    pub steepness: Option<f64>,
    /// Mean direction that waves come from, degrees clockwise from north; null where none prevails.
    pub direction_from_deg: Option<f64>,
    /// Spread of directions, degrees (Kuik et al. 1988); null for a flat sea.
    pub spread_deg: Option<f64>,
    /// Share of the area that foam covers.
    pub foam_coverage: f64,
    /// Share of the surface that folds over itself: Jacobian of all cascades below 0.
    pub folded_fraction: f64,
}

impl Statistics {
    /// Of cascades with the energies of their modes (as in an energy table, m^2), and the share of the sea's energy that
    /// their layout has: 1 but while layouts cross-fade.
    pub fn new<'a>(
        dispersion: &Dispersion,
        cascades: impl Iterator<Item = (&'a Cascade, f64, Vec<f64>)>,
        wanted_hs_m: f64,
        foam_coverage: f64,
        choppiness: f64,
    ) -> Self {
        let mut bins = Bins::default();
        let (mut m0, mut m2, mut slope, mut x, mut z) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut strain = Strain::default();
        for (cascade, share, energy) in cascades.filter(|(_, share, _)| *share > 0.0) {
            for ((kx, kz), e) in cascade.wave_vectors().zip(&energy) {
                let k = libm::hypot(kx, kz);
                if k == 0.0 {
                    continue;
                }
                let omega = dispersion.omega(k);
                (m0, m2, slope) = (m0 + e, m2 + omega * omega * e, slope + k * k * e);
                (x, z) = (x + e * kx / k, z + e * kz / k);
                bins.spread(dispersion, cascade, share, k, *e);
            }
            strain = strain.plus(&Strain::of_cascade(dispersion, cascade, &energy));
        }
        let moving = m0 > 0.0;
        let tz = 2.0 * PI * libm::sqrt(m0 / m2);
        let hs = 4.0 * libm::sqrt(m0);
        let r1 = libm::hypot(x, z) / m0;
        let folds = moving && choppiness > 0.0;
        Self {
            hs_m: hs,
            wanted_hs_m,
            m0_m2: m0,
            wanted_m0_m2: wanted_hs_m * wanted_hs_m / 16.0,
            sea_state: wmo_sea_state(hs),
            tp_s: bins.peak(dispersion).map(|omega| 2.0 * PI / omega),
            tz_s: moving.then_some(tz),
            mean_square_slope: slope,
            steepness: moving.then(|| 2.0 * PI * hs / (dispersion.water().gravity * tz * tz)),
            // Travel toward (x, z) comes from (-x, -z); z points south.
            direction_from_deg: (moving && r1 > 1e-3).then(|| libm::atan2(-x, z).to_degrees().rem_euclid(360.0)),
            spread_deg: moving.then(|| libm::sqrt(2.0 * (1.0 - r1).max(0.0)).to_degrees()),
            foam_coverage,
            folded_fraction: if folds { strain.below(0.0, choppiness) } else { 0.0 },
        }
    }
}

/// Energy by frequency, in bins of equal ratio, beside the area of the wave-vector plane that holds it.
#[derive(Debug, Default)]
struct Bins(BTreeMap<i32, (f64, f64)>);

impl Bins {
    /// Spreads the cell of a mode evenly over the logarithm of its frequencies. Where cascades share the plane, each has
    /// its share of the area, too, so that densities stay true however coarse the cells are.
    fn spread(&mut self, dispersion: &Dispersion, cascade: &Cascade, share: f64, k: f64, energy: f64) {
        let dk = cascade.dk();
        let weight = [-0.4, -0.2, 0.0, 0.2, 0.4].map(|off| cascade.weight(k + off * dk)).iter().sum::<f64>() / 5.0;
        if weight == 0.0 && energy == 0.0 {
            return;
        }
        let at = |k: f64| libm::log(dispersion.omega(k)) / libm::log(FREQUENCY_BIN);
        let (low, high) = (at((k - 0.5 * dk).max(0.25 * dk)), at(k + 0.5 * dk));
        for bin in low.floor() as i32..=high.floor() as i32 {
            let inside = (high.min(f64::from(bin + 1)) - low.max(f64::from(bin))) / (high - low);
            let (sum, area) = self.0.entry(bin).or_default();
            (*sum, *area) = (*sum + energy * inside, *area + share * weight * dk * dk * inside);
        }
    }

    /// Angular frequency of the highest density S(w), rad/s.
    fn peak(&self, dispersion: &Dispersion) -> Option<f64> {
        let centre = |bin: i32| libm::pow(FREQUENCY_BIN, f64::from(bin) + 0.5);
        let density = |bin: i32, energy: f64, area: f64| {
            let k = dispersion.wavenumber(centre(bin));
            if area > 0.0 { energy / area * k / dispersion.group_velocity(k) } else { 0.0 }
        };
        let densities = self.0.iter().map(|(bin, (energy, area))| (*bin, density(*bin, *energy, *area)));
        let (bin, highest) = densities.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (highest > 0.0).then(|| centre(bin))
    }
}
