//! What budgets of milliseconds pick on this machine, and whether a server run at that keeps to them.
//!
//! `cargo bench --bench budget`; with `-- --write` it writes docs/budget.md. What is picked is run anew, 30 frames a second
//! as a server makes them, with pauses between.
#![allow(missing_docs, reason = "a bench")]

use std::fmt::Write;
use std::time::Duration;

use swellcast::accuracy::serving::{Frames, Measuring, Setting, measure, settings};
use swellcast::accuracy::{Axis, Errors, Machine, Point};
use swellcast::backend::{Backend, Cpu};
use swellcast::engine::{Clock, Times};
use swellcast::scene::{Scene, preset};

const SCENE: &str = "beaufort-5";
const BUDGETS_MS: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
/// Frames of a pick, and time from one to the next.
const FRAMES: usize = 240;
const INTERVAL_US: i64 = 1_000_000 / 30;

fn main() {
    let write = std::env::args().any(|argument| argument == "--write");
    let scene = preset(SCENE).expect("a preset");
    let clock = Clock::start(Clock::unix_now_ns());
    let open = || Ok(Box::new(Cpu::new(None)) as Box<dyn Backend>);
    let (settings, begun) = (settings(&scene), clock.now_us());
    let mut measuring = Measuring {
        clock: &clock,
        open: &open,
        most_backends: usize::MAX,
        most_ms: BUDGETS_MS[BUDGETS_MS.len() - 1],
        goes_on: &mut |_, _| true,
    };
    let axis = measure(&scene, &settings, 0, &mut measuring).expect("the CPU measures");
    let took_s = (clock.now_us() - begun) as f64 / 1e6;
    let timed = axis.points.iter().filter(|point| point.time.is_some()).count();
    eprintln!("{timed} of {} settings measured in {took_s:.1} s", settings.len());
    let picks: Vec<Pick> = BUDGETS_MS.map(|budget| Pick::of(&axis, budget, &scene, &settings, &clock)).into();
    println!("{}", table(axis.points.iter()));
    let page = page(&axis, &picks, took_s);
    println!("{page}");
    if write {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/budget.md");
        std::fs::write(path, page).expect("the docs can be written");
    }
}

/// What a budget picked, and how that went.
struct Pick {
    budget_ms: f64,
    fits: bool,
    point: Point,
    anew: Times,
}

impl Pick {
    fn of(axis: &Axis, budget_ms: f64, scene: &Scene, settings: &[Setting], clock: &Clock) -> Self {
        let p95 = |point: &Point| point.time.map_or(f64::INFINITY, |time| time.p95_ms);
        let cheapest = || axis.points.iter().min_by(|a, b| p95(a).total_cmp(&p95(b))).expect("something was measured");
        let best = axis.best_within(budget_ms);
        let (fits, point) = (best.is_some(), best.unwrap_or_else(cheapest).clone());
        let setting = settings.iter().find(|setting| setting.name == point.setting).expect("one of the settings");
        eprintln!("{budget_ms} ms: {}", point.setting);
        Self { budget_ms, fits, point, anew: anew(scene, setting, clock) }
    }

    fn line(&self) -> String {
        let Self { budget_ms, fits, point, anew } = self;
        let predicted = point.time.map_or(0.0, |time| time.p95_ms);
        let cheapest = if *fits { "" } else { " (none fits)" };
        let kept = if anew.p95_ms <= *budget_ms { "yes" } else { "no" };
        let (name, off) = (&point.setting, off(&point.errors));
        format!("| {budget_ms} | {name}{cheapest} | {predicted:.2} | {:.2} | {kept} | {off} |\n", anew.p95_ms)
    }
}

/// Frames of a setting, at the pace of a server.
fn anew(scene: &Scene, setting: &Setting, clock: &Clock) -> Times {
    let mut frames = Frames::new(scene, setting, Box::new(Cpu::new(None)), 7200 * 3600);
    frames.make().and_then(|_| frames.warm()).expect("the CPU steps");
    let mut times = Vec::with_capacity(FRAMES);
    let begun = clock.now_us();
    for i in 0..FRAMES {
        let due = begun + i as i64 * INTERVAL_US;
        std::thread::sleep(Duration::from_micros((due - clock.now_us()).max(0) as u64));
        times.push(frames.time(clock).expect("the CPU steps").0);
    }
    Times::of(times)
}

