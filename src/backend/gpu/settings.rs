//! Which GPU computes and how, and why none may.

use thiserror::Error;

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
    /// Part of the adapter's name, or its number in the list; `None` takes the best.
    pub adapter: Option<String>,
    /// Whether a software renderer will do where there is no GPU. One that is named always does.
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
