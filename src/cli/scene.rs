//! A scene named on the command line, a preset's name or a file, and a moment of it.

use std::path::Path;

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::scene::{Model, PRESETS, Scene, SceneFile, preset};
use crate::wire::{MAX_TICK, TICKS_PER_SECOND};

/// What is taken when nothing is said.
pub const DEFAULT_SCENE: &str = "beaufort-5";

/// Which sea, and when.
#[derive(Debug, Args)]
pub struct MomentArguments {
    /// Preset or scene file
    #[arg(long, default_value = DEFAULT_SCENE)]
    scene: String,
    /// Replaces the scene's seed
    #[arg(long)]
    seed: Option<u64>,
    /// Seconds since tick 0
    #[arg(long, default_value_t = 0.0)]
    time: f64,
}

impl MomentArguments {
    /// The scene and the tick.
    pub fn load(&self) -> Result<(Scene, i64)> {
        Ok((load(&self.scene, self.seed)?, tick_of(self.time)?))
    }
}

/// The preset or file of this name, with the seed replaced when one is given.
pub fn load(name: &str, seed: Option<u64>) -> Result<Scene> {
    let mut scene = match preset(name) {
        Some(scene) => scene,
        None if Path::new(name).exists() => read(Path::new(name))?,
        None => {
            let known: Vec<&str> = PRESETS.iter().map(|(name, _)| *name).collect();
            bail!("scene is {name:?}, must be a file or one of {}", known.join(", "));
        }
    };
    scene.seed = seed.unwrap_or(scene.seed);
    Ok(scene)
}

fn read(path: &Path) -> Result<Scene> {
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let checked = SceneFile::from_toml(&text).and_then(|file| file.check(Some(folder)));
    checked.with_context(|| format!("in {}", path.display()))
}

/// The tick nearest to a time in seconds.
fn tick_of(seconds: f64) -> Result<i64> {
    let tick = (seconds * TICKS_PER_SECOND as f64).round();
    if !(0.0..=MAX_TICK as f64).contains(&tick) {
        bail!("time is {seconds}, must be from 0 to {} seconds", MAX_TICK / TICKS_PER_SECOND);
    }
    Ok(tick as i64)
}

/// Refuses to sum a sea of trochoids as if it were of plain waves.
pub fn check_reference(scene: &Scene) -> Result<()> {
    if scene.model != Model::Fft {
        bail!(
            "backend is reference, must be cpu: the slow sum is that of all modes, and this scene's model is trochoid"
        );
    }
    Ok(())
}
