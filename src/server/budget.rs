//! The budget of milliseconds that a step may take: what it picks, what it holds that against, and what is told of it.
//!
//! A budget is measured, picks a setting, and brings the sea there by a change of layout like anybody's, through the log.
//! Then it watches step times. Once a second all of that is looked at (`budget_beat.rs`), and nowhere else.

use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use http::StatusCode;
use serde_json::{Value, json};

use super::allowance::Allowance;
use super::ocean::Ocean;
use super::pace::Pace;
use super::repick::{Picked, Watch};
use crate::accuracy::serving::Setting;
use crate::accuracy::{Axis, Point};
use crate::body::{Fields, Problem, missing};
use crate::control::Answer;
use crate::scene::Scene;
use crate::wire::TICKS_PER_SECOND;

/// Budgets that there can be, milliseconds.
pub const BUDGET_MS: RangeInclusive<f64> = 0.1..=1000.0;
/// How long what was measured is taken to be true, ticks: an hour.
const LASTS: i64 = 3600 * TICKS_PER_SECOND;
/// A measurement takes all there is for some seconds: one each ten.
const TICKS_PER_MEASUREMENT: i64 = 10 * TICKS_PER_SECOND;
/// Settings are measured for a budget at least so large, milliseconds, so that another small one needs no measurement.
const LEAST_MOST_MS: f64 = 4.0;
/// Heights that are this far off, as a share of Hs, are hardly there: all waves together have an rms of Hs / 4.
const FLAT: f64 = 0.24;

/// The budget of a sea.
pub struct Budget {
    held: Mutex<Held>,
    /// Step times.
    pub pace: Arc<Pace>,
    /// A measurement under way is to end.
    stop: Arc<AtomicBool>,
}

/// What a budget stands at.
#[derive(Debug)]
pub(super) struct Held {
    /// Milliseconds, where there is a budget.
    pub budget_ms: Option<f64>,
    pub phase: Phase,
    /// A measurement is under way.
    pub measuring: bool,
    pub measured: Option<Measured>,
    pub allowance: Allowance,
    /// A change of layout is being proposed.
    pub proposing: bool,
    /// Changes of layout that are accounted for; one more is somebody else's.
    pub generation: Option<u32>,
}

#[derive(Debug)]
pub(super) enum Phase {
    Off,
    /// Settings are measured, or will be as soon as that is allowed again.
    Measuring,
    Picked(Box<Pick>),
    /// Somebody else has changed the layout: the budget rests.
    Overridden,
    /// There is nothing to pick from.
    Failed(String),
}

/// What was picked, and how far that has come.
#[derive(Debug)]
pub(super) struct Pick {
    pub picked: Picked,
    pub setting: Setting,
    /// The sea has this layout, or is on its way there.
    pub in_force: bool,
    /// The entry of the log that brought it there; `None`: it had it already.
    pub entry: Option<Answer>,
    /// Why the change was refused, and the tick from which on it is proposed again.
    pub refused: Option<(String, i64)>,
    pub watch: Watch,
    /// Frames that were counted before this second.
    pub counted: u64,
    /// Seconds for which another backend has computed than was measured.
    pub elsewhere: u32,
}

/// What was measured.
#[derive(Debug)]
pub(super) struct Measured {
    /// The scene that it holds for: all that settings and their cost follow from.
    pub of: Scene,
    /// What computed.
    pub backend: &'static str,
    /// Of settings far slower than this no time was taken, milliseconds.
    pub most_ms: f64,
    /// When.
    pub tick: i64,
    pub settings: Vec<Setting>,
    pub axis: Axis,
}

impl Measured {
    /// Whether it serves a budget for a scene, now.
    pub fn serves(&self, of: &Scene, backend: &str, budget_ms: f64, tick: i64) -> bool {
        self.of == *of && self.backend == backend && budget_ms <= 2.0 * self.most_ms && tick - self.tick < LASTS
    }

    /// The most accurate setting, whatever it takes.
    fn best(&self) -> Option<&Point> {
        let error = |point: &Point| self.axis.measure.of(&point.errors).unwrap_or(f64::INFINITY);
        self.axis.points.iter().min_by(|a, b| error(a).total_cmp(&error(b)))
    }
}

impl Budget {
    /// A budget of so many milliseconds, or none yet.
    pub fn new(budget_ms: Option<f64>) -> Self {
        let phase = if budget_ms.is_some() { Phase::Measuring } else { Phase::Off };
        let held = Held {
            budget_ms,
            phase,
            measuring: false,
            measured: None,
            allowance: Allowance::new(1, TICKS_PER_MEASUREMENT),
            proposing: false,
            generation: None,
        };
        Self { held: Mutex::new(held), pace: Arc::default(), stop: Arc::default() }
    }

    /// Ends what is being measured, and begins nothing more.
    pub fn stop(&self) {
        self.stop.store(true, Relaxed);
    }

