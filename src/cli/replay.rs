//! `swellcast replay`: a recording on the network.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;

use super::network::{self, NetworkArguments};
use crate::recording::Recording;
use crate::server::{self, Ocean, ReplaySettings};
use crate::wire::TICKS_PER_SECOND;

#[derive(Debug, Args)]
pub struct ReplayArguments {
    /// What `swellcast record` wrote
    file: PathBuf,
    #[command(flatten)]
    network: NetworkArguments,
    /// Begin so many seconds after its beginning
    #[arg(long, default_value_t = 0.0, value_name = "SECONDS")]
    from: f64,
    /// Again and again without a seam, until interrupted: for a scene that repeats (`loop_s`), recorded for as long as
    /// that takes and 2 s more
    #[arg(long)]
    repeat: bool,
}

pub fn run(arguments: ReplayArguments) -> Result<()> {
    network::log();
    tokio::runtime::Builder::new_multi_thread().enable_all().build()?.block_on(replay(arguments))
}

async fn replay(arguments: ReplayArguments) -> Result<()> {
    let ReplayArguments { file, network, from, repeat } = arguments;
    ensure!((0.0..1e9).contains(&from), "--from is {from}, must be from 0 to 1e9");
    let listener = network.listener().await?;
    let settings = network.settings(None)?;
    let identity = settings.tls.clone();
    network::allow_files(&settings);
    let recording = Recording::open(&file)?;
    if !recording.is_whole() {
        tracing::warn!(file = %file.display(), "the recording was not finished; it ends with its last whole block");
    }
    let last = recording.len().wrapping_sub(1);
    let length = recording.leaves(last).zip(recording.leaves(0)).map_or(0, |(last, first)| last - first);
    let name = recording.preface().hello.scene.clone();
    let begin = move || Ocean::replay(recording, ReplaySettings { from_s: from, repeat }, settings);
    let ocean = tokio::task::spawn_blocking(begin).await??;
    let address = listener.local_addr()?;
    let seconds = length as f64 / TICKS_PER_SECOND as f64;
    let recorded = format!("Recorded: {seconds:.1} s{}.\n", if repeat { ", again and again" } else { "" });
    network::tell(&name, address, identity.as_ref(), &recorded);
    let of_end = std::sync::Arc::clone(&ocean);
    let end = async move {
        tokio::select! {
            () = network::interrupted() => {}
            () = of_end.over() => tracing::info!("the recording is over"),
        }
    };
    server::run(listener, ocean, end).await.context("serving")
}
