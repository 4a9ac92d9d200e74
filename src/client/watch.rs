//! `swellcast watch`: a thin client on the terminal, with live figures and a picture of what it received.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::pin::pin;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use tokio::time::{MissedTickBehavior, interval};

use super::choice::Choice;
use super::connection::{Connection, Event};
use super::playback::{Footing, Playback, TileKey};
use super::relief::relief;
use super::stats::{Report, Stats};
use super::surface::Patch;
use crate::wire::{ErrorCode, Hello, UnitName};

/// Side of the square that a picture shows, metres.
const PICTURE_M: f64 = 400.0;
/// Its pixels a side.
const PICTURE_SIDE: u32 = 800;
/// A terminal's line is written this often; plain lines every fourth time.
const REFRESH: Duration = Duration::from_millis(250);
/// How long to watch for a picture or a report when nothing else is said.
const SECONDS: f64 = 3.0;

/// Options of `swellcast watch`.
#[derive(Args, Clone, Debug)]
pub struct WatchArguments {
    /// The server, like http://127.0.0.1:8080
    #[arg(long)]
    pub url: String,
    /// Stop after so many seconds [default: 3 with --png or --json, else only when interrupted]
    #[arg(long)]
    pub seconds: Option<f64>,
    /// What to ask for.
    #[command(flatten)]
    pub choice: Choice,
    /// Save a shaded relief of 400 m x 400 m, 800 x 800 pixels, as it is at the end
    #[arg(long)]
    pub png: Option<PathBuf>,
    /// Print one JSON object at the end and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Watches a server until the time is over, it closes, or Ctrl-C. `now_us` gives microseconds of any monotonic clock.
///
/// # Errors
/// When there is no connection, the server refuses the subscription, or no frame came.
pub async fn watch(args: &WatchArguments, now_us: impl Fn() -> i64) -> Result<Report> {
    let mut watching = Watching {
        connection: Connection::open(&args.url, &now_us).await?,
        playback: Playback::default(),
        hello: None,
        stats: Stats::default(),
        settled: BTreeSet::new(),
    };
    let begun = now_us();
    let passed = || (now_us() - begun) as f64 / 1e6;
    let end = args.seconds.or((args.json || args.png.is_some()).then_some(SECONDS)).unwrap_or(f64::INFINITY);
    ensure!(end > 0.0, "--seconds is {end}, must be above 0");
    let mut refresh = interval(REFRESH);
    refresh.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let live = io::stdout().is_terminal() && !args.json;
    let (mut refreshes, mut closed) = (0u64, None);
    let mut interrupted = pin!(tokio::signal::ctrl_c());
    while passed() < end && closed.is_none() {
        tokio::select! {
            event = watching.connection.next() => closed = watching.take(event, args).await?,
            _ = refresh.tick() => {
                refreshes += 1;
                watching.check_footing();
                if live {
                    // Without automatic wrapping: a line too long for the terminal is cut, not written below itself.
                    print!("\r\x1b[2K\x1b[?7l{}\x1b[?7h", watching.report(passed()));
                    io::stdout().flush()?;
                } else if !args.json && refreshes.is_multiple_of(4) {
                    println!("{}", watching.report(passed()));
                }
            }
            _ = &mut interrupted => break,
        }
    }
    let report = watching.report(passed());
    if live {
        println!();
    }
    if let Some(closed) = closed {
        // A closed stream is an error only for who wanted more of it.
        if report.frames == 0 || end.is_finite() {
            bail!("{closed}");
        }
        eprintln!("{closed}");
    }
    ensure!(report.frames > 0, "no frame came in {:.1} s", report.seconds);
    if let Some(path) = &args.png {
        watching.save_picture(path)?;
    }
    if args.json {
        println!("{}", serde_json::to_string(&report)?);
    }
    watching.connection.close_politely().await;
    Ok(report)
}

/// A connection and what came of it.
struct Watching<N> {
    connection: Connection<N>,
    playback: Playback,
    hello: Option<Hello>,
    stats: Stats,
    /// Tiles that had frames on both sides once: from then on, lacking them is a fault.
    settled: BTreeSet<TileKey>,
}

impl<N: Fn() -> i64> Watching<N> {
    /// Takes an event; returns why the connection ended when it did.
    async fn take(&mut self, event: Event, args: &WatchArguments) -> Result<Option<super::Closed>> {
        match event {
            Event::Hello(hello) => {
                self.stats.hello(&hello);
                let rate = args.choice.rate_hz(&hello).context("the server offers no rate")?;
                self.connection.subscribe(rate, args.choice.units(&hello), false).await;
                self.hello = Some(*hello);
            }
            Event::Subscribed(subscribed) => {
                if let Some(hello) = &self.hello {
                    let units: Vec<UnitName> = subscribed.units.iter().map(|granted| granted.unit).collect();
                    self.playback = std::mem::take(&mut self.playback).renewed(hello, &units);
                    self.settled.retain(|key| self.playback.ticks(*key).next().is_some());
                }
            }
            Event::Frame(tile, bytes) => {
                self.stats.frame(&tile, bytes.len());
                if self.playback.insert(tile).is_err() {
                    self.stats.stray();
                }
                if let Some(now) = self.connection.server_us() {
                    self.playback.forget_before(now);
                }
            }
            Event::Status(status) => self.stats.status(status),
            Event::Change(_) | Event::Quality(_) => {}
            Event::Error { code: ErrorCode::Invalid | ErrorCode::Unavailable, detail } => bail!("refused: {detail}"),
            Event::Error { .. } | Event::BadFrame(_) | Event::BadText(_) => self.stats.bad(),
            Event::Closed(closed) => return Ok(Some(closed)),
        }
        Ok(None)
    }

    /// Counts a moment at which some tile can't be interpolated.
    fn check_footing(&mut self) {
        let Some(now) = self.connection.server_us() else { return };
        let stands = |key: TileKey| Some((key, self.playback.footing(key, now)?));
        let (between, starved): (Vec<_>, Vec<_>) =
            self.playback.keys().filter_map(stands).partition(|(_, footing)| *footing == Footing::Between);
        let [between, starved] = [between, starved].map(|all| all.into_iter().map(|(key, _)| key).collect::<Vec<_>>());
        if starved.iter().any(|key| self.settled.contains(key)) {
            self.stats.starved();
        }
        self.settled.extend(between);
    }

    fn report(&self, seconds: f64) -> Report {
        let clock = self.connection.clock();
        let bound = self.connection.error_bound_us();
        self.stats.report(seconds, (self.connection.server_us(), bound, clock.drift()))
    }

    fn save_picture(&self, path: &Path) -> Result<()> {
        let (hello, now) = self.hello.as_ref().zip(self.connection.server_us()).context("the server gave no time")?;
        let patches = Patch::all(&self.playback, &hello.layout, now);
        let file = File::create(path).with_context(|| format!("can't write {}", path.display()))?;
        let picture = relief(&patches, PICTURE_M, PICTURE_SIDE);
        picture.write_png(BufWriter::new(file)).with_context(|| format!("can't write {}", path.display()))
    }
}
