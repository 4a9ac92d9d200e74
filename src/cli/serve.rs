//! `swellcast serve`: a scene on the network.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};

use super::gpu::GpuArguments;
use super::network::{self, NetworkArguments};
use super::scene;
use crate::control::{Begun, Epoch, Store};
use crate::engine::{BackendChoice, Clock, EngineSettings};
use crate::sea::Timeline;
use crate::server::{self, BUDGET_MS, Ocean, Settings};

#[derive(Debug, Args)]
pub struct ServeArguments {
    /// Preset or scene file [default: what --data holds, else beaufort-5]
    #[arg(long, env = "SWELLCAST_SCENE")]
    scene: Option<String>,
    /// Replaces the scene's seed
    #[arg(long, env = "SWELLCAST_SEED")]
    seed: Option<u64>,
    #[command(flatten)]
    network: NetworkArguments,
    /// What computes the sea
    #[arg(long, env = "SWELLCAST_BACKEND", value_enum, default_value_t = Choice::Auto)]
    backend: Choice,
    #[command(flatten)]
    gpu: GpuArguments,
    /// Folder that keeps the log of changes through restarts; without it they are kept in memory
    #[arg(long, env = "SWELLCAST_DATA")]
    data: Option<PathBuf>,
    /// Threads that compute [default: one for each core]
    #[arg(long, env = "SWELLCAST_THREADS", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// Milliseconds that a step may take: the most accurate layout is picked that fits, measured on this machine
    #[arg(long, env = "SWELLCAST_BUDGET_MS", value_name = "MS", value_parser = milliseconds)]
    budget_ms: Option<f64>,
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| BUDGET_MS.contains(number));
    number.ok_or_else(|| format!("must be a number from {} to {}", BUDGET_MS.start(), BUDGET_MS.end()))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Choice {
    Auto,
    Cpu,
    Gpu,
}

pub fn run(arguments: ServeArguments) -> Result<()> {
    network::log();
    tokio::runtime::Builder::new_multi_thread().enable_all().build()?.block_on(serve(arguments))
}

async fn serve(arguments: ServeArguments) -> Result<()> {
    // First of all, so that an address in use is found before anything is written.
    let listener = arguments.network.listener().await?;
    let (store, begun) = begin(&arguments)?;
    let (name, changes, tick) =
        (begun.scene.name.clone(), begun.changes.len(), Clock::start(begun.epoch.unix_ns).now_tick());
    let (backend, opener) = match arguments.backend {
        Choice::Cpu => (BackendChoice::Cpu, None),
        Choice::Auto => (BackendChoice::Auto, arguments.gpu.opener(false)),
        Choice::Gpu => {
            // Here and now, so that whoever asks for what isn't there is told.
            arguments.gpu.open()?.load(&Timeline::new(&begun.scene).at(tick))?;
            (BackendChoice::Gpu, arguments.gpu.opener(true))
        }
    };
    let settings = Settings {
        engine: EngineSettings {
            threads: arguments.threads.map(usize::from),
            backend,
            opener,
            ..EngineSettings::default()
        },
        budget_ms: arguments.budget_ms,
        ..arguments.network.settings(arguments.data.as_deref())?
    };
    let identity = settings.tls.clone();
    network::allow_files(&settings);
    let address = listener.local_addr()?;
    let ocean = tokio::task::spawn_blocking(move || Ocean::start(store, begun, settings)).await?;
    for warning in ocean.current().timeline.warnings() {
        tracing::warn!("{warning}");
    }
    let kept = match &arguments.data {
        Some(folder) => format!("Changes are kept in {}: {changes} so far, tick {tick}.\n", folder.display()),
        None => "Changes are kept in memory; --data DIR keeps them through restarts.\n".to_owned(),
    };
    network::tell(&name, address, identity.as_ref(), &kept);
    server::run(listener, ocean, network::interrupted()).await.context("serving")
}

/// The log, begun with the scene asked for or gone on with as it stands.
fn begin(arguments: &ServeArguments) -> Result<(Store, Begun)> {
    let store = match &arguments.data {
        Some(folder) => Store::open(folder).with_context(|| format!("opening the log in {}", folder.display()))?,
        None => Store::in_memory()?,
    };
    let begun = match (&arguments.scene, arguments.seed, store.begun()?) {
        (None, seed, Some(begun)) if seed.is_none_or(|seed| seed == begun.scene.seed) => begun,
        (None, Some(seed), Some(begun)) => {
            bail!("seed is {seed}, must be {}: the log in --data began with it", begun.scene.seed)
        }
        (name, seed, _) => {
            let scene = scene::load(name.as_deref().unwrap_or(scene::DEFAULT_SCENE), seed)?;
            store.begin(&scene, Epoch::begin(Clock::unix_now_ns()))?
        }
    };
    Ok((store, begun))
}
