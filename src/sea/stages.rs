//! The log as a fold: what is in effect at a tick, and which seas are blended there.
//!
//! Each change, and each record of a sequence, begins a [`Stage`]. Under way, it is blended over what came before by a
//! smoothstep of the tick; one that interrupts another is blended over it while the other goes on, and when it is over,
//! so is the other. A change of layout is a stage that is not blended: it alters no spectrum, and the cross-fade is its
//! [`super::era::Era`]'s.

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
    cause: Cause,
    /// Everything that a change can alter, as it is after this one.
    pub scene: Arc<Scene>,
}

/// What begins a stage.
#[derive(Clone, Debug)]
enum Cause {
    /// The scene itself, or what was folded into one.
    Beginning,
    /// An entry of the log.
    Change(Change),
    /// A record of the scene's own sequence, by its place in that.
    Record(usize),
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
    /// A scene and the sequence of records that it brings along.
    pub fn new(scene: &Scene) -> Self {
        let scene = Arc::new(scene.clone());
        let mut list =
            vec![Stage { sequence: 0, effective_tick: i64::MIN, transition_ticks: 0, cause: Cause::Beginning, scene }];
        let replay = list[0].scene.replay.clone();
        for (i, tick) in replay.iter().flat_map(|replay| replay.ticks()).enumerate() {
            let transition_ticks = replay.as_ref().map_or(0, |replay| replay.transition_ticks);
            list.push(Stage::new(0, tick, transition_ticks, Cause::Record(i), &list[i].scene));
        }
        Self { list }
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    pub fn get(&self, index: usize) -> &Stage {
        &self.list[index]
    }

    /// Changes that are not folded away, in order.
    pub fn changes(&self) -> impl Iterator<Item = &Change> {
        self.list.iter().filter_map(|stage| if let Cause::Change(change) = &stage.cause { Some(change) } else { None })
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
        let Change { sequence, effective_tick, transition_ticks, .. } = change;
        let stage = Stage::new(sequence, effective_tick, transition_ticks, Cause::Change(change), &before);
        self.list.insert(at, stage);
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
        let base = Stage { sequence, effective_tick: i64::MIN, transition_ticks: 0, cause: Cause::Beginning, scene };
        self.list.splice(..=last, [base]);
    }
}

impl Stage {
    fn new(sequence: u64, effective_tick: i64, transition_ticks: i64, cause: Cause, before: &Arc<Scene>) -> Self {
        let mut stage = Self { sequence, effective_tick, transition_ticks, cause, scene: Arc::clone(before) };
        stage.scene = stage.after(before);
        stage
    }

    fn after(&self, before: &Arc<Scene>) -> Arc<Scene> {
        let mut scene = Scene::clone(before);
        match &self.cause {
            Cause::Beginning => return Arc::clone(before),
            Cause::Change(change) => change.kind.apply(&mut scene),
            Cause::Record(index) => {
                let record = scene.replay.as_ref().and_then(|replay| replay.records.get(*index)).cloned();
                scene.sea.measured = record.or(scene.sea.measured);
            }
        }
        Arc::new(scene)
    }

    /// Whether it changes the layout and nothing else.
    pub fn is_layout(&self) -> bool {
        matches!(&self.cause, Cause::Change(change) if CrossFade::of(change).is_some())
    }

    /// Whether it is a record of the scene's own sequence.
    pub fn is_record(&self) -> bool {
        matches!(self.cause, Cause::Record(_))
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
