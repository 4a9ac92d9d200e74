//! All modes beside the strongest as trochoids: what is left out, and what noise makes of it.

use rustfft::num_complex::Complex64;

use super::axis::{Draft, axis};
use super::errors::Errors;
use super::ground::{Ground, Made, fields_on_grid, hs_m, particles, particles_on_grid};
use super::report::{Axis, Cost, Measure};
use crate::backend::Surface;
use crate::pass::trochoid::Trochoids;
use crate::plan::{Field, FieldSet};
use crate::scene::{CascadeRequest, Effects, Model, Patch, Scene, Trochoid};
use crate::sea::{Sea, Timeline, kept_waves};

/// What is compared: trochoids are heights over the world, and so is the sum of all modes without choppiness.
const FIELDS: FieldSet = FieldSet::of(&[Field::Height, Field::SlopeX, Field::SlopeZ]);
/// How many of the strongest are kept.
pub const COMPONENTS: [usize; 4] = [16, 64, 256, 1024];

/// A sea of trochoids on one patch of 256 samples a side, without choppiness, so that every wave is a cosine.
pub fn trochoid_sea(scene: &Scene, n: usize, components: usize, turbulence: bool, tick: i64) -> Sea {
    let model = Model::Trochoid(Trochoid { components, turbulence, ..Trochoid::default() });
    let mut scene = Scene { model, ..scene.clone() };
    scene.effects.choppiness = 0.0;
    let length_m = crate::sea::Layout::of(&scene).cascades[0].patch_m;
    scene.cascades = CascadeRequest::Chosen { patches: vec![Patch { length_m, n }], band_limit: 1.0 };
    Timeline::new(&scene).at(tick)
}

/// Share of the energy of a sea's first cascade that its trochoids leave out.
pub fn left_out_by_trochoids(sea: &Sea) -> f64 {
    let kept = kept_waves(&sea.cascades[0], sea);
    let kept: f64 = kept.iter().map(|wave| 0.5 * wave.amplitude * wave.amplitude).sum();
    1.0 - 16.0 * kept / hs_m(sea).powi(2)
}

/// The sum of all modes, and trochoids with and without noise.
pub fn model(ground: &Ground) -> Axis {
    let n = if ground.quick { 128 } else { 256 };
    let tick = ground.tick;
    let sea = trochoid_sea(&ground.scene, n, COMPONENTS[0], false, tick);
    let sea = Sea { model: Model::Fft, ..sea };
    let hs_m = hs_m(&sea);
    let truth = particles(&fields_on_grid(&sea, tick, &ground.spots));
    let errors = |surface: &Surface| Errors::of(&particles_on_grid(surface, &sea, &ground.spots), &truth, hs_m);
    let effects = Effects { choppiness: 0.0, ..ground.scene.effects };
    let mut all = Made::new(sea.clone(), FIELDS, &effects);
    let of_all = errors(all.step(tick));
    let mut drafts = vec![Draft::new("all modes", of_all).holding(all.memory_bytes()).costing(move |round| {
        all.step(tick + round * 240);
    })];
    for components in COMPONENTS {
        for turbulence in [false, true] {
            let sea = trochoid_sea(&ground.scene, n, components, turbulence, tick);
            let trochoids = Trochoids::new(&sea.cascades[0], &sea);
            let mut made = Made::new(sea, FIELDS, &effects);
            let errors = errors(made.step(tick));
            let noise = if turbulence { ", with noise" } else { "" };
            let mut planes = Default::default();
            let work = move |round: i64| trochoids.fill(tick + round * 240, n, FIELDS, &mut planes);
            drafts.push(Draft::new(format!("trochoids, K = {components}{noise}"), errors).costing(work));
        }
    }
    let about = format!(
        "One patch of {n} x {n} heights and slopes. Noise has the energy of the waves that were left out, not their crests: \
         it looks right and errs more. Trochoids can be evaluated at any point without a grid."
    );
    axis(ground, "model", about, (Measure::Height, Cost::Time), drafts)
}

/// A mode that has stood at this angle (radians) since ever and does not turn.
pub fn stopped(mode: &crate::sea::Mode, angle: f64) -> crate::sea::Mode {
    let turned = Complex64::new(libm::cos(angle), -libm::sin(angle));
    let (forward, backward) = (mode.forward * turned, mode.backward * turned.conj());
    crate::sea::Mode { forward, backward, cycles: 0, offset: 0, widening: mode.widening }
}
