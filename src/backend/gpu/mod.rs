//! The passes on a GPU, by compute shaders through wgpu.

use thiserror::Error;

use super::{Backend, BackendError, Surface, Tap};
use crate::plan::Plan;
use crate::sea::Sea;

/// Numbers between the two passes of a transform: what accuracy costs in memory traffic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Storage {
    /// 32-bit floats: fields to 1e-6 of their scale.
    #[default]
    F32,
    /// 16-bit floats: half the traffic between the passes, fields to 1e-3 of their scale.
    F16,
}

/// Which GPU, and how it computes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GpuSettings {
    /// Part of the adapter's name, or its number in the list; `None` takes the best that is no software.
    pub adapter: Option<String>,
    /// Whether a software renderer will do where there is no GPU.
    pub software: bool,
    /// Numbers between the passes.
    pub storage: Storage,
}

/// Why there is no GPU backend.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum GpuError {
    /// No adapter fits.
    #[error("no GPU: {0}")]
    NoAdapter(String),
    /// The adapter gave no device, or the device refused a kernel.
    #[error("{adapter}: {reason}")]
    Refused {
        /// The adapter's name.
        adapter: String,
        /// What it said.
        reason: String,
    },
}

/// The GPU backend.
pub struct Gpu {
    adapter: String,
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// [`GpuError`].
    pub fn open(_settings: &GpuSettings) -> Result<Self, GpuError> {
        Err(GpuError::NoAdapter("none was looked for".to_owned()))
    }

    /// The adapter's name, for people.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Destroys the device, as if it were lost: for tests.
    pub fn lose(&self) {}
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn load(&mut self, _sea: &Sea) -> Result<(), BackendError> {
        Err(BackendError::DeviceLost("not yet".to_owned()))
    }

    fn step(&mut self, _tick: i64, _plan: &Plan) -> Result<&Surface, BackendError> {
        Err(BackendError::DeviceLost("not yet".to_owned()))
    }

    fn surface(&self) -> &Surface {
        panic!("not yet")
    }

    fn tap(&self, _cascade: usize, _tap: Tap) -> Option<Vec<f32>> {
        None
    }
}
