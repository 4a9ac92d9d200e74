//! The log as a fold: what is in effect at a tick, and which seas are blended there.
//!
//! Each change begins a [`Stage`]. Under way, it is blended over what came before by a smoothstep of the tick; a
//! change that interrupts another is blended over it while the other goes on. A change of layout is a stage that is
//! not blended: it alters no spectrum, and the cross-fade is its [`super::era::Era`]'s.

use std::sync::Arc;

use crate::scene::{Change, CrossFade, Scene};

/// The scene and its changes, in order of (effective tick, sequence).
#[derive(Clone, Debug)]
pub struct Stages {
    /// The first is the scene itself, in effect since for ever.
    list: Vec<Stage>,
}

/// What is in effect from a change on.
#[derive(Clone, Debug)]
pub struct Stage {
    pub sequence: u64,
    pub effective_tick: i64,
    transition_ticks: i64,
    change: Option<Change>,
    /// Everything that a change can alter, as it is after this one.
    pub scene: Arc<Scene>,
}

/// What an insertion altered beside what it added.
#[derive(Debug)]
pub struct Inserted {
    /// Place of the new stage.
    pub at: usize,
    /// Later stages whose sea is another now.
    pub seas: Vec<usize>,
    /// The first stage, the new one included, in which waves turn otherwise.
    pub turning: Option<usize>,
}

impl Stages {
    pub fn new(scene: &Scene) -> Self {
        let scene = Arc::new(scene.clone());
        let first = Stage { sequence: 0, effective_tick: i64::MIN, transition_ticks: 0, change: None, scene };
        Self { list: vec![first] }
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    pub fn get(&self, index: usize) -> &Stage {
        &self.list[index]
    }

    /// Changes that are not folded away, in order.
    pub fn changes(&self) -> impl Iterator<Item = &Change> {
        self.list.iter().filter_map(|stage| stage.change.as_ref())
    }

    /// Index of the stage in effect at a tick.
    pub fn newest(&self, tick: i64) -> usize {
        self.list.partition_point(|stage| stage.effective_tick <= tick).max(1) - 1
    }

    /// Index of the stage whose spectrum is wanted at a tick.
    pub fn wanted(&self, tick: i64) -> usize {
        (0..=self.newest(tick)).rev().find(|index| !self.list[*index].is_layout()).unwrap_or(0)
    }

    /// Index of the last stage before a change of this key.
    pub fn before(&self, key: (i64, u64)) -> usize {
        self.list.partition_point(|stage| (stage.effective_tick, stage.sequence) < key).max(1) - 1
    }

    /// Sequence of the newest change in effect at a tick; 0 before the first.
    pub fn sequence_at(&self, tick: i64) -> u64 {
        self.list.iter().filter(|stage| stage.effective_tick <= tick).map(|stage| stage.sequence).max().unwrap_or(0)
    }

    /// Stages that make the sea of a tick, newest first, and their shares of its amplitude, which sum to 1.
    pub fn weights(&self, tick: i64) -> Vec<(usize, f64)> {
        let mut rest = 1.0;
        let mut weights = Vec::with_capacity(2);
        for index in (0..=self.newest(tick)).rev().filter(|index| !self.list[*index].is_layout()) {
            let share = self.list[index].share(tick);
            if share > 0.0 || index == 0 {
                weights.push((index, rest * share));
            }
            rest *= 1.0 - share;
            if rest == 0.0 {
                break;
            }
        }
        weights
    }

    pub fn insert(&mut self, change: Change) -> Inserted {
        let at = self.before((change.effective_tick, change.sequence)) + 1;
        let before = Arc::clone(&self.list[at - 1].scene);
        self.list.insert(at, Stage::new(change, &before));
        let mut inserted = Inserted { at, seas: Vec::new(), turning: None };
        if self.list[at].scene.sea.water != before.sea.water {
            inserted.turning = Some(at);
        }
        // What a later change doesn't set, it inherits: fold again from here.
        for i in at + 1..self.list.len() {
            let scene = self.list[i].after(&self.list[i - 1].scene);
            let old = std::mem::replace(&mut self.list[i].scene, scene);
            let new = &self.list[i].scene;
            if new.sea != old.sea {
                inserted.seas.push(i);
            }
            if new.sea.water != old.sea.water {
                inserted.turning = inserted.turning.or(Some(i));
            }
        }
        inserted
    }

    /// What was over at a tick: the stage whose sea is the oldest still blended there, and the last stage that can be
    /// folded into one with it.
    pub fn over(&self, tick: i64) -> (usize, usize) {
        let oldest = self.weights(tick).last().map_or(0, |(index, _)| *index);
        let newest = self.newest(tick);
        let rest = (oldest + 1..=newest).find(|index| !self.list[*index].is_layout());
        (oldest, rest.map_or(newest, |index| index - 1))
    }

    /// Makes one stage of the first ones, up to and with `last`.
    pub fn fold(&mut self, last: usize) {
        let sequence = self.list[..=last].iter().map(|stage| stage.sequence).max().unwrap_or(0);
        let scene = Arc::clone(&self.list[last].scene);
        let base = Stage { sequence, effective_tick: i64::MIN, transition_ticks: 0, change: None, scene };
        self.list.splice(..=last, [base]);
    }
}

impl Stage {
    fn new(change: Change, before: &Arc<Scene>) -> Self {
        let Change { sequence, effective_tick, transition_ticks, .. } = change;
        let mut stage =
            Self { sequence, effective_tick, transition_ticks, change: Some(change), scene: Arc::clone(before) };
        stage.scene = stage.after(before);
        stage
    }

    fn after(&self, before: &Arc<Scene>) -> Arc<Scene> {
        let Some(change) = &self.change else { return Arc::clone(before) };
        let mut scene = Scene::clone(before);
        change.kind.apply(&mut scene);
        Arc::new(scene)
    }

    /// Whether it changes the layout and nothing else.
    pub fn is_layout(&self) -> bool {
        self.change.as_ref().and_then(CrossFade::of).is_some()
    }

    /// Smoothstep of the way through this stage's transition, 0 to 1.
    fn share(&self, tick: i64) -> f64 {
        let since = tick.saturating_sub(self.effective_tick);
        if since >= self.transition_ticks {
            return 1.0;
        }
        let t = since as f64 / self.transition_ticks as f64;
        t * t * (3.0 - 2.0 * t)
    }
}
