//! The load test: thousands of clients in one process, what they saw, and what it cost the server.
//!
//! Invariant: a client costs the machine little more than receiving and summing its bytes. It knows the protocol as any
//! client does, by its page, and no more of the server than what `/metrics` says.

mod arguments;
mod buckets;
mod calibrate;
mod calibrator;
mod churn;
mod crowd;
mod demand;
mod figures;
mod growth;
mod link;
mod monitor;
mod page;
mod reader;
mod report;
mod sight;
mod stage;
mod table;
mod viewer;
mod wind;

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, AtomicUsize};

use anyhow::{Context, Result, ensure};
use tokio::sync::watch;

pub use arguments::LoadArguments;
pub use buckets::Shares;
pub use calibrate::SUBCOMMAND as CALIBRATOR;
pub use calibrator::calibrator;
pub use churn::Churned;
pub use figures::{Continuity, Histogram, Percentiles};
pub use growth::growth;
pub use link::{Direction, Link, LinkSettings};
pub use page::page;
pub use reader::{BadFrame, BadStream, Head, Message, StreamReader};
pub use report::{Calibration, Findings, Group, Report, ReportRow, ServerCost, Stalled};
pub use sight::Faults;
pub use wind::WindChanges;

use calibrate::Calibrator;
use churn::Turnover;
use crowd::Course;
use monitor::{Timekeeper, Watched};
use stage::{Ledger, Stage};
use wind::Wind;

use crate::client::stream_uri;
use crate::engine::Clock;
use crate::server::allow_open_files;
use crate::wire::Codec;

/// Files that are open besides clients' sockets, and sockets that a client over a link takes.
const OTHER_FILES: u64 = 64;
const FILES_OVER_A_LINK: u64 = 3;

/// Runs a load test. `progress` is given a line about every second.
///
/// # Errors
/// When the server can't be reached, or so many clients can't be had on this machine.
pub async fn run(arguments: &LoadArguments, clock: Clock, mut progress: impl FnMut(String)) -> Result<Report> {
    let demands = arguments.demands().len();
    ensure!(
        arguments.churn.is_none() || arguments.clients as usize > demands,
        "clients is {}, must be above {demands} where some leave: the first of each demand stays",
        arguments.clients
    );
    let (uri, host, port) = stream_uri(&arguments.url)
        .with_context(|| format!("url is {:?}, must be like http://host:port", arguments.url))?;
    let each = if arguments.link.is_some() { FILES_OVER_A_LINK } else { 1 };
    let files = arguments.all() as u64 * each + OTHER_FILES;
    let allowed = allow_open_files(files).context("asking how many files may be open")?;
    ensure!(
        allowed >= files,
        "{} clients need {files} open files, this system allows {allowed} (ulimit -Hn)",
        arguments.all()
    );
    let mut addresses = tokio::net::lookup_host((host.trim_matches(['[', ']']), port)).await;
    let address = addresses.as_mut().ok().and_then(Iterator::next);
    let address = address.with_context(|| format!("{host} has no address"))?;
    let keeper = Timekeeper::start(&arguments.url, clock).await?;
    let link = match arguments.link {
        Some(settings) => Some(Link::start(address, settings, clock).await.context("starting the link")?),
        None => None,
    };
    let at = At {
        address: link.as_ref().map_or(address, |link| link.address),
        host: format!("{host}:{port}"),
        path: uri.path().to_owned(),
        offset_us: Arc::clone(&keeper.offset_us),
        clock,
    };
    let watched = Watched { address, host: at.host.clone() };
    let wind = match arguments.wind_every {
        Some(every_s) => Some((Wind::find(address, &at.host, &keeper.hello.scene).await?, every_s)),
        None => None,
    };
    let course = Course {
        plans: arguments.plans(),
        ramp_s: arguments.ramp_s(),
        base: arguments.calibrate.then_some(demands),
        churn: arguments.churn,
        wind,
    };
    let (load, outcomes) = at.go(arguments, course, &watched, &mut progress).await;
    let calibration = if arguments.calibrate {
        let calibrator = Calibrator::start(&keeper.hello, clock, &outcomes)?;
        let link = match arguments.link {
            Some(settings) => Some(Link::start(calibrator.address, settings, clock).await?),
            None => None,
        };
        let at = At {
            address: link.as_ref().map_or(calibrator.address, |link| link.address),
            offset_us: Arc::default(),
            ..at
        };
        let mut plans = arguments.steady();
        // The calibrator's frames have their headers alone, and none waits for another.
        for plan in &mut plans {
            (plan.decodes, plan.choice.codec) = (false, Codec::I16);
        }
        let watched = Watched { address: calibrator.address, host: at.host.clone() };
        let mut progress = |line: String| progress(format!("calibrating, {line}"));
        // Nor does any leave: the ceiling is that of clients who stay.
        let course = Course { plans, ramp_s: arguments.ramp_s(), base: Some(demands), churn: None, wind: None };
        let (findings, _) = at.go(arguments, course, &watched, &mut progress).await;
        let ratio = |of: fn(&ServerCost) -> Option<f64>| Some(of(&load.server)? / of(&findings.server)?);
        Some(Calibration {
            ratio: ratio(|cost| cost.bytes_per_cpu_second),
            fan_out_ratio: ratio(|cost| cost.fan_out_bytes_per_cpu_second),
            findings,
        })
    } else {
        None
    };
    let mut why = load.shortcomings(arguments.tolerate, arguments.flat);
    why.extend(keeper.closed().map(|closed| format!("the connection that keeps the time ended: {closed}")));
    Ok(Report {
        url: arguments.url.clone(),
        server: keeper.hello.server.clone(),
        scene: keeper.hello.scene.clone(),
        seconds: load.seconds,
        tolerated_share: arguments.tolerate,
        holds: why.is_empty(),
        why,
        clock_error_bound_ms: keeper.error_bound_ms(),
        load,
        calibration,
    })
}

/// Where a crowd goes.
struct At {
    address: SocketAddr,
    host: String,
    path: String,
    offset_us: Arc<AtomicI64>,
    clock: Clock,
}

impl At {
    async fn go(
        &self,
        arguments: &LoadArguments,
        course: Course,
        watched: &Watched,
        progress: &mut impl FnMut(String),
    ) -> (Findings, Vec<sight::Outcome>) {
        let (stop, stopped) = watch::channel(false);
        let stage = Arc::new(Stage {
            clock: self.clock,
            address: self.address,
            host: self.host.clone(),
            path: self.path.clone(),
            offset_us: Arc::clone(&self.offset_us),
            stop: stopped,
            settled: AtomicUsize::new(0),
            turnover: Turnover::default(),
            ledger: Ledger::new(self.clock.now_us(), arguments.seconds, course.ramp_s + arguments.seconds),
        });
        let crowd = crowd::run(Arc::clone(&stage), stop, course, watched, progress).await;
        let findings = Findings::of(&crowd, &stage, arguments.clients as usize);
        (findings, crowd.outcomes)
    }
}
