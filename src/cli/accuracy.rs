//! `swellcast accuracy`: what accuracy costs in time on this machine, as tables, a page, or JSON.

use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;

use super::gpu::GpuArguments;
use super::scene;
use crate::accuracy::{Pictures, Point, Progress, Report, SERVING, Sweep, page, pictures, significant, sweep, table};
use crate::engine::Clock;

/// Pixels a side of the page's pictures.
const PICTURE: usize = 320;
/// Cells of the progress bar.
const BAR: usize = 30;

#[derive(Debug, Args)]
pub struct AccuracyArguments {
    /// Preset or scene file
    #[arg(long, default_value = scene::DEFAULT_SCENE)]
    scene: String,
    /// Replaces the scene's seed
    #[arg(long)]
    seed: Option<u64>,
    /// Fewer settings and rounds: a first look in a fraction of the time
    #[arg(long)]
    quick: bool,
    /// Write what was found as JSON to a file; - for standard output, and then nothing else
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with plots, tables and pictures to a file
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the page's pictures side by side to a PNG file
    #[arg(long, value_name = "FILE")]
    still: Option<PathBuf>,
    /// Milliseconds that a frame may take: say which setting is the most accurate that is safe in them
    #[arg(long, value_name = "B", value_parser = milliseconds)]
    budget_ms: Option<f64>,
    #[command(flatten)]
    gpu: GpuArguments,
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| (1e-3..=1e6).contains(number));
    number.ok_or_else(|| "must be a number from 0.001 to 1e6".to_owned())
}

/// A file that was made before there is anything to write.
struct Output<'a> {
    path: &'a Path,
    file: File,
}

impl<'a> Output<'a> {
    /// Makes it, where one is asked for.
    fn create(path: Option<&'a Path>) -> Result<Option<Self>> {
        let Some(path) = path else { return Ok(None) };
        let file = File::create(path).with_context(|| format!("can't write {}", path.display()))?;
        Ok(Some(Self { path, file }))
    }

    fn write(mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).with_context(|| format!("can't write {}", self.path.display()))
    }
}

pub fn run(arguments: &AccuracyArguments) -> Result<()> {
    let AccuracyArguments { quick, gpu, .. } = arguments;
    let scene = scene::load(&arguments.scene, arguments.seed)?;
    // A file that can't be written is told now, not after minutes.
    let (html, still) = (Output::create(arguments.html.as_deref())?, Output::create(arguments.still.as_deref())?);
    let printed = arguments.json.as_deref() == Some(Path::new("-"));
    let json = Output::create(arguments.json.as_deref().filter(|_| !printed))?;

    // A software renderer takes its time.
    let wanted = Sweep { scene, quick: *quick, gpu: gpu.opener(!*quick), gpu_half: gpu.half_opener(!*quick) };
    let live = io::stderr().is_terminal();
    let measured = measure(&wanted, html.is_some() || still.is_some(), live);
    if live {
        let _ = write!(io::stderr(), "\r\x1b[2K");
    }
    let (report, seen) = measured?;
    if let Some(seen) = seen {
        html.map_or(Ok(()), |html| html.write(page(&report, &seen).as_bytes()))?;
        still.map_or(Ok(()), |still| still.write(&seen.still().png()))?;
    }
    let text = serde_json::to_string(&report)? + "\n";
    json.map_or(Ok(()), |json| json.write(text.as_bytes()))?;
    let mut shown = if printed { text } else { table(&report) };
    if let Some(budget_ms) = arguments.budget_ms.filter(|_| !printed) {
        shown += &format!("\n{}\n", advice(&report, budget_ms));
    }
    Ok(io::stdout().write_all(shown.as_bytes())?)
}

/// Measures, and makes pictures of the same tick where they are wanted; on a terminal, with a line of progress.
fn measure(wanted: &Sweep, pictured: bool, live: bool) -> Result<(Report, Option<Pictures>)> {
    let clock = Clock::start(Clock::unix_now_ns());
    let begun_us = clock.now_us();
    let mut show = |progress: &Progress| {
        if live {
            let line = bar(progress, (clock.now_us() - begun_us) as f64 / 1e6);
            // Without automatic wrapping: a line too long for the terminal is cut. Nothing is lost if it can't be shown.
            let _ = write!(io::stderr(), "\r\x1b[2K\x1b[?7l{line}\x1b[?7h");
        }
    };
    let report = sweep(wanted, &clock, &mut show)?;
    if !pictured {
        return Ok((report, None));
    }
    show(&Progress { done: 1.0, doing: "pictures" });
    let seen = pictures(&wanted.scene, report.tick, PICTURE)?;
    Ok((report, Some(seen)))
}

