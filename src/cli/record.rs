//! `swellcast record`: a stream into a file.

use std::io::{self, IsTerminal, Write};

use anyhow::Result;

use crate::client::{self, RecordArguments, Recorded};
use crate::engine::Clock;

pub fn run(arguments: &RecordArguments) -> Result<()> {
    let clock = Clock::start(Clock::unix_now_ns());
    let live = io::stderr().is_terminal();
    let show = |recorded: Recorded| {
        if live {
            // Nothing is lost if it can't be shown.
            let _ = write!(io::stderr(), "\r\x1b[2K{}", told(&recorded));
        }
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let recorded = runtime.block_on(client::record(arguments, || clock.now_us(), show))?;
    if live {
        let _ = write!(io::stderr(), "\r\x1b[2K");
    }
    writeln!(io::stdout(), "{}: {}", arguments.out.display(), told(&recorded))?;
    Ok(())
}

fn told(recorded: &Recorded) -> String {
    let Recorded { seconds, frames, bytes, faults, changes } = recorded;
    let mut text = format!("{seconds:.1} s, {frames} frames, {:.1} MB", *bytes as f64 / 1e6);
    for (count, what) in [(changes, "changes of the sea"), (faults, "gaps")] {
        if *count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text
}
