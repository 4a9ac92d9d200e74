//! The one seam between what is asked and what computes it.

mod cpu;
#[cfg(feature = "gpu")]
mod gpu;

use thiserror::Error;

use crate::pass::quantise::Found;
use crate::plan::{CascadePlan, Counted, Field, FieldSet, LevelPlan, Plan};
use crate::sea::{Cascade, Sea};

pub use cpu::Cpu;
#[cfg(feature = "gpu")]
pub use gpu::{Gpu, GpuError, GpuSettings, Storage, Traffic, traffic};

/// Why a backend could not make a surface.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BackendError {
    /// The plan does not fit the sea that is loaded.
    #[error("plan has {plan} cascades, the loaded sea has {sea}")]
    PlanMismatch {
        /// Cascades of the plan.
        plan: usize,
        /// Cascades of the sea.
        sea: usize,
    },
    /// This backend does not do what the sea asks for.
    #[error("not done by this backend: {0}")]
    Unsupported(&'static str),
    /// The device is gone or refuses work; another backend has to take over.
    #[error("device lost: {0}")]
    DeviceLost(String),
}

/// The fields of one cascade, at every level of detail that was made.
#[derive(Clone, Debug, Default)]
pub struct CascadeSurface {
    /// Samples a side of the full grid.
    pub n: usize,
    levels: Vec<Planes>,
    counts: Vec<Counts>,
}

/// A field as counts, in place of its samples.
#[derive(Clone, Debug)]
struct Counts {
    of: Counted,
    values: Vec<i16>,
    found: Found,
}

/// By field; empty where it was not made.
type Planes = [Vec<f32>; Field::ALL.len()];

impl CascadeSurface {
    fn new(cascade: &Cascade) -> Self {
        Self { n: cascade.n, levels: vec![Planes::default(); usize::from(cascade.levels())], counts: Vec::new() }
    }

    /// Samples of one's own: planes of the full grid, n x n each, `[z][x]`, by [`Field`]; empty where there is none.
    pub fn of(n: usize, planes: [Vec<f32>; Field::ALL.len()]) -> Self {
        Self { n, levels: vec![planes], counts: Vec::new() }
    }

    /// A field as counts, and what was found while they were made; `None` where a backend leaves samples, from which
    /// they can be had.
    pub fn counts(&self, counted: Counted) -> Option<(&[i16], Found)> {
        let counts = self.counts.iter().find(|counts| counts.of == counted)?;
        Some((&counts.values, counts.found))
    }

    /// A field's samples on the full grid, n x n, `[z][x]`; `None` when the plan didn't ask for it.
    pub fn plane(&self, field: Field) -> Option<&[f32]> {
        self.plane_at(0, field)
    }

    /// A field's samples at a level of detail: a side halved so many times.
    pub fn plane_at(&self, level: u8, field: Field) -> Option<&[f32]> {
        let planes = self.levels.get(usize::from(level))?;
        Some(planes[field as usize].as_slice()).filter(|plane| !plane.is_empty())
    }

    /// Makes room for what a plan computes, empties all else (its memory waits for the next plan that needs it), and sets
    /// to nothing what no pass writes.
    fn keep(&mut self, plan: &CascadePlan) {
        for (level, planes) in self.levels.iter_mut().enumerate() {
            let planned = plan.levels.iter().find(|planned| usize::from(planned.level) == level);
            let computed = planned.map_or(FieldSet::NONE, LevelPlan::computed);
            let transformed = planned.map_or(FieldSet::NONE, LevelPlan::transformed);
            let samples = (self.n >> level) * (self.n >> level);
            for (field, plane) in Field::ALL.into_iter().zip(planes) {
                plane.resize(if computed.contains(field) { samples } else { 0 }, 0.0);
                // A field that needs no transform is nothing, not what stood there before.
                if FieldSet::SPECTRAL.difference(transformed).contains(field) {
                    plane.fill(0.0);
                }
            }
        }
    }

    fn planes(&mut self, level: u8) -> &mut Planes {
        &mut self.levels[usize::from(level)]
    }

    /// Planes of every level of a plan, in its order.
    fn planes_of(&mut self, plan: &CascadePlan) -> Vec<&mut Planes> {
        let planned = |level: usize| plan.levels.iter().any(|planned| usize::from(planned.level) == level);
        self.levels.iter_mut().enumerate().filter(|(level, _)| planned(*level)).map(|(_, planes)| planes).collect()
    }
}

/// The water at one tick.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// The tick it belongs to; a backend that runs behind says so here.
    pub tick: i64,
    /// In the order of the layout.
    pub cascades: Vec<CascadeSurface>,
}

/// A place between two passes where tests look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tap {
    /// h(k, t) of every mode after evolve: real and imaginary part in turn, in the order of `CascadeModes::modes`.
    Heights,
    /// Foam held since the last foam tick, n x n.
    HeldFoam,
}

/// Evolves, transforms and assembles a sea.
pub trait Backend: Send {
    /// Name in logs, metrics and status.
    fn name(&self) -> &'static str;

    /// What computes, for people: a GPU says which.
    fn device(&self) -> &str {
        self.name()
    }

    /// Takes the initial spectra that are in effect from now on. A cascade that it holds already keeps its foam.
    ///
    /// # Errors
    /// [`BackendError::DeviceLost`].
    fn load(&mut self, sea: &Sea) -> Result<(), BackendError>;

    /// Makes the surface of a tick under a plan. What the plan doesn't name is not computed.
    ///
    /// # Errors
    /// [`BackendError`] when the plan doesn't fit or the device is lost.
    fn step(&mut self, tick: i64, plan: &Plan) -> Result<&Surface, BackendError>;

    /// The surface of the last step.
    fn surface(&self) -> &Surface;

    /// What stands between two passes after the last step, for tests.
    fn tap(&self, cascade: usize, tap: Tap) -> Option<Vec<f32>>;
}
