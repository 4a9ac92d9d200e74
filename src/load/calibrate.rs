//! Starts the calibrator beside us and sends the same crowd to it, so that the ratio is of one run on one machine.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::SocketAddr;
use std::process::{Child, ChildStdin, Command, Stdio};

use anyhow::{Context, Result, ensure};

use super::calibrator::{Job, JobTile};
use super::sight::{Noted, Outcome};
use crate::engine::Clock;
use crate::wire::Hello;

/// The hidden subcommand.
pub const SUBCOMMAND: &str = "calibrator";

/// A calibrator under way; it ends when this is dropped.
#[derive(Debug)]
pub struct Calibrator {
    process: Child,
    _input: ChildStdin,
    /// Where it listens.
    pub address: SocketAddr,
}

impl Calibrator {
    /// Starts one that sends what the outcomes noted. Its server time is ours.
    ///
    /// # Errors
    /// When nothing was noted, or this program can't be started a second time.
    pub fn start(hello: &Hello, clock: Clock, outcomes: &[Outcome]) -> Result<Self> {
        let tiles = tiles(outcomes);
        ensure!(!tiles.is_empty(), "there is nothing to calibrate with: no frame came");
        let zero_unix_ns = Clock::unix_now_ns() - clock.now_us() * 1000;
        let job = serde_json::to_string(&Job { zero_unix_ns, hello: hello.clone(), tiles })?;
        let program = std::env::current_exe().context("finding this program")?;
        let mut command = Command::new(program);
        let mut process = command
            .arg(SUBCOMMAND)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("starting the calibrator")?;
        let (input, output) = (process.stdin.take(), process.stdout.take());
        let (mut input, output) = input.zip(output).context("the calibrator has no pipes")?;
        writeln!(input, "{job}").context("handing the job to the calibrator")?;
        let mut line = String::new();
        BufReader::new(output).read_line(&mut line)?;
        let address = line.trim().parse().with_context(|| format!("the calibrator says {line:?}"))?;
        Ok(Self { process, _input: input, address })
    }
}

impl Drop for Calibrator {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Tiles as they were seen: their mean length, at the fastest rate that a client had.
fn tiles(outcomes: &[Outcome]) -> Vec<JobTile> {
    let mut seen = BTreeMap::<([u8; 4], [u16; 2]), Noted>::new();
    for noted in outcomes.iter().flat_map(|outcome| &outcome.noted) {
        let tile = seen.entry((noted.head.unit(), noted.head.tile())).or_insert(Noted {
            frames: 0,
            bytes: 0,
            ..noted.clone()
        });
        tile.interval = tile.interval.min(noted.interval);
        (tile.frames, tile.bytes) = (tile.frames + noted.frames, tile.bytes + noted.bytes);
    }
    let tile = |noted: Noted| JobTile {
        head: noted.head.0.to_vec(),
        interval: noted.interval,
        bytes: (noted.bytes / noted.frames.max(1)) as usize,
    };
    seen.into_values().map(tile).collect()
}
