//! A crowd from its first client to its last: ramp, measured window, end, and what is sampled meanwhile.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use super::churn::{Churned, churn};
use super::figures::Row;
use super::monitor::{Figures, Watched};
use super::sight::Outcome;
use super::stage::Stage;
use super::viewer::{Manner, Plan, view};
use super::wind::{Wind, WindChanges};
use crate::server::{Usage, machine_cpu_seconds};

/// Clients that are not granted what they want so long after the last began, are not waited for.
const PATIENCE_S: i64 = 15;
/// How long clients may take to end.
const FAREWELL: Duration = Duration::from_secs(5);
/// The first few clients watch alone for so long before the server's cost without the crowd is measured, and that
/// takes so long.
const BASE_SETTLING: Duration = Duration::from_secs(2);
const BASE: Duration = Duration::from_secs(4);

/// How a crowd comes.
#[derive(Debug)]
pub struct Course {
    /// All clients, in the order they come.
    pub plans: Vec<Plan>,
    /// How long it takes until all have come, seconds.
    pub ramp_s: f64,
    /// So many come first, and the server's cost with them alone is measured.
    pub base: Option<usize>,
    /// So many steady clients a second leave in the window and are replaced.
    pub churn: Option<f64>,
    /// A wind that is changed in the window, and every how many seconds.
    pub wind: Option<(Wind, f64)>,
}

/// What was sampled at the beginning of a row.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The row.
    pub row: i64,
    /// Our time when it was taken, microseconds.
    pub at_us: i64,
    /// The server.
    pub server: Figures,
    /// Our own seconds of processor.
    pub own_cpu_seconds: Option<f64>,
    /// Of this machine, whoever used them.
    pub machine_cpu_seconds: Option<f64>,
}

/// What became of a crowd.
#[derive(Debug)]
pub struct Crowd {
    /// Of each client; those that never ended are not among them.
    pub outcomes: Vec<Outcome>,
    /// Over time.
    pub rows: Vec<Row>,
    /// Over time.
    pub samples: Vec<Sample>,
    /// First row of the window, and the one after its last.
    pub window: (i64, i64),
    /// Processor of the server with the first few clients alone, as a share of one.
    pub base_cpu: Option<f64>,
    /// Clients that left and were replaced, if any were to.
    pub churned: Option<Churned>,
    /// Changes of wind, if there were to be any.
    pub wind: Option<WindChanges>,
}