    /// Told when measurements are to end.
    pub(super) fn stopping(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// A poisoned lock holds plain data that is whole after every statement.
    pub(super) fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the budget, or none, as the body of `PUT /v1/scenes/{name}/budget` says.
    ///
    /// # Errors
    /// [`Problem`] naming the field that is wrong; 409 for a sea that can't be changed, 429 when it would take another
    /// measurement so soon.
    pub(super) fn set(ocean: &Arc<Ocean>, body: &[u8]) -> Result<Value, Problem> {
        let mut fields = Fields::parse(body)?;
        let asked = fields.or_infinite("budget_ms")?.ok_or_else(|| missing("budget_ms"))?;
        fields.finish()?;
        let asked = Some(asked).filter(|ms| ms.is_finite());
        if let Some(ms) = asked.filter(|ms| !BUDGET_MS.contains(ms)) {
            let bound = format!("a number from {} to {}, or null", BUDGET_MS.start(), BUDGET_MS.end());
            return Err(Problem::value("budget_ms", json!(ms), bound));
        }
        if !ocean.source.can_change() {
            return Err(Problem::conflict("recorded", "this sea was recorded: it can't be changed any more"));
        }
        let now = ocean.tick();
        {
            let mut held = ocean.budget.held();
            if let Some(budget_ms) = asked {
                let (of, backend) = (ocean.measured_scene(), ocean.counters().backend);
                let known = held.measured.as_ref().is_some_and(|known| known.serves(&of, backend, budget_ms, now));
                // One that is under way serves, or is followed by another when that is allowed.
                let mut allowance = held.allowance;
                if !known && !held.measuring && !allowance.take(now) {
                    let detail = "a budget is measured for first, which can be done once in 10 s";
                    let title = "Too many measurements";
                    return Err(Problem::new(StatusCode::TOO_MANY_REQUESTS, "too-fast", title, detail).retry_after(10));
                }
            }
            held.budget_ms = asked;
            held.phase = if asked.is_some() { Phase::Measuring } else { Phase::Off };
            held.generation = None;
        }
        ocean.budget_beat();
        Ok(ocean.budget.told())
    }

    /// What clients are told: the answer to `GET /v1/scenes/{name}/budget`.
    pub fn told(&self) -> Value {
        let held = self.held();
        let mut told = json!({ "budget_ms": held.budget_ms, "state": held.phase.name() });
        match &held.phase {
            Phase::Off | Phase::Measuring | Phase::Overridden => {}
            Phase::Failed(why) => told["error"] = json!(why),
            Phase::Picked(pick) => {
                let Picked { point, slower, .. } = &pick.picked;
                told["setting"] = json!(point.setting);
                told["cascades"] = json!(pick.setting.cascades);
                told["p95_ms"] = json!(point.time.map(|time| time.p95_ms));
                told["slower"] = json!(slower);
                told["errors"] = json!(point.errors);
                told["sequence"] = json!(pick.entry.map(|entry| entry.sequence));
                told["effective_tick"] = json!(pick.entry.map(|entry| entry.effective_tick));
                told["in_force"] = json!(pick.in_force);
                if let Some((why, _)) = &pick.refused {
                    told["error"] = json!(why);
                }
                let best = held.measured.as_ref().and_then(Measured::best);
                let better = best.filter(|best| best.setting != point.setting);
                told["gives_up"] = json!(better.map(|best| json!({ "setting": best.setting, "errors": best.errors })));
                let seen = self.pace.seen(i64::MIN);
                told["seen"] = json!({ "p95_ms": seen.p95_ms, "frames": seen.frames });
            }
        }
        told
    }
}

impl Held {
    /// The most that a frame may take which is measured for a budget, milliseconds.
    pub fn most_ms(budget_ms: f64) -> f64 {
        budget_ms.max(LEAST_MOST_MS)
    }

    /// For people: what was picked, and what that gives up.
    pub fn said(&self) -> Option<String> {
        let (Phase::Picked(pick), Some(budget_ms)) = (&self.phase, self.budget_ms) else { return None };
        let Picked { point, fits, slower } = &pick.picked;
        let off = |point: &Point| {
            let height = point.errors.height_rms.map(|height| {
                let flat = if height > FLAT { ", as a flat sea's are" } else { "" };
                format!("heights off by {:.2} % of Hs{flat}", 100.0 * height)
            });
            let normal = point.errors.normal_deg.map(|degrees| format!("normals by {degrees:.1} degrees"));
            [height, normal].into_iter().flatten().collect::<Vec<_>>().join(", ")
        };
        let p95 = slower * point.time.map_or(0.0, |time| time.p95_ms);
        let fits = if *fits { "picks" } else { "fits no setting; the cheapest is" };
        let best = self.measured.as_ref().and_then(Measured::best).filter(|best| best.setting != point.setting);
        let best = best.map_or(String::new(), |best| format!("; given up: {}, {}", best.setting, off(best)));
        Some(format!("a budget of {budget_ms} ms {fits} {}: p95 {p95:.2} ms, {}{best}", point.setting, off(point)))
    }
}

impl Phase {
    fn name(&self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Measuring => "measuring",
            Self::Picked(pick) if pick.picked.fits => "picked",
            Self::Picked(_) => "none_fits",
            Self::Overridden => "overridden",
            Self::Failed(_) => "failed",
        }
    }
}