fn off(errors: &Errors) -> String {
    let cell = |value: Option<f64>, scale: f64| value.map_or(String::new(), |value| format!("{:.3}", scale * value));
    format!("{} | {}", cell(errors.height_rms, 100.0), cell(errors.normal_deg, 1.0))
}

fn table<'a>(points: impl Iterator<Item = &'a Point>) -> String {
    let mut table = String::from(
        "| setting | median ms | p95 ms | height, % of Hs | normal, degrees | Mb/s | MB | front |\n|---|---|---|---|---|---|---|---|\n",
    );
    for point in points {
        let time = point.time.unwrap_or_default();
        let (mbps, mb) =
            (point.bytes_per_s.unwrap_or(0.0) * 8e-6, point.memory_bytes.unwrap_or(0) as f64 / 1_048_576.0);
        let (front, off) = (if point.front { "yes" } else { "" }, off(&point.errors));
        let (name, median, p95) = (&point.setting, time.median_ms, time.p95_ms);
        writeln!(table, "| {name} | {median:.2} | {p95:.2} | {off} | {mbps:.1} | {mb:.0} | {front} |")
            .expect("a string");
    }
    table
}

fn page(axis: &Axis, picks: &[Pick], took_s: f64) -> String {
    let Machine { processor, cores, .. } = Machine::here(None);
    let picks: String = picks.iter().map(Pick::line).collect();
    let front = table(axis.points.iter().filter(|point| point.front));
    format!(
        "# A budget of milliseconds

Written by `just budget` (`cargo bench --bench budget -- --write`) on {processor}, {cores} cores.

    swellcast serve --budget-ms 4
    curl -X PUT http://127.0.0.1:8080/v1/scenes/{SCENE}/budget -d '{{\"budget_ms\": 4}}'
    curl http://127.0.0.1:8080/v1/scenes/{SCENE}/budget

A server with a budget measures, on its own machine and backend, what a step takes at every setting: the first patches of
its scene's layout and one finer, each on grids of 16 to 512 samples a side, with all the effects of the scene, encoding
included. The band of each is the widest that loses hardly more than the best: short waves have few samples, are badly read
between them, and are better left to the next patch. It picks the most accurate one whose 95th percentile leaves a fifth of
the budget free, else the cheapest, and brings the sea there by a change of layout in the control log, so that clients stay
in sync. `GET` tells what was picked, what it errs, and what is given up by it; `{{\"budget_ms\": null}}` ends it, and leaves
the layout as it is.

While it runs, it looks at the steps of the last three seconds. After five seconds in a row above the budget it picks for a
machine as much slower as was seen. After a minute in which a better setting would have taken less than 0.7 of the budget it
goes back to that, but never beyond what fitted when it was measured; where nothing did, the machine may have been busy
then, and only what is seen counts. Without frames it decides nothing. A layout has to settle, some 31 s, before another can
follow it. Who changes the layout by hand has the last word: the budget rests until it is set again. It is measured for once
in ten seconds at most; what was measured serves for an hour, unless what settings
follow from changes (winds of the layout, water, effects, backend).

## What budgets pick

Preset `{SCENE}`, measured in {took_s:.0} s. *Anew* is the same setting run by itself afterwards, {FRAMES} frames at 30 a
second, on a machine that does nothing else. Heights and normals: rms, of waves that the layout leaves out and of what
is lost between samples that are read bicubically; normals count waves down to the finest that any setting holds.

| budget, ms | setting | p95, ms | p95 anew, ms | kept | height, % of Hs | normal, degrees |
|---|---|---|---|---|---|---|
{picks}
## The front

No other setting is both more accurate, in height, and surely cheaper.

{front}"
    )
}
