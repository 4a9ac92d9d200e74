//! A checked scene back in the form that people write and send.

use super::file::{CascadesFile, EffectsFile, MeasuredFile, SceneFile, SwellFile, WaterFile, WindFile};
use super::{CascadeRequest, MeasuredBin, Repeat, Scene};

impl From<&Scene> for SceneFile {
    /// The file that checks to this very scene; a measured record stands in it as numbers.
    fn from(scene: &Scene) -> Self {
        let foam = scene.effects.foam.unwrap_or_default();
        let (n, band_limit, finest_wavelength_m, patches_m) = match &scene.cascades {
            CascadeRequest::Automatic { n, band_limit, finest_wavelength_m } => {
                (*n, *band_limit, *finest_wavelength_m, vec![])
            }
            CascadeRequest::Chosen { patches, band_limit } => {
                let n = patches.first().map_or(256, |p| p.n);
                let lengths = patches.iter().map(|p| p.length_m).collect();
                (n, *band_limit, CascadesFile::default().finest_wavelength_m, lengths)
            }
        };
        let row = |bin: &MeasuredBin| match bin.direction {
            Some(s) => vec![bin.frequency_hz, bin.density, s.alpha1_deg, s.alpha2_deg, s.r1, s.r2],
            None => vec![bin.frequency_hz, bin.density],
        };
        Self {
            name: scene.name.clone(),
            title: scene.title.clone(),
            seed: scene.seed,
            loop_s: (scene.repeat != Repeat::default()).then(|| scene.repeat.ticks as f64 / 7200.0),
            water: WaterFile {
                depth_m: Some(scene.sea.water.depth_m).filter(|d| d.is_finite()),
                gravity: scene.sea.water.gravity,
                tension: scene.sea.water.tension,
            },
            wind: scene.sea.wind.map(|w| WindFile {
                speed_mps: w.speed_mps,
                direction_from_deg: w.direction_from_deg,
                fetch_m: w.fetch_m,
                gamma: w.gamma,
                swell: w.swell,
                range_mps: scene.wind_range_mps.unwrap_or([w.speed_mps, w.speed_mps.max(0.1)]),
            }),
            swell: (scene.sea.swells.iter())
                .map(|s| SwellFile {
                    hs_m: s.hs_m,
                    tp_s: s.tp_s,
                    direction_from_deg: s.direction_from_deg,
                    gamma: s.gamma,
                    spread_s: s.spread_s,
                })
                .collect(),
            measured: (scene.sea.measured.as_ref())
                .map(|m| MeasuredFile { bins: m.bins().iter().map(row).collect(), ..MeasuredFile::default() }),
            cascades: CascadesFile { n, band_limit, finest_wavelength_m, patches_m },
            effects: EffectsFile {
                choppiness: scene.effects.choppiness,
                foam: scene.effects.foam.is_some(),
                foam_decay_s: foam.decay_s,
                foam_gain: foam.gain,
            },
        }
    }
}
