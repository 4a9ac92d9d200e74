//! `swellcast record`: keeps what a server streams in a file, with the scene it is of.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::pin::pin;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use serde_json::Value;
use tokio::time::{MissedTickBehavior, interval};

use super::choice::Choice;
use super::connection::{Connection, Event, stream_uri};
use super::http::exchange;
use crate::recording::{Preface, RecordingWriter, Taken};
use crate::wire::{Hello, Subscribed, TICKS_PER_SECOND, UnitName, WireChange, WireChangeKind, lead_of};

/// Entries of the log read at a time.
const PAGE: usize = 1000;
/// Longest log that is taken.
const MOST_CHANGES: usize = 100_000;
/// How often progress is told.
const REFRESH: Duration = Duration::from_secs(1);

/// Options of `swellcast record`.
#[derive(Args, Clone, Debug)]
pub struct RecordArguments {
    /// The server, like http://127.0.0.1:8080
    #[arg(long)]
    pub url: String,
    /// The file, which must not be there yet
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Stop after so many seconds [default: only when interrupted]
    #[arg(long)]
    pub seconds: Option<f64>,
    /// What to ask for.
    #[command(flatten)]
    pub choice: Choice,
}

/// What was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Seconds of sea.
    pub seconds: f64,
    /// Frames.
    pub frames: u64,
    /// Length of the file.
    pub bytes: u64,
    /// Frames that could not be read, and times that the server sent less than was granted: each is a gap.
    pub faults: u64,
    /// Changes of the sea.
    pub changes: u64,
}

/// Records until the time is over, the server closes, or Ctrl-C; then the file is whole. `now_us` gives microseconds of
/// any monotonic clock.
///
/// # Errors
/// When there is no connection, the server refuses what is asked for, no frame came, or the file can't be written.
pub async fn record(
    arguments: &RecordArguments,
    now_us: impl Fn() -> i64,
    mut progress: impl FnMut(Recorded),
) -> Result<Recorded> {
    let mut connection = Connection::open(&arguments.url, &now_us).await?;
    connection.stop_reports();
    let begun_us = now_us();
    let end = arguments.seconds.unwrap_or(f64::INFINITY);
    ensure!(end > 0.0, "--seconds is {end}, must be above 0");
    let mut refresh = interval(REFRESH);
    refresh.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut interrupted = pin!(tokio::signal::ctrl_c());
    let (mut hello, mut tape): (Option<Hello>, Option<Tape>) = (None, None);
    while ((now_us() - begun_us) as f64) < end * 1e6 {
        let event = tokio::select! {
            event = connection.next() => event,
            _ = refresh.tick() => {
                progress(tape.as_ref().map(|tape| tape.recorded).unwrap_or_default());
                continue;
            }
            _ = &mut interrupted => break,
        };
        match event {
            Event::Hello(new) => {
                let rate = arguments.choice.rate_hz(&new).context("the server offers no rate")?;
                // With key frames, so that whoever watches the recording can begin with any second.
                connection.subscribe(rate, arguments.choice.units(&new), true).await;
                hello = Some(*new);
            }
            Event::Subscribed(granted) => match (&mut tape, &hello) {
                (Some(tape), _) => tape.take(granted)?,
                (None, Some(hello)) => tape = Some(Tape::begin(arguments, hello.clone(), granted).await?),
                (None, None) => bail!("the server answers before it says what it serves"),
            },
            Event::Frame(frame, bytes) => {
                if let Some(tape) = &mut tape {
                    tape.frame(frame.unit(), i64::try_from(frame.header.tick)?, &bytes)?;
                }
            }
            Event::Change(change) => {
                if let Some(tape) = &mut tape {
                    tape.change(change)?;
                }
            }
            Event::Quality(quality) => {
                if let Some(tape) = &mut tape {
                    tape.recorded.faults += u64::from(quality.coarser > 0 || quality.rate_hz < tape.taken.rate_hz);
                }
            }
            Event::BadFrame(_) => {
                if let Some(tape) = &mut tape {
                    tape.recorded.faults += 1;
                }
            }
            Event::Error { detail, .. } => {
                let Some(tape) = tape else { bail!("refused: {detail}") };
                eprintln!("refused: {detail}");
                return tape.finish();
            }
            Event::Closed(closed) => {
                let Some(tape) = tape else { bail!("{closed}") };
                eprintln!("{closed}");
                return tape.finish();
            }
            Event::Status(_) | Event::BadText(_) => {}
        }
    }
    connection.close_politely().await;
    tape.context("the server granted nothing in that time")?.finish()
}

