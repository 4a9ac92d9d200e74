//! The settings that a server can be run at for a scene, each a layout that the control log can hold; how far off each is
//! from the sea that was asked for, and what its frames cost.

mod cost;
mod off;
mod waves;

use crate::scene::{CascadeRequest, CascadesFile, ChangeKind, Model, Scene};
use crate::sea::{Cascade, Layout};

pub use cost::{Frames, Measuring, Unmeasured, measure};
pub use off::{errors, errors_at};
use waves::Waves;

/// Samples a side, from the coarsest grid to the finest, unless the scene's own is finer still.
const SIDES: (usize, usize) = (16, 512);
/// Ends of bands that a grid is thought of with, as shares of its Nyquist wavenumber, in rising order: from twelve samples
/// of the shortest wave down to two.
const BANDS: [f64; 9] = [1.0 / 6.0, 0.2, 0.25, 1.0 / 3.0, 0.4, 0.5, 0.6, 0.75, 1.0];
/// How many times as much energy may be lost as by the best band.
const HARDLY_MORE: f64 = 1.5;
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

/// The settings of a scene: the first patches of its own layout, and one finer, each on grids from coarse to fine, its own
/// among them. Trochoids have one patch.
pub fn settings(scene: &Scene) -> Vec<Setting> {
    let layout = Layout::of(scene);
    let mut patches: Vec<f64> = layout.cascades.iter().map(|cascade| cascade.patch_m).collect();
    let own = (patches.len(), layout.cascades.first().map_or(CascadeRequest::USUAL_N, |first| first.n));
    let (CascadeRequest::Automatic { band_limit, .. } | CascadeRequest::Chosen { band_limit, .. }) = &scene.cascades;
    if scene.model == Model::Fft {
        patches.push(finer(&patches));
    } else {
        patches.truncate(1);
    }
    let waves = Waves::new(&scene.sea);
    let mut settings = Vec::new();
    for count in 1..=patches.len() {
        let mut side = SIDES.0;
        while side <= SIDES.1.max(own.1) {
            let bands = if (count, side) == own { &[*band_limit][..] } else { &BANDS[..] };
            settings.extend(widest(scene, &waves, &patches[..count], side, bands));
            side *= 2;
        }
    }
    let shortest = |setting: &Setting| Layout::of(&setting.of(scene)).cascades.last().map(Cascade::shortest_m);
    let finest_m = settings.iter().filter_map(shortest).fold(f64::INFINITY, f64::min);
    settings.iter_mut().for_each(|setting| setting.finest_m = finest_m);
    settings
}

/// The setting of patches and a grid with the widest of some bands that loses hardly more than the best of them. A wide
/// band has shorter waves, and normals with them; waves of few samples are badly read, and better left to a finer patch.
fn widest(scene: &Scene, waves: &Waves, patches: &[f64], side: usize, bands: &[f64]) -> Option<Setting> {
    let setting = |band_limit: &f64| {
        let many = if patches.len() == 1 { "patch" } else { "patches" };
        let name = format!("{} {many} of {side} x {side}", patches.len());
        let (n, patches_m, usual) = (Some(side), patches.to_vec(), CascadesFile::default());
        let cascades = CascadesFile { n, band_limit: *band_limit, patches_m, ..usual };
        Setting { name, cascades, finest_m: 0.0 }
    };
    let settings: Vec<Setting> = bands.iter().map(setting).filter(|setting| setting.fits(scene)).collect();
    let lost: Vec<f64> = settings.iter().map(|setting| waves.lost(&Layout::of(&setting.of(scene)))).collect();
    let least = lost.iter().copied().fold(f64::INFINITY, f64::min);
    let good = lost.iter().rposition(|lost| *lost <= HARDLY_MORE * least)?;
    settings.into_iter().nth(good)
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
