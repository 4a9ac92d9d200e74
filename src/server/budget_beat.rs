//! What a budget does each second: measures when that is due, picks, proposes what it picked, and watches how it goes.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use tokio::task::spawn_blocking;

use super::budget::{Held, Measured, Phase, Pick};
use super::ocean::Ocean;
use super::proposal::Proposal;
use super::repick::{Picked, Second, Watch, pick};
use crate::accuracy::serving::{Measuring, Setting, measure, settings};
use crate::backend::{Backend, Cpu};
use crate::body::{Problem, When};
use crate::control::Answer;
use crate::scene::{KEEP_TICKS, Scene};
use crate::sea::{Cascade, Layout, Timeline};
use crate::wire::TICKS_PER_SECOND;

/// How long the sea takes to follow a pick, seconds: where nobody watches, as when a server starts, and where somebody does.
const UNSEEN_S: f64 = 1.0;
const SEEN_S: f64 = 10.0;
/// A change that was refused is proposed again after so many ticks: ten seconds.
const AGAIN: i64 = 10 * TICKS_PER_SECOND;
/// Seconds for which another backend computes before that is measured.
const ELSEWHERE: u32 = 5;

impl Ocean {
    /// Goes on with the budget. Called each second; holds up nothing.
    pub(super) fn budget_beat(self: &Arc<Self>) {
        let mut held = self.budget.held();
        let Some(budget_ms) = held.budget_ms.filter(|_| self.source.can_change()) else { return };
        // Whose layout that will be is known when the proposal is decided.
        if held.proposing || matches!(held.phase, Phase::Off | Phase::Overridden | Phase::Failed(_)) {
            return;
        }
        let (timeline, now) = (self.current().timeline, self.tick());
        let generation = timeline.layout().generation;
        if *held.generation.get_or_insert(generation) != generation {
            tracing::info!("the layout was changed by hand: the budget of {budget_ms} ms rests until it is set again");
            held.phase = Phase::Overridden;
            return;
        }
        if let Phase::Measuring = held.phase {
            self.measure_or_pick(&mut held, budget_ms, &timeline, now);
        }
        self.watch(&mut held, budget_ms, &timeline);
        self.bring_in_force(&mut held, &timeline, now);
    }

    /// The scene that settings are made for: as it began, with the winds and the water in effect. The wind itself has no
    /// part in what settings there are, and none in what they cost.
    pub(super) fn measured_scene(&self) -> Scene {
        let mut scene = scene_in_effect(&self.current().timeline, self.tick());
        if let (Some(wind), Some([low, _])) = (&mut scene.sea.wind, scene.wind_range_mps) {
            (wind.speed_mps, wind.direction_from_deg) = (low, 0.0);
        }
        scene
    }

    fn measure_or_pick(self: &Arc<Self>, held: &mut Held, budget_ms: f64, timeline: &Timeline, now: i64) {
        let (of, backend) = (self.measured_scene(), self.counters().backend);
        let known = held.measured.as_ref().filter(|known| known.serves(&of, backend, budget_ms, now));
        if let Some(known) = known {
            let picked = pick(&known.axis, budget_ms, 1.0);
            held.phase = match picked.and_then(|picked| Some((setting_of(known, &picked)?, picked))) {
                Some((setting, picked)) => {
                    let counted = self.budget.pace.seen(now).count;
                    Phase::Picked(Box::new(Pick::new(picked, setting, timeline, counted)))
                }
                None => Phase::Failed("no setting could be measured".to_owned()),
            };
            held.say();
        } else if !held.measuring && held.allowance.take(now) {
            held.measuring = true;
            self.measure(of, backend, Held::most_ms(budget_ms), scene_in_effect(timeline, now));
        }
    }

    /// Measures beside everything else, for some seconds. The sea is not held: it may end meanwhile.
    fn measure(self: &Arc<Self>, of: Scene, backend: &'static str, most_ms: f64, scene: Scene) {
        let (threads, opener) = (self.settings.engine.threads, self.settings.engine.opener.clone());
        let (clock, tick, stop) = (self.clock, self.tick(), self.budget.stopping());
        let work = move || {
            let on_cpu = backend == Cpu::NAME;
            let open = || match &opener {
                Some(opener) if !on_cpu => (opener.0)(),
                _ => Ok(Box::new(Cpu::new(threads)) as Box<dyn Backend>),
            };
            let settings = settings(&scene);
            let mut measuring = Measuring {
                clock: &clock,
                open: &open,
                most_backends: if on_cpu { usize::MAX } else { 1 },
                most_ms,
                goes_on: &mut |_, _| !stop.load(Relaxed),
            };
            let axis = measure(&scene, &settings, tick, &mut measuring).map_err(|error| error.to_string())?;
            Ok(Measured { of, backend, most_ms, tick, settings, axis })
        };
        let ocean = Arc::downgrade(self);
        tokio::spawn(async move {
            let measured = spawn_blocking(work).await.unwrap_or_else(|error| Err(error.to_string()));
            let Some(ocean) = ocean.upgrade() else { return };
            {
                let mut held = ocean.budget.held();
                held.measuring = false;
                match measured {
                    Ok(measured) => held.measured = Some(measured),
                    Err(why) => {
                        tracing::error!("the settings for a budget can't be measured: {why}");
                        if let Phase::Measuring = held.phase {
                            held.phase = Phase::Failed(why);
                        }
                    }
                }
            }
            ocean.budget_beat();
        });
    }

