//! Answers requests of points: one at a time, beside the engine, with a backend that is let go when nobody asks.

use std::sync::Arc;

use axum::body::Body;
use http::StatusCode;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use tokio::sync::{Mutex, OwnedSemaphorePermit, Semaphore};
use tokio::task::spawn_blocking;

use super::ocean::Ocean;
use super::read_body::{LARGEST_BODY, read_body_into};
use crate::backend::Cpu;
use crate::body::{ProbeBody, Problem};
use crate::engine::{ProbeAnswer, ProbeError, ProbeMethod, Probed, Prober};
use crate::sea::Timeline;
use crate::wire::TICKS_PER_SECOND;

/// Most that is held of bodies which are still being read, KiB. Bytes are counted as they come, so that who sends none
/// keeps nobody out.
const MAX_READING_KIB: usize = 64 << 10;
/// Most bodies parsed at a time.
const MAX_PARSING: usize = 2;
/// Most requests that are parsed or wait for their turn, the one under way included.
const MAX_WAITING: usize = 8;
/// A prober that nobody asked for so long is let go, ticks: a minute.
const IDLE_TICKS: i64 = 60 * TICKS_PER_SECOND;

/// The prober, made when it is first asked, and the places before it.
pub struct Probes {
    reading: Arc<Semaphore>,
    parsing: Arc<Semaphore>,
    waiting: Arc<Semaphore>,
    prober: Arc<Mutex<Option<Kept>>>,
}

struct Kept {
    prober: Prober,
    /// Half of the cores: frames have the others for themselves.
    threads: ThreadPool,
    /// When it was asked last.
    used: i64,
}

impl Default for Probes {
    fn default() -> Self {
        Self {
            reading: Arc::new(Semaphore::new(MAX_READING_KIB)),
            parsing: Arc::new(Semaphore::new(MAX_PARSING)),
            waiting: Arc::new(Semaphore::new(MAX_WAITING)),
            prober: Arc::default(),
        }
    }
}

impl Probes {
    /// Lets go of a prober that nobody has asked for a while.
    pub fn rest(&self, tick: i64) {
        if let Ok(mut kept) = self.prober.try_lock() {
            kept.take_if(|kept| tick.saturating_sub(kept.used) > IDLE_TICKS);
        }
    }

    /// Reads a body. Its room is held as long as the body is.
    async fn read(&self, body: Body) -> Result<(Vec<u8>, Option<OwnedSemaphorePermit>), Problem> {
        let mut held: Option<OwnedSemaphorePermit> = None;
        let room = |bytes: usize| {
            let (wanted, has) = (bytes.div_ceil(1024), held.as_ref().map_or(0, OwnedSemaphorePermit::num_permits));
            let more = u32::try_from(wanted.saturating_sub(has)).unwrap_or(u32::MAX);
            let more = Arc::clone(&self.reading).try_acquire_many_owned(more);
            let more = more.map_err(|_| busy(format!("{MAX_READING_KIB} KiB of probes are being read")))?;
            match &mut held {
                Some(held) => held.merge(more),
                None => held = Some(more),
            }
            Ok(())
        };
        let body = read_body_into(body, LARGEST_BODY, room).await?;
        Ok((body, held))
    }
}

impl Kept {
    fn new(ocean: &Ocean, timeline: Arc<Timeline>) -> Result<Self, Problem> {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let half = (ocean.settings.engine.threads.unwrap_or_else(cores) / 2).max(1);
        let threads = ThreadPoolBuilder::new().num_threads(half).thread_name(|i| format!("swellcast-probe-{i}"));
        let threads = threads.build().map_err(|_| Problem::internal("the system gives no threads"))?;
        Ok(Self { prober: Prober::new(Box::new(Cpu::new(Some(half))), timeline), threads, used: ocean.tick() })
    }
}

fn busy(limit: String) -> Problem {
    let detail = format!("{limit}, the most at a time");
    Problem::new(StatusCode::SERVICE_UNAVAILABLE, "busy", "Too many probes at a time", detail).retry_after(1)
}

/// The answer as it is written.
#[derive(Serialize)]
struct Document<'a> {
    tick: i64,
    sequence: u64,
    method: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    omitted_rms_m: Option<f64>,
    points: &'a [ProbeAnswer],
    transforms: u64,
    iterations: Iterations,
}

#[derive(Serialize)]
struct Iterations {
    mean: f64,
    most: u32,
}

