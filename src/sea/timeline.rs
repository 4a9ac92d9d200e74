//! The sea as a function of the tick: a fold over the log of changes, the same on every server.
//!
//! [`Stages`] says what is in effect and how seas are blended, so that amplitudes never jump and never rise above
//! those of the seas being blended; an [`Era`] is the sea on one layout. While the layout changes there are two,
//! cross-faded so that the energy stays level.

use std::sync::Arc;

use super::dispersion::Dispersion;
use super::drift::Drift;
use super::era::{Era, Life};
use super::layout::Layout;
use super::modes::Sea;
use super::stages::Stages;
use super::statistics::Statistics;
use crate::scene::{Change, CrossFade, KEEP_TICKS, Scene, SceneError, SeaState};

/// Most transitions under way at one tick; each costs memory and a share of every frame.
pub const MAX_OVERLAPPING: usize = 16;

/// A scene and every change made to it. Immutable: a change makes a new timeline that shares the old one's tables.
#[derive(Clone, Debug)]
pub struct Timeline {
    scene: Arc<Scene>,
    stages: Stages,
    /// The layouts that may still be asked for, oldest first: one, or two while it changes and shortly after.
    eras: Vec<Era>,
    /// The cascades of all eras.
    layout: Arc<Layout>,
    warnings: Arc<[String]>,
    /// Nothing was folded that acts on this tick or a later one.
    since: i64,
}

impl Timeline {
    /// A scene before any change. Integrates its spectrum, which takes a tenth of a second.
    pub fn new(scene: &Scene) -> Self {
        Self::replay(scene, &[], 0)
    }

    /// A scene before any change, made as soon as its spectrum is integrated: water foams below a Jacobian that nobody
    /// calibrated. For measuring what frames cost, which doesn't depend on how much of the water foams.
    pub fn uncalibrated(scene: &Scene) -> Self {
        const SOME: f64 = 0.5;
        let mut timeline = Self::unchanged(scene);
        timeline.eras = timeline.eras.into_iter().map(|era| era.uncalibrated(SOME)).collect();
        timeline.prepare(0);
        timeline
    }

    /// A scene and its log, for ticks from shortly before `now` on (as far back as foam remembers): what was over by
    /// then is folded into one state and forgotten.
    pub fn replay(scene: &Scene, changes: &[Change], now: i64) -> Self {
        let mut timeline = Self::unchanged(scene);
        // An automatic layout follows from the water as it was known when the layout was accepted.
        let mut accepted: Vec<&Change> = changes.iter().collect();
        accepted.sort_by_key(|change| change.sequence);
        for change in accepted {
            timeline.insert(change.clone(), now);
        }
        timeline.prepare(now);
        timeline
    }

    fn unchanged(scene: &Scene) -> Self {
        let (stages, layout) = (Stages::new(scene), Layout::of(scene));
        let eras = vec![Era::new(layout.clone(), None, stages.len())];
        Self {
            scene: Arc::new(scene.clone()),
            stages,
            eras,
            layout: Arc::new(layout),
            warnings: Arc::default(),
            since: i64::MIN,
        }
    }

    /// The timeline with one more change, for ticks from shortly before `now` on.
    pub fn with(&self, change: Change, now: i64) -> Self {
        let mut next = self.clone();
        next.insert(change, now);
        next.prepare(now);
        next
    }

    /// The same without layouts that nobody can ask for any more; `None` when there is none of those.
    pub fn without_ended(&self, now: i64) -> Option<Self> {
        let mut next = self.clone();
        next.forget_eras(now);
        (next.eras.len() < self.eras.len()).then(|| {
            next.prepare(now);
            next
        })
    }

    /// Checks a change against what is in effect when it acts, and accepted changes after it against what it sets.
    ///
    /// # Errors
    /// The sequence of the first entry that could then not act, and why.
    pub fn check(&self, change: &Change) -> Result<(), (u64, SceneError)> {
        Change::check_course(&self.stages.get(0).scene, self.stages.changes().chain([change]))
    }

    /// The tick from which on a change of layout can be accepted: when the one before is over and forgotten.
    pub fn layout_settled(&self) -> i64 {
        self.newest_era().settled()
    }

    /// The first tick whose sea is known: what acted before alone is folded away.
    pub fn since(&self) -> i64 {
        self.since
    }

    /// The scene it began with.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as changes have made it, in effect or being approached at a tick.
    pub fn scene_at(&self, tick: i64) -> &Scene {
        &self.stages.get(self.stages.newest(tick)).scene
    }

    /// The sea state that is in effect, or being approached, at a tick.
    pub fn state_at(&self, tick: i64) -> &SeaState {
        &self.scene_at(tick).sea
    }

    /// The cascades of every layout that may still be asked for, in the order of [`Sea::cascades`]; its generation is
    /// that of the newest.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The same cascades, each with the ticks at which it is part of the sea.
    pub fn lives(&self) -> impl Iterator<Item = Life> {
        self.eras.iter().flat_map(Era::lives)
    }

    /// The cascade that has a number, or had it last: its place in the order of the layout, and its ticks.
    pub fn life_of(&self, number: u8) -> Option<(usize, Life)> {
        self.lives().enumerate().filter(|(_, life)| life.cascade.index == number).last()
    }

    /// How many changes of layout are in effect at a tick.
    pub fn generation_at(&self, tick: i64) -> u32 {
        let begun = self.eras.iter().rev().find(|era| era.from() <= tick).unwrap_or(&self.eras[0]);
        begun.layout.generation
    }