    /// Looks at the frames of the last second; picks anew where the rules say so.
    fn watch(&self, held: &mut Held, budget_ms: f64, timeline: &Timeline) {
        let Held { phase: Phase::Picked(pick), measured: Some(measured), .. } = &mut *held else { return };
        if !pick.in_force {
            return;
        }
        pick.elsewhere = if self.counters().backend == measured.backend { 0 } else { pick.elsewhere + 1 };
        if pick.elsewhere >= ELSEWHERE {
            tracing::info!("another backend computes: the settings are measured again");
            held.phase = Phase::Measuring;
            return;
        }
        let settled = timeline.layout_settled();
        // While two layouts cross-fade, frames take as long as those of both.
        let seen = self.budget.pace.seen(settled.saturating_sub(KEEP_TICKS));
        let frames = (seen.count - pick.counted).min(seen.frames as u64) as usize;
        pick.counted = seen.count;
        let second = Second { p95_ms: seen.p95_ms, frames, settled: self.tick() >= settled };
        let Some(picked) = pick.watch.second(&measured.axis, &pick.picked, budget_ms, second) else { return };
        let Some(setting) = setting_of(measured, &picked) else { return };
        tracing::info!("p95 of a step was {:.2} ms", seen.p95_ms);
        held.phase = Phase::Picked(Box::new(Pick::new(picked, setting, timeline, seen.count)));
        held.say();
    }

    /// Proposes the layout that was picked, as soon as one can be accepted.
    fn bring_in_force(self: &Arc<Self>, held: &mut Held, timeline: &Timeline, now: i64) {
        let Phase::Picked(pick) = &held.phase else { return };
        let waits = pick.refused.as_ref().is_some_and(|(_, again)| now < *again);
        if pick.in_force || waits || now < timeline.layout_settled() {
            return;
        }
        let proposal = Proposal {
            kind: pick.setting.change(),
            when: When::Soon,
            transition_s: if self.clients() == 0 { UNSEEN_S } else { SEEN_S },
            key: None,
            if_match: None,
        };
        let (ocean, name) = (Arc::clone(self), pick.setting.name.clone());
        held.proposing = true;
        tokio::spawn(async move {
            let answer = ocean.propose(proposal).await;
            ocean.budget.held().proposed(&name, answer, ocean.tick());
        });
    }
}

impl Pick {
    fn new(picked: Picked, setting: Setting, timeline: &Timeline, counted: u64) -> Self {
        let in_force = is_in_force(&setting, timeline);
        let watch = Watch::default();
        Self { picked, setting, in_force, entry: None, refused: None, watch, counted, elsewhere: 0 }
    }
}

impl Held {
    /// Takes note of what came of a proposal of a setting.
    fn proposed(&mut self, name: &str, answer: Result<Answer, Problem>, now: i64) {
        self.proposing = false;
        // A budget that was set meanwhile counts for itself.
        if let (Ok(_), Some(generation)) = (&answer, &mut self.generation) {
            *generation += 1;
        }
        let Phase::Picked(pick) = &mut self.phase else { return };
        match answer {
            Ok(entry) if pick.setting.name == name => {
                (pick.in_force, pick.entry, pick.refused) = (true, Some(entry), None);
            }
            Ok(_) => {}
            Err(problem) => {
                let why = problem.detail().to_owned();
                tracing::warn!("the layout that the budget picked was refused: {why}");
                pick.refused = Some((why, now + AGAIN));
            }
        }
    }

    fn say(&self) {
        if let Some(said) = self.said() {
            tracing::info!("{said}");
        }
    }
}

fn setting_of(measured: &Measured, picked: &Picked) -> Option<Setting> {
    measured.settings.iter().find(|setting| setting.name == picked.point.setting).cloned()
}

/// The scene as it began, so that what was picked before has no part in it, with the sea in effect.
fn scene_in_effect(timeline: &Timeline, tick: i64) -> Scene {
    Scene { cascades: timeline.scene().cascades.clone(), ..timeline.scene_at(tick).clone() }
}

/// Whether the newest layout is that of a setting, by whatever request.
fn is_in_force(setting: &Setting, timeline: &Timeline) -> bool {
    let generation = timeline.layout().generation;
    let wanted = Layout::of_generation(&setting.of(timeline.scene()), generation).cascades;
    let newest: Vec<Cascade> =
        timeline.lives().filter(|life| life.until_tick.is_none()).map(|life| life.cascade).collect();
    wanted == newest
}