/// A recording under way.
struct Tape {
    writer: RecordingWriter,
    lead_ticks: i64,
    taken: Taken,
    intervals: BTreeMap<UnitName, i64>,
    /// Newest entry of the log that is in the file.
    sequence: u64,
    /// A change of layout, and what was announced since, until its units are granted: whoever replays this needs those
    /// first.
    held: Vec<WireChange>,
    /// First and last tick.
    ticks: Option<(i64, i64)>,
    recorded: Recorded,
}

impl Tape {
    async fn begin(arguments: &RecordArguments, hello: Hello, granted: Subscribed) -> Result<Self> {
        let (_, host, port) = stream_uri(&arguments.url).context("the URL was good until now")?;
        let address = format!("{host}:{port}");
        let json = async |path: String| -> Result<Value> {
            let (status, body) = exchange(&address, &address, "GET", &path, "").await?;
            ensure!(status == 200, "{address} answers {path} with {status}: {body}");
            serde_json::from_str(&body).with_context(|| format!("{path} of {address} is no JSON"))
        };
        let scene = json(format!("/v1/scenes/{}", hello.scene)).await?["scene"].take();
        let mut changes: Vec<WireChange> = Vec::new();
        loop {
            let after = changes.last().map_or(0, |change| change.sequence);
            let mut page = json(format!("/v1/scenes/{}/log?after={after}&limit={PAGE}", hello.scene)).await?;
            let entries: Vec<WireChange> = serde_json::from_value(page["changes"].take()).context("reading the log")?;
            if entries.is_empty() {
                break;
            }
            ensure!(
                entries.iter().zip(after + 1..).all(|(entry, sequence)| entry.sequence == sequence),
                "the log of {address} does not count on from {after}"
            );
            changes.extend(entries);
            ensure!(changes.len() <= MOST_CHANGES, "the log of {address} has more than {MOST_CHANGES} entries");
        }
        let (lead_ticks, sequence) = (hello.lead_ticks, changes.last().map_or(0, |change| change.sequence));
        let taken = Taken { rate_hz: granted.rate_hz, units: granted.units };
        let preface = Preface { hello, scene, changes, taken: taken.clone() };
        let writer = RecordingWriter::create(&arguments.out, &preface)?;
        let intervals = taken.intervals().into_iter().collect();
        Ok(Self {
            writer,
            lead_ticks,
            taken,
            intervals,
            sequence,
            held: Vec::new(),
            ticks: None,
            recorded: Recorded::default(),
        })
    }

    /// Other units are granted: the layout has changed.
    fn take(&mut self, granted: Subscribed) -> Result<()> {
        self.taken = Taken { rate_hz: granted.rate_hz, units: granted.units };
        self.intervals = self.taken.intervals().into_iter().collect();
        self.writer.taken(&self.taken)?;
        self.write_held()
    }

    fn write_held(&mut self) -> Result<()> {
        for change in std::mem::take(&mut self.held) {
            self.writer.change(&change)?;
        }
        Ok(())
    }

    fn frame(&mut self, unit: UnitName, tick: i64, bytes: &[u8]) -> Result<()> {
        // What was on its way when the subscription was replaced.
        let Some(interval) = self.intervals.get(&unit) else { return Ok(()) };
        self.writer.frame(tick - lead_of(tick, *interval, unit.codec, self.lead_ticks), bytes)?;
        let (first, last) = self.ticks.unwrap_or((tick, tick));
        self.ticks = Some((first.min(tick), last.max(tick)));
        self.recorded.frames += 1;
        self.recorded.bytes = self.writer.bytes();
        self.recorded.seconds = (last - first) as f64 / TICKS_PER_SECOND as f64;
        Ok(())
    }

    fn change(&mut self, change: WireChange) -> Result<()> {
        // Those of before are in the preface.
        if change.sequence > self.sequence {
            self.sequence = change.sequence;
            self.recorded.changes += 1;
            let layout = matches!(change.change, WireChangeKind::Layout { .. });
            self.held.push(change);
            if !layout && self.held.len() == 1 {
                return self.write_held();
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Recorded> {
        ensure!(self.recorded.frames > 0, "no frame came");
        self.write_held()?;
        let bytes = self.writer.finish()?;
        Ok(Recorded { bytes, ..self.recorded })
    }
}
