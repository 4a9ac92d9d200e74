//! The one seam between what is asked and what computes it.

mod cpu;

use thiserror::Error;

use crate::plan::{Field, Plan};
use crate::sea::Sea;

pub use cpu::Cpu;

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
    /// The device is gone or refuses work; another backend has to take over.
    #[error("device lost: {0}")]
    DeviceLost(String),
}

/// The fields of one cascade.
#[derive(Clone, Debug, Default)]
pub struct CascadeSurface {
    /// Samples a side.
    pub n: usize,
    planes: [Vec<f32>; Field::ALL.len()],
}

impl CascadeSurface {
    /// A field's samples, n x n, `[z][x]`; `None` when the plan didn't ask for it.
    pub fn plane(&self, field: Field) -> Option<&[f32]> {
        Some(self.planes[field as usize].as_slice()).filter(|plane| !plane.is_empty())
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
