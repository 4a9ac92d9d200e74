//! Below which Jacobian a sea foams, so that whitecaps follow the wind.

use super::table::EnergyTable;
use crate::scene::{Foam, SeaState};

/// How much more area holds foam than is breaking at one moment, since foam outlives its breaker.
const PERSISTENCE: f64 = 3.0;
/// Thresholds stay where foam is neither everywhere nor missing from a folded crest.
const BOUNDS: (f64, f64) = (0.0, 0.95);

/// The threshold of a sea state.
///
/// Wanted coverage is 3.84e-6 U10^3.41 (Monahan & O'Muircheartaigh 1980, eq. 5); the Jacobian of each cascade is taken
/// as normal, 1 - lambda (k-weighted height), with variance lambda^2 times its mean square slope. Without wind only
/// folded water foams.
pub fn foam_threshold(state: &SeaState, table: &EnergyTable, choppiness: f64, foam: &Foam) -> f64 {
    let wind = state.wind.map_or(0.0, |wind| wind.speed_mps);
    let wanted = (foam.gain * 3.84e-6 * libm::pow(wind, 3.41)).min(1.0) / PERSISTENCE;
    let deviations = table.mean_square_slope.iter().map(|mss| choppiness * libm::sqrt(*mss)).filter(|d| *d > 0.0);
    let deviations: Vec<f64> = deviations.collect();
    let breaking = |threshold: f64| -> f64 {
        deviations.iter().map(|d| 0.5 * libm::erfc((1.0 - threshold) / (d * std::f64::consts::SQRT_2))).sum()
    };
    let (mut low, mut high) = BOUNDS;
    if breaking(low) >= wanted {
        return low;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if breaking(middle) < wanted { low = middle } else { high = middle }
    }
    low
}
