//! Fan-out of frames of three lengths to three crowds: ours beside raw sockets and beside axum's own WebSocket, in one run.
//!
//! `cargo run --release --manifest-path benches/peers/Cargo.toml --features fanout --bin fanout -- [SECONDS] [PAGE or KIB:CLIENTS..]`
//! (`just fanout`). Each server is a process of its own, this program again; the crowd is that of `swellcast load`, on the
//! same machine. With `128:100 128:100` only those rows are measured, in that order.

mod axum_ws;
mod tape;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};
use clap::{Args, FromArgMatches};
use swellcast::engine::Clock;
use swellcast::load::{self, CALIBRATOR, Findings, LoadArguments, Report};
use swellcast::recording::Recording;
use swellcast::server::{self, Ocean, ReplaySettings, Settings};
use tokio::net::TcpListener;
use tokio::runtime::Runtime;

const KIB: [usize; 3] = [32, 128, 400];
const CLIENTS: [u32; 3] = [1, 100, 1000];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let runtime = Runtime::new()?;
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [CALIBRATOR] => runtime.block_on(load::calibrator()),
        ["ours", tape] => runtime.block_on(ours(Path::new(tape))),
        ["axum", tape] => runtime.block_on(axum_ws::serve(Path::new(tape))),
        ["ours" | "axum", ..] => bail!("these are started by the bench itself"),
        _ => runtime.block_on(bench(&arguments)),
    }
}

/// Serves the tape as `swellcast replay --repeat` does, until it is killed.
async fn ours(tape: &Path) -> Result<()> {
    let recording = Recording::open(tape)?;
    let replay = ReplaySettings { repeat: true, ..ReplaySettings::default() };
    let begin = move || Ocean::replay(recording, replay, Settings::for_clients(2000));
    let ocean = tokio::task::spawn_blocking(begin).await??;
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    println!("{}", listener.local_addr()?);
    Ok(server::run(listener, ocean, std::future::pending()).await?)
}

/// A server in a process of its own; it ends when this is dropped.
struct Served {
    process: Child,
    url: String,
}

impl Served {
    fn start(kind: &str, tape: &Path) -> Result<Self> {
        let mut process = Command::new(std::env::current_exe()?).arg(kind).arg(tape).stdout(Stdio::piped()).spawn()?;
        let output = process.stdout.take().context("the server has no pipe")?;
        let mut line = String::new();
        BufReader::new(output).read_line(&mut line)?;
        Ok(Self { process, url: format!("http://{}", line.trim()) })
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

async fn bench(arguments: &[String]) -> Result<()> {
    let seconds = arguments.first().map_or(Ok(8.0), |seconds| seconds.parse::<f64>())?;
    let rows: Vec<(usize, u32)> = arguments.iter().skip(1).filter_map(|argument| pair(argument)).collect();
    if !rows.is_empty() {
        print!("{PAGE}");
        for (kib, clients) in rows {
            print!("{}", measured(kib, clients, seconds).await?);
        }
        return Ok(());
    }
    let mut page = PAGE.to_owned();
    print!("{PAGE}");
    for (kib, clients) in KIB.iter().flat_map(|kib| CLIENTS.map(|clients| (*kib, clients))) {
        let row = measured(kib, clients, seconds).await?;
        print!("{row}");
        page += &row;
    }
    if let Some(path) = arguments.get(1) {
        std::fs::write(path, page)?;
    }
    Ok(())
}

fn pair(argument: &str) -> Option<(usize, u32)> {
    let (kib, clients) = argument.split_once(':')?;
    Some((kib.parse().ok()?, clients.parse().ok()?))
}

/// A row of the table.
async fn measured(kib: usize, clients: u32, seconds: f64) -> Result<String> {
    let tape = std::env::temp_dir().join(format!("swellcast-fanout-{}-{kib}.swr", std::process::id()));
    tape::write(&tape, kib << 10)?;
    let run = async |kind: &str, calibrate: bool| -> Result<Report> {
        let served = Served::start(kind, &tape)?;
        let arguments = options(&served.url, clients, seconds, calibrate)?;
        load::run(&arguments, Clock::start(Clock::unix_now_ns()), |_| {}).await
    };
    let ours = run("ours", true).await.context("ours")?;
    let axum = run("axum", false).await.context("axum")?;
    std::fs::remove_file(&tape)?;
    row(kib, clients, &ours, &axum)
}

fn options(url: &str, clients: u32, seconds: f64, calibrate: bool) -> Result<LoadArguments> {
    let (clients, seconds) = (clients.to_string(), seconds.to_string());
    let mut words = vec!["load", "--url", url, "--clients", &clients, "--seconds", &seconds, "--rate", "15"];
    words.extend(["--groups", "displacement", "--decode", "0", "--tolerate", "1"]);
    if calibrate {
        words.push("--calibrate");
    }
    let command = LoadArguments::augment_args(clap::Command::new("load"));
    Ok(LoadArguments::from_arg_matches(&command.try_get_matches_from(words)?)?)
}

fn row(kib: usize, clients: u32, ours: &Report, axum: &Report) -> Result<String> {
    let calibration = ours.calibration.as_ref().context("it was calibrated")?;
    let (raw, alone) = (&calibration.findings, calibration.fan_out_ratio.filter(|_| clients > 1));
    let all: [&Findings; 3] = [&ours.load, raw, &axum.load];
    let cells = |of: &dyn Fn(&Findings) -> String| all.map(of).join(" / ");
    let rate = |findings: &Findings| findings.server.bytes_per_cpu_second.unwrap_or(f64::NAN);
    Ok(format!(
        "| {kib} | {clients} | {} | {} | {} | {:.0} % | {} | {:.1} | {:.1} | {} | {} |\n",
        cells(&|findings| format!("{:.0}", findings.received_mbps / 8.0)),
        cells(&|findings| format!("{:.2}", findings.server.cpu.unwrap_or(f64::NAN))),
        cells(&|findings| format!("{:.0}", rate(findings) / 1e6)),
        rate(&ours.load) / rate(raw) * 1e2,
        alone.map_or("-".to_owned(), |ratio| format!("{:.0} %", ratio * 1e2)),
        rate(&ours.load) / rate(&axum.load),
        rate(raw) / rate(&axum.load),
        cells(&|findings| findings.steady.age_ms.map_or("-".to_owned(), |age| format!("{:.0}", age.p99))),
        cells(&|findings| format!("{:.0} %", findings.steady.gap_share * 1e2)),
    ))
}

const PAGE: &str = "\
# What fan-out costs

Frames of one length, 15 a second, to a crowd of `swellcast load` on the same machine. Each cell has **ours** (`swellcast replay` of a recording of such frames) / **raw** sockets (the calibrator: one task a client, header and payload encoded once, written with nothing in between) / **axum** (its own `ws`: one task a client, `send` of shared bytes). MB/s is what the crowd received, cores what the server's process used, and MB per CPU second one by the other: that is what is compared. Where the machine is full, a client that is behind is moved to the newest frames by ours, and misses a tick at the raw sockets; as at axum's. \"Alone\" is what the crowd costs beyond its first client. Ours also answers each client's time and tells it once a second how the sea is; the raw sockets do neither.

Written by `cargo run --release --manifest-path benches/peers/Cargo.toml --features fanout --bin fanout -- 8 docs/fanout.md` (`just fanout`), on two shared cores that held the crowd, too.

| KiB a frame | clients | MB/s | cores | MB per CPU second | ours of raw | alone | ours of axum, times | raw of axum, times | age p99, ms | missing |
|---|---|---|---|---|---|---|---|---|---|---|
";