/// How far it has come after so many seconds, and how many are left if it goes on like that.
fn bar(Progress { done, doing }: &Progress, elapsed_s: f64) -> String {
    let done = done.clamp(0.0, 1.0);
    let full = (done * BAR as f64) as usize;
    let left = if done > 0.0 { format!(", {:.0} s left", elapsed_s / done * (1.0 - done)) } else { String::new() };
    format!("[{}{}] {:3.0} %{left}: {doing}", "#".repeat(full), "-".repeat(BAR - full), done * 1e2)
}

/// Which setting a server should be run at, where a frame may take so long.
fn advice(report: &Report, budget_ms: f64) -> String {
    let Some(axis) = report.axes.iter().find(|axis| axis.name == SERVING) else {
        return format!("budget of {budget_ms} ms: settings of a server were not measured");
    };
    let p95_ms = |point: &Point| point.time.map_or(f64::INFINITY, |time| time.p95_ms);
    let error = |point: &Point| axis.measure.of(&point.errors).unwrap_or(f64::INFINITY);
    let told = |point: &Point| {
        let (error, p95_ms) = (significant(error(point)), significant(p95_ms(point)));
        format!("{} (error {error}, {}; p95 {p95_ms} ms)", point.setting, axis.measure.name())
    };
    let front = axis.points.iter().filter(|point| point.front);
    match (axis.best_within(budget_ms), axis.best_within(f64::INFINITY)) {
        (Some(chosen), Some(best)) if error(chosen) > error(best) => {
            let (less, longer) = (error(chosen) - error(best), p95_ms(best) / p95_ms(chosen));
            let (less, longer) = (significant(less), significant(longer));
            let gives_up = format!("the best, {}, errs {less} less and takes {longer} times as long", told(best));
            format!("budget of {budget_ms} ms: {}; {gives_up}", told(chosen))
        }
        (Some(chosen), _) => format!("budget of {budget_ms} ms: {}; none is more accurate", told(chosen)),
        (None, _) => match front.min_by(|a, b| p95_ms(a).total_cmp(&p95_ms(b))) {
            Some(cheapest) => format!("budget of {budget_ms} ms: none fits; the cheapest is {}", told(cheapest)),
            None => format!("budget of {budget_ms} ms: no setting was measured"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::{Axis, Cost, Errors, Machine, Measure};
    use crate::engine::Times;

    fn report(points: &[(&str, f64, f64)]) -> Report {
        let point = |(setting, error, ms): &(&str, f64, f64)| Point {
            setting: (*setting).to_owned(),
            errors: Errors { height_rms: Some(*error), ..Errors::default() },
            time: Some(Times::of(vec![*ms])),
            bytes_per_s: None,
            memory_bytes: None,
            front: true,
        };
        let points = points.iter().map(point).collect();
        let axis =
            Axis { name: SERVING.to_owned(), about: String::new(), measure: Measure::Height, cost: Cost::Time, points };
        Report {
            scene: String::new(),
            hs_m: 1.0,
            seed: 0,
            tick: 0,
            machine: Machine { processor: String::new(), cores: 1, adapter: None },
            quick: false,
            took_s: 0.0,
            axes: vec![axis],
            stages: Vec::new(),
            left_out: Vec::new(),
        }
    }

    #[test]
    fn advice_names_what_fits_and_what_it_gives_up() {
        let both = report(&[("fine", 0.01, 20.0), ("coarse", 0.05, 4.0)]);
        let fine = "fine (error 0.0100, height, rms of Hs; p95 20.0 ms)";
        let coarse = "coarse (error 0.0500, height, rms of Hs; p95 4.00 ms)";
        assert_eq!(advice(&both, 25.0), format!("budget of 25 ms: {fine}; none is more accurate"));
        let less = format!("the best, {fine}, errs 0.0400 less and takes 5.00 times as long");
        assert_eq!(advice(&both, 16.7), format!("budget of 16.7 ms: {coarse}; {less}"));
        assert_eq!(advice(&both, 1.0), format!("budget of 1 ms: none fits; the cheapest is {coarse}"));
        assert_eq!(advice(&report(&[]), 1.0), "budget of 1 ms: no setting was measured");
    }

    #[test]
    fn the_bar_says_how_much_is_left() {
        let line = |done| bar(&Progress { done, doing: "grids" }, 30.0);
        assert_eq!(line(0.25), "[#######-----------------------]  25 %, 90 s left: grids");
        assert_eq!(line(0.0), "[------------------------------]   0 %: grids");
        assert_eq!(line(7.0), "[##############################] 100 %, 0 s left: grids");
    }
}
