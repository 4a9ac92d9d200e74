//! All axes, one after the other, on one scene.

use super::arithmetic::{MayBe, arithmetic};
use super::foam::foam;
use super::ground::Ground;
use super::inverse::inverse;
use super::model::model;
use super::normals::normals;
use super::playback::playback;
use super::report::{Axis, Machine, Report};
use super::resolution::{band, cascades, grid};
use super::serving::{Measuring, Unmeasured, measure, settings};
use super::stages::stages;
use super::stream::stream;
use super::waves::{dispersion, energy, time};
use crate::backend::Cpu;
use crate::engine::{Clock, Opener};
use crate::scene::Scene;

/// The finest grids that a server can be run at which are looked at where it is quick.
const MOST_QUICKLY: usize = 128;

/// What to measure.
pub struct Sweep {
    /// The scene.
    pub scene: Scene,
    /// Fewer settings and rounds.
    pub quick: bool,
    /// Opens a GPU that computes in f32, where one may be measured ...
    pub gpu: Option<Opener>,
    /// ... and one that keeps f16 between its passes.
    pub gpu_half: Option<Opener>,
}

/// How far it has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Share of the time that it will take, about.
    pub done: f64,
    /// What is measured now.
    pub doing: &'a str,
}

/// Measures everything. Takes 20 seconds where it is quick, and minutes where it is not.
///
/// # Errors
/// [`Unmeasured`] of the settings that a server can be run at.
pub fn sweep(sweep: &Sweep, clock: &Clock, progress: &mut dyn FnMut(&Progress<'_>)) -> Result<Report, Unmeasured> {
    let started = clock.now_us();
    let mut told = |done: f64, doing: &str| progress(&Progress { done, doing });
    told(0.0, "the sea");
    let ground = Ground::new(&sweep.scene, sweep.quick, clock);
    let (mut axes, mut left_out): (Vec<Axis>, Vec<String>) = (Vec::new(), Vec::new());
    told(0.02, "grid");
    axes.push(grid(&ground));
    told(0.2, "cascades");
    axes.push(cascades(&ground));
    axes.push(band(&ground));
    told(0.25, "arithmetic");
    let gpus: [MayBe; 2] = [("GPU, f32", sweep.gpu.as_ref()), ("GPU, f16 between its passes", sweep.gpu_half.as_ref())];
    let (by, adapter) = arithmetic(&ground, &gpus, &mut left_out);
    axes.push(by);
    told(0.35, "model");
    axes.push(model(&ground));
    told(0.45, "normals");
    axes.push(normals(&ground));
    told(0.5, "dispersion, energy, time");
    axes.extend([dispersion(&ground), energy(&ground), time(&ground)]);
    told(0.55, "codec");
    axes.push(stream(&ground));
    told(0.6, "playback");
    axes.push(playback(&ground));
    told(0.65, "foam");
    axes.extend(foam(&ground, &mut left_out));
    told(0.7, "inverse displacement");
    axes.push(inverse(&ground));
    told(0.75, "stages");
    let stages = stages(&ground, &mut |n| told(0.75, &format!("stages, N = {n}")));
    told(0.85, "serving");
    let mut settings = settings(&sweep.scene);
    settings.retain(|setting| !sweep.quick || setting.cascades.n.is_none_or(|n| n <= MOST_QUICKLY));
    let mut measuring = Measuring {
        clock,
        open: &|| Ok(Box::new(Cpu::new(None))),
        most_backends: usize::MAX,
        most_ms: if sweep.quick { 1.0 } else { 50.0 },
        goes_on: &mut |done, of| {
            told(0.85 + 0.15 * done as f64 / of.max(1) as f64, "serving");
            true
        },
    };
    axes.push(measure(&sweep.scene, &settings, ground.tick, &mut measuring)?);
    told(1.0, "done");
    Ok(Report {
        scene: sweep.scene.name.clone(),
        hs_m: ground.hs_m,
        seed: sweep.scene.seed,
        tick: ground.tick,
        machine: Machine::here(adapter),
        quick: sweep.quick,
        took_s: (clock.now_us() - started) as f64 / 1e6,
        axes,
        stages,
        left_out,
    })
}