    /// Sequence of the newest change in effect at a tick; 0 before the first.
    pub fn sequence_at(&self, tick: i64) -> u64 {
        self.stages.sequence_at(tick)
    }

    /// Transitions under way at a tick.
    pub fn overlapping(&self, tick: i64) -> usize {
        self.stages.weights(tick).len() - 1
    }

    /// Significant wave height of the modes at a tick, metres: 4 sqrt of their summed energies.
    pub fn hs_at(&self, tick: i64) -> f64 {
        4.0 * libm::sqrt(self.energies_at(tick).iter().flatten().sum())
    }

    /// Energy of every mode at a tick, m^2, cascade by cascade.
    fn energies_at(&self, tick: i64) -> Vec<Vec<f64>> {
        self.eras.iter().flat_map(|era| era.energies(&self.stages, tick)).collect()
    }

    /// What the sea of a tick is like.
    pub fn statistics_at(&self, tick: i64) -> Statistics {
        let dispersion = Dispersion::new(self.state_at(tick).water);
        let coverage = self.eras.iter().map(|era| era.foam_coverage(&self.stages, tick)).sum();
        let wanted_hs = self.wanted_hs_at(tick);
        let choppiness = self.scene.effects.choppiness;
        let cascades = self.eras.iter().flat_map(|era| {
            let share = era.amplitude(tick) * era.amplitude(tick);
            let energies = era.energies(&self.stages, tick);
            era.layout.cascades.iter().zip(energies).map(move |(cascade, energies)| (cascade, share, energies))
        });
        Statistics::new(&dispersion, cascades, wanted_hs, coverage, choppiness)
    }

    /// What an operator would not expect of the sea that is in effect, or of the layout that is to come.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Builds what the sea needs soon after a tick and has not yet; a sequence of records is built as its time comes.
    pub fn build_ahead(&self, now: i64) {
        self.eras.iter().for_each(|era| era.prepare(&self.stages, now));
    }

    /// 4 sqrt(m0) of the spectrum that is wanted at a tick, resolved by the cascades or not, metres.
    pub fn wanted_hs_at(&self, tick: i64) -> f64 {
        let wanted = self.stages.wanted(tick);
        let wanted = self.there(tick).next().map_or(0.0, |(era, _)| era.wanted_m0(&self.stages, wanted));
        4.0 * libm::sqrt(wanted)
    }

    /// Whether the sea of two ticks is the same but for the turning of its modes.
    pub fn same_sea(&self, a: i64, b: i64) -> bool {
        self.stages.newest(a) == self.stages.newest(b)
            && self.stages.weights(a) == self.stages.weights(b)
            && self.eras.iter().all(|era| era.amplitude(a) == era.amplitude(b))
    }

    /// The sea of a tick.
    pub fn at(&self, tick: i64) -> Sea {
        let repeat = self.scene.repeat.ticks;
        Sea {
            cascades: self.eras.iter().flat_map(|era| era.at(&self.stages, tick, repeat)).collect(),
            repeat,
            choppiness: self.scene.effects.choppiness,
            model: self.scene.model,
            seed: self.scene.seed,
            drift: Drift::of(&self.scene),
        }
    }

    /// Eras whose waves are part of the sea of a tick, and their shares of its amplitude.
    fn there(&self, tick: i64) -> impl Iterator<Item = (&Era, f64)> {
        self.eras.iter().map(move |era| (era, era.amplitude(tick))).filter(|(_, amplitude)| *amplitude > 0.0)
    }

    fn newest_era(&self) -> &Era {
        self.eras.last().expect("there is always one")
    }

    fn insert(&mut self, change: Change, now: i64) {
        let (fade, sequence) = (CrossFade::of(&change), change.sequence);
        let inserted = self.stages.insert(change);
        self.eras.iter_mut().for_each(|era| era.insert(&inserted));
        let Some(fade) = fade else { return };
        let generation = self.newest_era().layout.generation.saturating_add(1);
        let layout = Layout::of_generation(&self.stages.get(inserted.at).scene, generation);
        self.forget_eras(now);
        if let Some(last) = self.eras.last_mut() {
            last.end(fade);
        }
        self.eras.push(Era::new(layout, Some((fade, sequence)), self.stages.len()));
        self.join_layouts();
    }

    /// Builds what frames from `now` on need, and lets go of what none of them can: a log of years is one stage and
    /// the few that may still be seen, and one layout.
    fn prepare(&mut self, now: i64) {
        self.forget_eras(now);
        self.join_layouts();
        let kept = now.saturating_sub(KEEP_TICKS);
        let (oldest, last) = self.stages.over(kept);
        if last > 0 {
            self.since = self.since.max(kept);
        }
        self.eras.iter_mut().for_each(|era| era.fold(&self.stages, oldest, last, self.scene.repeat.ticks));
        self.stages.fold(last);
        self.eras.iter().for_each(|era| era.prepare(&self.stages, now));
        let newest = self.newest_era();
        self.warnings = newest.warnings(&self.stages, now.max(newest.from())).into();
    }

    fn forget_eras(&mut self, now: i64) {
        let (kept, before) = (now.saturating_sub(KEEP_TICKS), self.eras.len());
        self.eras.retain(|era| era.until() > kept);
        if self.eras.len() < before {
            self.since = self.since.max(kept);
        }
    }

    fn join_layouts(&mut self) {
        let cascades = self.eras.iter().flat_map(|era| &era.layout.cascades).copied().collect();
        self.layout = Arc::new(Layout { generation: self.newest_era().layout.generation, cascades });
    }
}
