//! Below which Jacobian a sea foams, so that whitecaps follow the wind.

use super::layout::{Cascade, Layout};
use super::table::EnergyTable;
use crate::scene::{Foam, SeaState};

/// Area that holds foam above .1 over the area that is below the threshold at one moment: foam outlives its breaker,
/// but not all of what is below has grown to .1. Fitted on the presets of Beaufort 4 to 10 (`swellcast export`), where
/// coverage then is .4 to 1.2 times the wanted one.
const PERSISTENCE: f64 = 3.0;
/// Thresholds stay where foam is neither everywhere nor missing from a folded crest.
const BOUNDS: (f64, f64) = (0.0, 0.95);

/// Waves shorter than this break without catching air (Jessup et al. 1997 call it microbreaking), metres.
const SHORTEST_WHITECAP_M: f64 = 2.5;
/// Threshold of a cascade that never foams: no Jacobian comes near it.
const NEVER: f64 = -1e6;

/// The threshold of each cascade for a sea state.
///
/// Wanted coverage is 3.84e-6 U10^3.41 (Monahan & O'Muircheartaigh 1980, eq. 5); the Jacobian of each cascade is taken
/// as normal, 1 - lambda (k-weighted height), with the variance of its horizontal stretch. All cascades with
/// waves long enough share one threshold. Without wind only folded water foams.
pub fn foam_thresholds(
    state: &SeaState,
    layout: &Layout,
    table: &EnergyTable,
    choppiness: f64,
    foam: &Foam,
) -> Vec<f64> {
    let wind = state.wind.map_or(0.0, |wind| wind.speed_mps);
    let wanted = (foam.gain * 3.84e-6 * libm::pow(wind, 3.41)).min(1.0) / PERSISTENCE;
    let foams = |cascade: &Cascade| cascade.longest_m() >= SHORTEST_WHITECAP_M;
    let deviations: Vec<f64> = (layout.cascades.iter().zip(&table.stretch_variance))
        .filter(|(cascade, variance)| foams(cascade) && **variance > 0.0)
        .map(|(_, variance)| choppiness * libm::sqrt(*variance))
        .collect();
    let breaking = |threshold: f64| -> f64 {
        deviations.iter().map(|d| 0.5 * libm::erfc((1.0 - threshold) / (d * std::f64::consts::SQRT_2))).sum()
    };
    let (mut low, mut high) = BOUNDS;
    if breaking(low) < wanted {
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if breaking(middle) < wanted { low = middle } else { high = middle }
        }
    }
    layout.cascades.iter().map(|cascade| if foams(cascade) { low } else { NEVER }).collect()
}
