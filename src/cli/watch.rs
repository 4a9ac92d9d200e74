//! `swellcast watch`: the Rust thin client on a terminal.

use anyhow::Result;

use crate::client::{self, WatchArguments};
use crate::engine::Clock;

pub fn run(arguments: &WatchArguments) -> Result<()> {
    let clock = Clock::start(Clock::unix_now_ns());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(client::watch(arguments, || clock.now_us())).map(drop)
}
