//! Which GPU a command takes, and how it computes.

use anyhow::Result;
use clap::{Args, ValueEnum};

use crate::backend::Backend;
use crate::engine::Opener;

#[derive(Clone, Debug, Args)]
pub struct GpuArguments {
    /// Part of the GPU's name, or its number; a software renderer is only taken by `auto` when it is named
    #[arg(long = "gpu", value_name = "NAME", env = "SWELLCAST_GPU")]
    name: Option<String>,
    /// Numbers that the GPU keeps between the passes of a transform: f16 halves their traffic, errs by a
    /// thousandth, and is therefore not taken by `auto`
    #[arg(long = "gpu-storage", env = "SWELLCAST_GPU_STORAGE", value_enum, default_value_t = StorageChoice::F32)]
    storage: StorageChoice,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum StorageChoice {
    F32,
    F16,
}

#[cfg(feature = "gpu")]
impl GpuArguments {
    fn settings(&self, software: bool) -> crate::backend::GpuSettings {
        use crate::backend::{GpuSettings, Storage};
        let storage = match self.storage {
            StorageChoice::F32 => Storage::F32,
            StorageChoice::F16 => Storage::F16,
        };
        GpuSettings { adapter: self.name.clone(), software, storage }
    }

    /// Opens it.
    pub fn open(&self) -> Result<Box<dyn Backend>> {
        Ok(Box::new(crate::backend::Gpu::open(&self.settings(true))?))
    }

    /// Opens it whenever it is needed, a software renderer if that will do.
    pub fn opener(&self, software: bool) -> Option<Opener> {
        Some(Opener::gpu(self.settings(software)))
    }

    /// The same, with 16-bit floats between its passes.
    pub fn half_opener(&self, software: bool) -> Option<Opener> {
        let settings = crate::backend::GpuSettings { storage: crate::backend::Storage::F16, ..self.settings(software) };
        Some(Opener::gpu(settings))
    }
}

#[cfg(not(feature = "gpu"))]
impl GpuArguments {
    /// There is none in this build.
    pub fn open(&self) -> Result<Box<dyn Backend>> {
        anyhow::bail!(
            "backend is gpu, must be another: this build has no GPU backend ({:?}, {:?})",
            self.name,
            self.storage
        )
    }

    /// There is none in this build.
    pub fn opener(&self, _software: bool) -> Option<Opener> {
        None
    }

    /// There is none in this build.
    pub fn half_opener(&self, _software: bool) -> Option<Opener> {
        None
    }
}
