//! A checked scene back in the form that people write and send.

use super::effects::ModelName;
use super::{CascadesFile, EffectsFile, MeasuredFile, ReplayFile, SceneFile, TrochoidFile, WaterFile, WindFile};
use crate::scene::{CascadeRequest, MeasuredBin, MeasuredSpectrum, Model, Repeat, Scene};

impl From<&CascadeRequest> for CascadesFile {
    fn from(request: &CascadeRequest) -> Self {
        match request {
            CascadeRequest::Automatic { n, band_limit, finest_wavelength_m } => Self {
                n: *n,
                band_limit: *band_limit,
                finest_wavelength_m: *finest_wavelength_m,
                patches_m: Vec::new(),
            },
            CascadeRequest::Chosen { patches, band_limit } => Self {
                n: patches.first().map(|patch| patch.n),
                band_limit: *band_limit,
                patches_m: patches.iter().map(|patch| patch.length_m).collect(),
                ..Self::default()
            },
        }
    }
}

impl From<&Scene> for SceneFile {
    /// The file that checks to this very scene; a measured record stands in it as numbers.
    fn from(scene: &Scene) -> Self {
        let row = |bin: &MeasuredBin| match bin.direction {
            Some(s) => vec![bin.frequency_hz, bin.density, s.alpha1_deg, s.alpha2_deg, s.r1, s.r2],
            None => vec![bin.frequency_hz, bin.density],
        };
        let rows = |record: &MeasuredSpectrum| -> Vec<Vec<f64>> { record.bins().iter().map(row).collect() };
        let replay = scene.replay.as_ref().map(|replay| ReplayFile {
            until: None,
            record_s: replay.record_ticks as f64 / 7200.0,
            transition_s: replay.transition_ticks as f64 / 7200.0,
            records: replay.records.iter().map(rows).collect(),
        });
        Self {
            name: scene.name.clone(),
            title: scene.title.clone(),
            seed: scene.seed,
            model: match scene.model {
                Model::Fft => ModelName::Fft,
                Model::Trochoid(_) => ModelName::Trochoid,
            },
            loop_s: (scene.repeat != Repeat::default()).then(|| scene.repeat.ticks as f64 / 7200.0),
            promise: scene.promise,
            amplitudes: scene.amplitudes,
            water: WaterFile {
                depth_m: Some(scene.sea.water.depth_m).filter(|d| d.is_finite()),
                gravity: scene.sea.water.gravity,
                surface_tension: scene.sea.water.surface_tension,
                density: scene.sea.water.density,
                dispersion: scene.sea.water.dispersion,
            },
            wind: scene.sea.wind.map(|w| WindFile {
                model: w.model,
                speed_mps: w.speed_mps,
                direction_from_deg: w.direction_from_deg,
                fetch_m: w.fetch_m,
                gamma: w.gamma,
                alpha: w.alpha,
                small_wave_m: w.small_wave_m,
                hs_m: w.hs_m,
                depth_correction: w.depth_correction,
                spreading: Some(w.spreading),
                swell: w.swell,
                range_mps: scene.wind_range_mps.unwrap_or([w.speed_mps, w.speed_mps.max(0.1)]),
            }),
            swell: scene.sea.swells.clone(),
            measured: scene.sea.measured.as_ref().map(|record| MeasuredFile {
                bins: rows(record),
                directions: record.directions(),
                replay,
                ..MeasuredFile::default()
            }),
            cascades: CascadesFile::from(&scene.cascades),
            trochoid: match scene.model {
                Model::Fft => TrochoidFile::default(),
                Model::Trochoid(trochoid) => trochoid.into(),
            },
            effects: EffectsFile::from(&scene.effects),
            detail: scene.detail.clone(),
        }
    }
}
