//! What of a scene an operator would not expect, in words.

use super::layout::Layout;
use super::spectrum::Spectrum;
use super::table::EnergyTable;
use crate::scene::Scene;
use crate::wire::TICKS_PER_SECOND;

/// Peak periods below which a loop rounds wave speeds noticeably.
const LEAST_PERIODS: f64 = 20.0;
/// Share of the energy that may be missing in silence.
const UNRESOLVED: f64 = 0.01;

/// Warnings about a scene on a layout that holds `table` of it.
pub fn warnings(scene: &Scene, layout: &Layout, table: &EnergyTable) -> Vec<String> {
    let spectrum = Spectrum::new(&scene.sea);
    let mut warnings = Vec::new();
    let seconds = scene.repeat.ticks as f64 / TICKS_PER_SECOND as f64;
    if let Some(period) = spectrum.longest_period_s().filter(|period| seconds < LEAST_PERIODS * period) {
        warnings.push(format!(
            "the loop of {seconds} s is under {LEAST_PERIODS} peak periods of {period:.1} s: wave speeds are rounded"
        ));
    }
    // Not a number for a flat sea, which misses nothing.
    let missing = 1.0 - table.resolved_m0() / table.wanted_m0;
    if missing > UNRESOLVED {
        let shortest = layout.cascades.last().map_or(0.0, |cascade| cascade.shortest_m());
        let short = spectrum.share_shorter_than(shortest).min(missing);
        warnings.push(format!(
            "the cascades leave out {:.1} % of the energy (Hs is {:.3} m of {:.3} m): {:.1} % in waves shorter than \
             {shortest:.2} m, {:.1} % in longer ones than they hold",
            100.0 * missing,
            4.0 * libm::sqrt(table.resolved_m0()),
            4.0 * libm::sqrt(table.wanted_m0),
            100.0 * short,
            100.0 * (missing - short),
        ));
    }
    if let Some(measured) = spectrum.measured() {
        let (infeasible, missing) = (measured.infeasible(), measured.missing());
        if infeasible + missing > 0 {
            warnings.push(format!(
                "the record has {infeasible} frequencies whose directions no sea can have, changed to the nearest, and \
                 {missing} without directions, spread evenly"
            ));
        }
        if let Some(clipping) = measured.clipping() {
            warnings.push(format!(
                "the Fourier series of {} frequencies is negative somewhere and was clipped: this turned the mean \
                 direction by {:.1} and widened the spread by {:.1} degrees",
                clipping.bins, clipping.direction_deg, clipping.spread_deg
            ));
        }
    }
    warnings
}