/// Reads a request of points and answers it, as JSON.
///
/// # Errors
/// [`Problem`]: the body's own, 503 when too many ask, 422 for a tick that is forgotten or too much to sum.
pub async fn answer(ocean: &Arc<Ocean>, body: Body) -> Result<String, Problem> {
    let failed = |_| Problem::internal("the points can't be probed");
    let (body, room) = ocean.probes.read(body).await?;
    let turn = Arc::clone(&ocean.probes.waiting).try_acquire_owned();
    let turn = turn.map_err(|_| busy(format!("{MAX_WAITING} probes are waiting")))?;
    let parsing = Arc::clone(&ocean.probes.parsing).acquire_owned().await;
    let timeline = ocean.current().timeline;
    // A megabyte of JSON is work for a thread of its own, which has its permits with it: it goes on when the client is
    // gone.
    let parse = move || {
        let asked = ProbeBody::read(&body, timeline.scene());
        drop((body, room, parsing));
        (turn, asked)
    };
    let (turn, asked) = spawn_blocking(parse).await.map_err(failed)?;
    let asked = asked?;
    let mut kept = Arc::clone(&ocean.probes.prober).lock_owned().await;
    let ocean = Arc::clone(ocean);
    let work = move || {
        let _turn = turn;
        // Taken out, so that one which panics is not used again.
        let timeline = ocean.current().timeline;
        let mut at_work = match kept.take() {
            Some(kept) => kept,
            None => Kept::new(&ocean, Arc::clone(&timeline))?,
        };
        at_work.prober.set_timeline(timeline);
        let Kept { prober, threads, used } = &mut at_work;
        let answer = threads.install(|| run(&ocean, prober, &asked));
        *used = ocean.tick();
        *kept = Some(at_work);
        answer
    };
    spawn_blocking(work).await.map_err(failed)?
}

fn run(ocean: &Ocean, prober: &mut Prober, asked: &ProbeBody) -> Result<String, Problem> {
    let (now, since, started) = (ocean.tick(), prober.since(), ocean.clock.now_us());
    let tick = asked.tick.unwrap_or(now);
    if tick < since {
        let detail = format!("tick is {tick}, must be {since} or later: what changed before that is forgotten");
        let early = Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "too-early", "The tick is too early", detail);
        return Err(early.at("tick").found(tick).allowed(since));
    }
    let probed = prober.probe(tick, &asked.points, asked.fields, asked.method).map_err(refused)?;
    let us = u64::try_from(ocean.clock.now_us().saturating_sub(started)).unwrap_or(0);
    ocean.metrics.probed(asked.points.len() as u64, probed.transforms, us);
    written(probed, asked.method)
}

fn refused(error: ProbeError) -> Problem {
    match error {
        ProbeError::TooManySums { points, most, .. } => {
            let detail = error.to_string();
            Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-value", "A value is out of bounds", detail)
                .at("points")
                .found(format!("an array of {points}"))
                .allowed(format!("at most {most} points where method is direct"))
        }
        ProbeError::Backend(error) => {
            tracing::error!(%error, "probe");
            Problem::internal("the backend failed")
        }
    }
}

fn written(mut probed: Probed, method: ProbeMethod) -> Result<String, Problem> {
    probed.answers.iter_mut().for_each(shorten);
    let finite = |a: &ProbeAnswer| {
        let numbers = [a.height, a.residual].into_iter().chain(a.rest).chain(a.jacobian);
        numbers.chain(a.normal.into_iter().flatten()).chain(a.velocity.into_iter().flatten()).all(f64::is_finite)
    };
    // A wrong number is never sent.
    if !probed.answers.iter().all(finite) {
        tracing::error!(tick = probed.tick, "a probe gave a value that is not finite");
        return Err(Problem::internal("a value is not finite"));
    }
    let steps = probed.answers.iter().map(|answer| u64::from(answer.iterations)).sum::<u64>();
    let iterations = Iterations {
        mean: rounded(steps as f64 / probed.answers.len() as f64),
        most: probed.answers.iter().map(|answer| answer.iterations).max().unwrap_or(0),
    };
    let (name, omitted) = match method {
        ProbeMethod::Grid => ("grid", None),
        ProbeMethod::Direct { .. } => ("direct", Some(probed.omitted_rms_m)),
    };
    let document = Document {
        tick: probed.tick,
        sequence: probed.sequence,
        method: name,
        omitted_rms_m: omitted.map(rounded),
        points: &probed.answers,
        transforms: probed.transforms,
        iterations,
    };
    serde_json::to_string(&document).map_err(|_| Problem::internal("the answer can't be written"))
}

/// To a tenth of a micrometre: digits beyond are noise, and half of the bytes.
fn rounded(value: f64) -> f64 {
    (value * 1e7).round() / 1e7
}

fn shorten(answer: &mut ProbeAnswer) {
    let vectors = answer.normal.iter_mut().chain(&mut answer.velocity).flatten().chain(&mut answer.rest);
    let all = vectors.chain([&mut answer.height, &mut answer.residual]).chain(&mut answer.jacobian);
    all.for_each(|value| *value = rounded(*value));
}
