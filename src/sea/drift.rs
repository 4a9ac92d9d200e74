//! How noise that stands for waves drifts: a function of the scene as it began, so that no change of wind tears it.

use super::dispersion::Dispersion;
use crate::scene::Scene;

/// Direction and speed of drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Unit vector (x, z) that the waves travel toward.
    pub toward: [f64; 2],
    /// Of the water that the scene began with: noise of wavenumber k drifts at omega / k.
    pub dispersion: Dispersion,
}

impl Drift {
    /// With the wind that a scene began with; without wind with its highest swell, without swell as the strongest
    /// frequency of its record, else toward the east.
    ///
    /// A drift is an angle that grows with the tick. If it followed the wind, a turn of a degree after a week would
    /// shift the noise by kilometres at once.
    pub fn of(scene: &Scene) -> Self {
        let wind = scene.sea.wind.map(|wind| wind.direction_from_deg);
        let swell = || scene.sea.swells.iter().max_by(|a, b| a.hs_m.total_cmp(&b.hs_m)).map(|s| s.direction_from_deg);
        let record = || {
            let bins = scene.sea.measured.iter().flat_map(|record| record.bins());
            let directed = bins.filter_map(|bin| bin.direction.map(|direction| (bin.density, direction.alpha1_deg)));
            directed.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, alpha1_deg)| alpha1_deg)
        };
        let from = wind.or_else(swell).or_else(record).unwrap_or(270.0).to_radians();
        // From the north is from (0, -1): z points south.
        Self { toward: [-libm::sin(from), libm::cos(from)], dispersion: Dispersion::new(scene.sea.water) }
    }
}
