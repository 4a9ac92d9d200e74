//! The settings that a server can be run at for a scene, each a layout that the control log can hold; how far off each is
//! from the sea that was asked for, and what its frames cost.

mod cost;
mod off;

use crate::scene::{CascadeRequest, CascadesFile, ChangeKind, Model, Scene};
use crate::sea::Layout;

pub use cost::{Frames, Measuring, Unmeasured, measure};
pub use off::errors;

/// Samples a side, from the coarsest grid to the finest, unless the scene's own is finer still.
const SIDES: (usize, usize) = (16, 512);
/// A finer patch beside a single one is so many times smaller.
const RATIO: f64 = 5.0;

/// A setting that a server can be run at.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// What it is called; no other setting of the scene is.
    pub name: String,
    /// The layout, as an entry of the control log has it.
    pub cascades: CascadesFile,
    /// Shortest wave of any setting of the scene, metres: slopes of waves down to this are what is wanted.
    pub finest_m: f64,
}

/// The settings of a scene: the first patches of its own layout, and one finer, each on grids from coarse to fine. Bands
/// hold the same waves on every grid, as far as it can hold them. Trochoids have one patch.
pub fn settings(scene: &Scene) -> Vec<Setting> {
    let layout = Layout::of(scene);
    let mut patches: Vec<f64> = layout.cascades.iter().map(|cascade| cascade.patch_m).collect();
    let (CascadeRequest::Automatic { band_limit, .. } | CascadeRequest::Chosen { band_limit, .. }) = &scene.cascades;
    let n = layout.cascades.first().map_or(CascadeRequest::USUAL_N, |first| first.n);
    if scene.model == Model::Fft {
        patches.push(finer(&patches));
    } else {
        patches.truncate(1);
    }
    let waves = band_limit * n as f64;
    let mut settings = Vec::new();
    for count in 1..=patches.len() {
        let mut side = SIDES.0;
        while side <= SIDES.1.max(n) {
            let cascades = CascadesFile {
                n: Some(side),
                band_limit: (waves / side as f64).clamp(0.1, 1.0),
                patches_m: patches[..count].to_vec(),
                ..CascadesFile::default()
            };
            let many = if count == 1 { "patch" } else { "patches" };
            let name = format!("{count} {many} of {side} x {side}");
            settings.push(Setting { name, cascades, finest_m: 0.0 });
            side *= 2;
        }
    }
    settings.retain(|setting| setting.fits(scene));
    let shortest = |setting: &Setting| Layout::of(&setting.of(scene)).cascades.last().map(|last| last.shortest_m());
    let finest_m = settings.iter().filter_map(shortest).fold(f64::INFINITY, f64::min);
    settings.iter_mut().for_each(|setting| setting.finest_m = finest_m);
    settings
}

/// The side of one more patch, metres, in whole millimetres as those of automatic layouts.
fn finer(patches: &[f64]) -> f64 {
    let metres = match patches {
        [.., before, last] => last * last / before,
        [only] => only / RATIO,
        [] => 0.0,
    };
    if metres > 1.0 { (metres * 1e3).round() / 1e3 } else { metres }
}

impl Setting {
    /// The change that a server is brought to it by.
    pub fn change(&self) -> ChangeKind {
        ChangeKind::Layout { cascades: self.cascades.clone(), wind_range_mps: None }
    }

    /// The scene at this setting. Measured records that follow the one in effect are left out.
    pub fn of(&self, scene: &Scene) -> Scene {
        let mut scene = Scene { replay: None, ..scene.clone() };
        self.change().apply(&mut scene);
        scene
    }

    fn fits(&self, scene: &Scene) -> bool {
        self.change().check().is_ok_and(|change| change.fits(scene).is_ok())
    }
}
