//! `swellcast load`: the load test on a terminal, and the calibrator that it starts.

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::engine::Clock;
use crate::load::{self, LoadArguments};

pub fn run(arguments: &LoadArguments) -> Result<()> {
    let clock = Clock::start(Clock::unix_now_ns());
    let live = io::stdout().is_terminal() && io::stderr().is_terminal();
    let show = |line: String| {
        if live {
            // Without automatic wrapping: a line too long for the terminal is cut. Nothing is lost if it can't be shown.
            let _ = write!(io::stderr(), "\r\x1b[2K\x1b[?7l{line}\x1b[?7h");
        }
    };
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let report = runtime.block_on(load::run(arguments, clock, show));
    if live {
        let _ = write!(io::stderr(), "\r\x1b[2K");
    }
    let report = report?;
    if let Some(path) = &arguments.html {
        save(path, &load::page(&report))?;
    }
    let json = arguments.json.as_deref().map(|path| Ok((path, serde_json::to_string(&report)? + "\n")));
    match json.transpose().map_err(|error: serde_json::Error| error)? {
        Some((path, text)) if path == Path::new("-") => io::stdout().write_all(text.as_bytes())?,
        saved => {
            if let Some((path, text)) = saved {
                save(path, &text)?;
            }
            let text = if arguments.markdown { report.markdown_row() + "\n" } else { report.table() };
            io::stdout().write_all(text.as_bytes())?;
        }
    }
    ensure!(report.holds, "it does not hold: {}", report.why.join("; "));
    Ok(())
}

fn save(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("can't write {}", path.display()))
}

/// What `--calibrate` starts beside itself.
pub fn calibrator() -> Result<()> {
    tokio::runtime::Builder::new_multi_thread().enable_all().build()?.block_on(load::calibrator())
}