/// Runs a crowd. `stop` ends it; `progress` is called with a line to show now and then.
pub async fn run(
    stage: Arc<Stage>,
    stop: watch::Sender<bool>,
    course: Course,
    watched: &Watched,
    mut progress: impl FnMut(String),
) -> Crowd {
    let all = course.plans.len();
    let mut views = JoinSet::new();
    let mut plans = course.plans.into_iter();
    let mut seats = VecDeque::new();
    let mut seat = |plan: &Plan| {
        let (turn, turns) = mpsc::channel(1);
        if plan.manner == Manner::Steady && !plan.notes {
            seats.push_back(turn);
        }
        turns
    };
    let mut base_cpu = None;
    if let Some(first) = course.base {
        for plan in plans.by_ref().take(first) {
            let turns = seat(&plan);
            views.spawn(view(plan, Arc::clone(&stage), turns));
        }
        progress("measuring the server without the crowd".to_owned());
        sleep(BASE_SETTLING).await;
        let (before, begun_us) = (watched.figures().await, stage.clock.now_us());
        sleep(BASE).await;
        let (after, ended_us) = (watched.figures().await, stage.clock.now_us());
        let used = after.cpu_seconds.zip(before.cpu_seconds).map(|(after, before)| after - before);
        base_cpu = used.map(|used| used * 1e6 / (ended_us - begun_us) as f64);
    }
    let ramp_us = course.ramp_s * 1e6;
    let rest = plans.len().max(1) as f64;
    for (number, plan) in plans.enumerate() {
        let (stage, wait_us) = (Arc::clone(&stage), (ramp_us * number as f64 / rest) as u64);
        let (mut stopped, turns) = (stage.stop.clone(), seat(&plan));
        views.spawn(async move {
            tokio::select! {
                _ = stopped.wait_for(|stop| *stop) => {}
                () = sleep(Duration::from_micros(wait_us)) => {}
            }
            view(plan, stage, turns).await
        });
    }
    let latest_us = stage.clock.now_us() + ramp_us as i64 + PATIENCE_S * 1_000_000;
    let (mut samples, mut window) = (Vec::new(), None);
    let (mut churning, mut blowing) = (None, None);
    let mut ended = Vec::new();
    loop {
        let row = stage.ledger.row(stage.clock.now_us()) + 1;
        let wait_us = stage.ledger.begin_us(row) - stage.clock.now_us();
        sleep(Duration::from_micros(wait_us.max(0) as u64)).await;
        let own_cpu_seconds = Usage::own().map(|usage| usage.cpu_seconds);
        let at_us = stage.clock.now_us();
        let machine_cpu_seconds = machine_cpu_seconds();
        let server = watched.figures().await;
        samples.push(Sample { row, at_us, server, own_cpu_seconds, machine_cpu_seconds });
        while let Some(outcome) = views.try_join_next() {
            ended.extend(outcome);
        }
        progress(line(&stage, row, all, &ended, window));
        match window {
            Some((_, end)) if row >= end => break,
            None if stage.settled.load(Relaxed) >= all || stage.clock.now_us() > latest_us => {
                // The next row is the first that is whole.
                window = Some(stage.ledger.open_window(row + 1));
                let seats = std::mem::take(&mut seats);
                churning = course.churn.map(|rate| tokio::spawn(churn(seats, rate, Arc::clone(&stage))));
                let wind = course.wind.clone();
                blowing = wind.map(|(wind, every_s)| tokio::spawn(wind.change(every_s, stage.stop.clone())));
            }
            _ => {}
        }
    }
    if let Some(churning) = &churning {
        churning.abort();
        stage.turnover.complete().await;
    }
    // Whoever holds the other end is told, or gone.
    let _ = stop.send(true);
    let farewell = timeout(FAREWELL, async {
        while let Some(outcome) = views.join_next().await {
            ended.extend(outcome);
        }
    });
    // Who doesn't end is not among the outcomes.
    let _ = farewell.await;
    let window = window.unwrap_or_default();
    let churned = churning.map(|_| stage.turnover.counts());
    let wind = match blowing {
        Some(blowing) => blowing.await.ok(),
        None => None,
    };
    Crowd { outcomes: ended, rows: stage.ledger.rows(), samples, window, base_cpu, churned, wind }
}

fn line(stage: &Stage, row: i64, all: usize, ended: &[Outcome], window: Option<(i64, i64)>) -> String {
    // The newest row that every client has handed in.
    let last = stage.ledger.rows().get((row - 2).max(0) as usize).cloned().unwrap_or_default();
    let mbps = last.bytes as f64 * 8e-6 / stage.ledger.row_s();
    let p99 = last.ages.percentile_ms(0.99).map_or("-".to_owned(), |ms| format!("{ms:.1}"));
    let rows = |rows: i64| rows as f64 * stage.ledger.row_s();
    let at = match window {
        Some((first, end)) => format!("{:.0} of {:.0} s", rows((row - first).max(0)), rows(end - first)),
        None => "coming".to_owned(),
    };
    let mut line = format!("{at}: {} of {all} clients", stage.settled.load(Relaxed).saturating_sub(ended.len()));
    line += &format!(", {mbps:.0} Mb/s, age p99 {p99} ms, {} late", last.late);
    let came = stage.turnover.counts().came;
    if came > 0 {
        line += &format!(", {came} replaced");
    }
    let left = ended.iter().filter(|outcome| outcome.manner == Manner::Steady).count();
    if left > 0 {
        line += &format!(", {left} lost");
    }
    line
}
