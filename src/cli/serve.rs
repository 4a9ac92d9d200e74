//! `swellcast serve`: a scene on the network.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

#[derive(Debug, Args)]
pub struct ServeArguments {
    /// Preset or scene file.
    #[arg(long, env = "SWELLCAST_SCENE", default_value = "beaufort-5")]
    scene: String,
    /// Replaces the scene's seed.
    #[arg(long, env = "SWELLCAST_SEED")]
    seed: Option<u64>,
    /// Address to listen at.
    #[arg(long, env = "SWELLCAST_LISTEN", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// Folder that keeps the log of changes through restarts; without it they are kept in memory.
    #[arg(long, env = "SWELLCAST_DATA")]
    data: Option<PathBuf>,
    /// Threads that compute; one for each core unless given.
    #[arg(long, env = "SWELLCAST_THREADS")]
    threads: Option<usize>,
}

pub fn run(arguments: ServeArguments) -> Result<()> {
    anyhow::bail!("not yet: {arguments:?}")
}
