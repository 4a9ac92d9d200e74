//! `swellcast serve`: a scene on the network.

use std::io::Write;
use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use tokio::net::TcpListener;

use super::gpu::GpuArguments;
use super::scene;
use crate::control::{Begun, Epoch, Store};
use crate::engine::{BackendChoice, Clock, EngineSettings};
use crate::sea::Timeline;
use crate::server::{self, Ocean, Settings, allow_open_files};

#[derive(Debug, Args)]
pub struct ServeArguments {
    /// Preset or scene file [default: what --data holds, else beaufort-5]
    #[arg(long, env = "SWELLCAST_SCENE")]
    scene: Option<String>,
    /// Replaces the scene's seed
    #[arg(long, env = "SWELLCAST_SEED")]
    seed: Option<u64>,
    /// Address to listen at
    #[arg(long, env = "SWELLCAST_LISTEN", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
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
    /// Most stream clients; from one address, too
    #[arg(long, env = "SWELLCAST_CLIENTS", default_value_t = 2048, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    clients: u32,
    /// An origin that may open a stream beside the server's own, like https://show.example; may be repeated
    #[arg(long, value_name = "ORIGIN")]
    allow_origin: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Choice {
    Auto,
    Cpu,
    Gpu,
}

pub fn run(arguments: ServeArguments) -> Result<()> {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| "info".into());
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
    tokio::runtime::Builder::new_multi_thread().enable_all().build()?.block_on(serve(arguments))
}

async fn serve(arguments: ServeArguments) -> Result<()> {
    // First of all, so that an address in use is found before anything is written.
    let listener = TcpListener::bind(arguments.listen).await;
    let listener = listener.with_context(|| format!("listening at {}", arguments.listen))?;
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
        allowed_origins: arguments.allow_origin,
        ..Settings::for_clients(arguments.clients as usize)
    };
    // A socket for each connection, and a few files.
    let wanted = settings.connections as u64 + 64;
    match allow_open_files(wanted) {
        Ok(allowed) if allowed >= wanted => {}
        Ok(allowed) => tracing::warn!(allowed, wanted, "the system allows too few open files for all connections"),
        Err(error) => tracing::warn!(%error, "asking how many files may be open"),
    }
    let address = listener.local_addr()?;
    let ocean = tokio::task::spawn_blocking(move || Ocean::start(store, begun, settings)).await?;
    for warning in ocean.current().timeline.warnings() {
        tracing::warn!("{warning}");
    }
    let kept = match &arguments.data {
        Some(folder) => format!("Changes are kept in {}: {changes} so far, tick {tick}.", folder.display()),
        None => "Changes are kept in memory; --data DIR keeps them through restarts.".to_owned(),
    };
    let said = writeln!(std::io::stdout().lock(), "Swellcast serves {name} at http://{address}/\n{kept}");
    if let Err(error) = said {
        // Whoever started it may have stopped reading; the sea goes on.
        tracing::debug!(%error, %address, "standard output");
    }
    server::run(listener, ocean, interrupted()).await.context("serving")
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

/// Resolves at Ctrl-C or, where there is one, the signal to terminate.
async fn interrupted() {
    let ctrl_c = tokio::signal::ctrl_c();
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = ctrl_c => {}
                _ = terminate.recv() => {}
            }
            return;
        }
    }
    // Without a handler there is nothing to wait for but the other signal.
    let _ = ctrl_c.await;
}
