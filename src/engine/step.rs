//! One tick of the sea under a demand: load what is in effect, step the backend, encode each live unit once.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::AddAssign;
use std::sync::Arc;

use rayon::prelude::*;

use super::answer::{Evaluated, ProbeFields};
use super::channels::{counted, encode_unit};
use super::foam_track::FoamTrack;
use super::point_feed::{PointsMessage, PointsWish, Water, fields_of_points, messages};
use crate::backend::{Backend, BackendError, Surface};
use crate::plan::{CascadePlan, Demand, Field, FieldSet, FoamWork, Plan, Wanted, levels_of};
use crate::scene::{Foam, Model};
use crate::sea::{Layout, Life, Timeline};
use crate::tile::{SentFrame, Stamp, UnitEncoder};
use crate::wire::{Group, UnitName};

/// What one tick gives.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The tick.
    pub tick: i64,
    /// Frames that leave now: of this tick, and of ticks before it that waited for it. Those of one unit stand together,
    /// and of one tick the deepest predictions first.
    pub frames: Vec<SentFrame>,
    /// One for each client whose points are due.
    pub points: Vec<PointsMessage>,
    /// Name of the backend that made it.
    pub backend: &'static str,
    /// Units and messages that were not made, because they held a value that is not finite.
    pub refused: u64,
    /// What it took.
    pub work: Work,
    /// Milliseconds that it took, encoding included; 0 where nobody timed it.
    pub step_ms: f64,
}

/// Transforms, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Real fields that came out of two-dimensional transforms.
    pub transforms: u64,
    /// Samples of those fields.
    pub samples: u64,
}

impl Work {
    fn of(plan: &Plan, layout: &Layout) -> Self {
        let (transforms, samples) = plan.work(layout);
        Self { transforms: transforms as u64, samples: samples as u64 }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, more: Self) {
        self.transforms += more.transforms;
        self.samples += more.samples;
    }
}

/// A sea that is stepped from outside, tick by tick.
pub struct Stepper {
    backend: Box<dyn Backend>,
    /// Encodes. Not rayon's own threads: those build the spectra of a change, and frames must not wait for them.
    encoders: rayon::ThreadPool,
    timeline: Arc<Timeline>,
    epoch: u64,
    /// Tick whose sea the backend holds.
    loaded: Option<i64>,
    /// The newest tick that was run, foam's own included.
    newest: Option<i64>,
    /// Numbers of the cascades whose water can break, in the sea that is loaded.
    breaking: BTreeSet<u8>,
    /// Numbers of the cascades of which somebody wants foam.
    foamy: BTreeSet<u8>,
    /// By number, of the cascades that the timeline has and somebody wants foam of.
    foam: BTreeMap<u8, FoamTrack>,
    /// Of every unit that is wanted.
    units: BTreeMap<UnitName, UnitEncoder>,
    /// Points that clients follow.
    points: Vec<PointsWish>,
    /// What they are read from where the sea is one of trochoids.
    evaluated: Evaluated,
    /// Of foam steps since the last frames.
    work: Work,
}

impl Stepper {
    /// A stepper that has done nothing yet.
    ///
    /// # Panics
    /// If the system gives no threads.
    pub fn new(backend: Box<dyn Backend>, timeline: Arc<Timeline>, epoch: u64) -> Self {
        let encoders = rayon::ThreadPoolBuilder::new().thread_name(|i| format!("swellcast-encode-{i}")).build();
        let encoders = encoders.expect("the system gives threads at start");
        let (breaking, foamy, foam) = (BTreeSet::new(), BTreeSet::new(), BTreeMap::new());
        let (loaded, newest, points, work) = (None, None, Vec::new(), Work::default());
        let (evaluated, units) = (Evaluated::default(), BTreeMap::new());
        Self {
            backend,
            encoders,
            timeline,
            epoch,
            loaded,
            newest,
            breaking,
            foamy,
            foam,
            units,
            points,
            evaluated,
            work,
        }
    }

    /// Name of the backend.
    pub fn backend(&self) -> &'static str {
        self.backend.name()
    }

    /// Takes a timeline that differs from the last one in its future; what it changes of the past is run again.
    pub fn set_timeline(&mut self, timeline: Arc<Timeline>) {
        if self.newest.is_some_and(|tick| timeline.sequence_at(tick) != self.timeline.sequence_at(tick)) {
            self.foam.values_mut().for_each(FoamTrack::forget);
        }
        (self.timeline, self.loaded) = (timeline, None);
        self.evaluated.forget();
        self.keep_tracks();
    }

    /// Forgets what the backend holds: after an error, all of it is loaded and run again.
    pub fn forget(&mut self) {
        self.loaded = None;
        self.foam.values_mut().for_each(FoamTrack::forget);
    }

    /// Takes another backend, which holds nothing yet, and gives back the one before.
    pub fn replace_backend(&mut self, backend: Box<dyn Backend>) -> Box<dyn Backend> {
        self.forget();
        std::mem::replace(&mut self.backend, backend)
    }

    /// The backend, with what it holds.
    pub fn into_backend(self) -> Box<dyn Backend> {
        self.backend
    }

    /// Keeps foam's memory where somebody wants foam and past frames where somebody wants more, and lets them go elsewhere.
    pub fn set_demand(&mut self, demand: &Demand) {
        self.units.retain(|unit, _| demand.contains_key(unit));
        self.foamy = demand.keys().filter(|unit| unit.group == Group::Foam).map(|unit| unit.cascade).collect();
        self.keep_tracks();
    }

    /// Somebody begins to follow a unit: its next frames come also as who has none before them can read them.
    pub fn join(&mut self, unit: UnitName) {
        self.units.entry(unit).or_insert_with(|| UnitEncoder::new(unit)).join();
    }

    /// Points whose water is told at every multiple of their interval.
    pub fn set_points(&mut self, points: Vec<PointsWish>) {
        if points.is_empty() {
            self.evaluated.forget();
        }
        self.points = points;
    }

    fn keep_tracks(&mut self) {
        let settings: Option<Foam> = self.timeline.scene().effects.foam;
        let repeat = self.timeline.scene().repeat.ticks;
        let numbers: BTreeSet<u8> = self.timeline.lives().map(|life| life.cascade.index).collect();
        // A number comes to another cascade when foam of the one before is long forgotten: its track begins anew then.
        self.foam.retain(|number, _| numbers.contains(number) && self.foamy.contains(number));
        if let Some(foam) = settings {
            for number in numbers.intersection(&self.foamy) {
                self.foam.entry(*number).or_insert_with(|| FoamTrack::new(foam, repeat));
            }
        }
    }

    /// Whether frames of `tick` would carry all the foam that is wanted.
    pub fn foam_is_warm(&self, tick: i64) -> bool {
        self.timeline.lives().all(|life| self.missing(&life, tick).is_none())
    }

    /// The foam tick that must be run next of a cascade before its foam can be shown at `tick`.
    fn missing(&self, life: &Life, tick: i64) -> Option<i64> {
        let track = self.foam.get(&life.cascade.index)?;
        if life.is_over(tick) { None } else { track.missing(tick) }
    }

    /// Runs one step of foam that is missing before `tick`; false when none is.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn warm_foam(&mut self, tick: i64) -> Result<bool, BackendError> {
        let timeline = Arc::clone(&self.timeline);
        let Some(foam_tick) = timeline.lives().find_map(|life| self.missing(&life, tick)) else {
            return Ok(false);
        };
        self.load(foam_tick)?;
        let mut plan = Plan::default();
        for life in timeline.lives() {
            // Cascades that stand at the same step are run together.
            let due = self.missing(&life, tick) == Some(foam_tick);
            let track = self.foam.get_mut(&life.cascade.index).filter(|_| due);
            let work = track.map(|track| {
                let work = track.catch_up(foam_tick);
                track.ran(foam_tick);
                work
            });
            // Nobody looks: foam is held where it is made.
            plan.cascades.push(self.work(&life, foam_tick, [], work).leaving(Wanted::default()));
        }
        self.work += Work::of(&plan, timeline.layout());
        self.backend.step(foam_tick, &plan)?;
        Ok(true)
    }

    /// These fields of every cascade at `tick`, foam warm from the first.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn surface(&mut self, tick: i64, fields: FieldSet) -> Result<&Surface, BackendError> {
        let timeline = Arc::clone(&self.timeline);
        if fields.contains(Field::Foam) {
            self.foamy = timeline.lives().map(|life| life.cascade.index).collect();
        }
        self.keep_tracks();
        while self.warm_foam(tick)? {}
        self.load(tick)?;
        let shown = |life: Life| {
            let track = self.foam.get(&life.cascade.index).filter(|_| !life.is_over(tick));
            self.work(&life, tick, [(0, fields)], track.map(|track| track.show(tick)))
        };
        let plan = Plan { cascades: timeline.lives().map(shown).collect() };
        (self.foamy, self.foam) = (BTreeSet::new(), BTreeMap::new());
        self.backend.step(tick, &plan)
    }

    /// Frames of every unit that is wanted at `tick`, and the water at points that are due. Foam is left out where it is
    /// not warm, and all of a cascade at ticks at which it is no part of the sea.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn frames(&mut self, tick: i64, demand: &Demand) -> Result<Batch, BackendError> {
        let timeline = Arc::clone(&self.timeline);
        // Each with the place of its cascade, and the share of its foam that is shown.
        let mut units: Vec<(usize, f32, UnitName)> = Vec::with_capacity(demand.len());
        for (unit, _) in demand.iter().filter(|(_, interval)| tick % **interval == 0) {
            let there = timeline.life_of(unit.cascade).filter(|(_, life)| life.contains(tick));
            // A level that the number had in an earlier layout may be none now.
            let whole = there.filter(|(_, life)| unit.level < life.cascade.levels());
            units.extend(whole.map(|(place, life)| (place, life.foam_left(tick) as f32, *unit)));
        }
        let due: Vec<PointsWish> = self.points.iter().filter(|wish| tick % wish.interval == 0).cloned().collect();
        let of_points = match due.is_empty() {
            true => FieldSet::NONE,
            false => fields_of_points(timeline.scene()),
        };
        self.load(tick)?;
        let mut plan = Plan::default();
        for (place, life) in timeline.lives().enumerate() {
            let here = units.iter().filter(|(at, ..)| *at == place).map(|(.., unit)| unit);
            // On the foam grid foam advances even when no frame of it is wanted, or the next would find a gap.
            let warm = !life.is_over(tick) && self.missing(&life, tick).is_none();
            let foam = self.foam.get_mut(&life.cascade.index).filter(|_| warm).and_then(|track| {
                let work = track.show(tick);
                if work.advance {
                    track.ran(tick);
                }
                (work.advance || here.clone().any(|unit| unit.group == Group::Foam)).then_some(work)
            });
            let counts = here.clone().flat_map(|unit| counted(*unit, life.foam_left(tick) as f32)).collect();
            let levels = levels_of(here.clone()).chain([(0, of_points)]);
            let floats = here.clone().any(|unit| unit.codec.is_float());
            let work = self.work(&life, tick, levels, foam);
            // Who studies floats looks at everything.
            let whole = |work: CascadePlan| work.leaving(Wanted { counts, samples: of_points });
            plan.cascades.push(if floats { work } else { whole(work) });
        }
        let mut done = std::mem::take(&mut self.work);
        done += Work::of(&plan, timeline.layout());
        let backend = self.backend.name();
        let surface = self.backend.step(tick, &plan)?;
        let stamp = Stamp {
            tick: surface.tick,
            epoch: self.epoch,
            sequence: timeline.sequence_at(surface.tick),
            layout: timeline.generation_at(surface.tick),
        };
        // Each with its encoder, which goes back when it is done.
        let mut due_units = Vec::with_capacity(units.len());
        for (place, foam, unit) in units {
            let encoder = self.units.remove(&unit).unwrap_or_else(|| UnitEncoder::new(unit));
            due_units.push((place, foam, unit, encoder));
        }
        let encode = |(place, foam, unit, mut encoder): (usize, f32, UnitName, UnitEncoder)| {
            let frames = encode_unit(surface.cascades.get(place), unit, foam, stamp, &mut encoder);
            (unit, encoder, frames)
        };
        let (wanted, evaluated) = (ProbeFields::of(&timeline.scene().effects), &mut self.evaluated);
        let tell = || match timeline.scene().model {
            _ if due.is_empty() => Vec::new(),
            Model::Fft => messages(&due, Water::Grids(surface, timeline.layout()), wanted, stamp),
            Model::Trochoid(_) => {
                messages(&due, Water::Trochoids(evaluated.at(&timeline, surface.tick)), wanted, stamp)
            }
        };
        // Together, so that no thread rests while the other kind is left to do.
        let (encoded, points): (Vec<_>, Vec<_>) =
            self.encoders.install(|| rayon::join(|| due_units.into_par_iter().map(encode).collect(), tell));
        let told = points.len();
        let points: Vec<PointsMessage> = points.into_iter().flatten().collect();
        let (refused, frames) = ((told - points.len()) as u64, Vec::with_capacity(encoded.len()));
        let mut batch = Batch { tick: surface.tick, frames, points, backend, refused, work: done, step_ms: 0.0 };
        for (unit, encoder, frames) in encoded {
            self.units.insert(unit, encoder);
            match frames {
                Ok(frames) => batch.frames.extend(frames),
                Err(error) => {
                    tracing::error!(tick, ?unit, %error, "frame refused");
                    batch.refused += 1;
                }
            }
        }
        Ok(batch)
    }

    /// Work of one cascade. Where it is no part of the sea it is still water: nothing needs a transform.
    fn work(
        &self,
        life: &Life,
        tick: i64,
        levels: impl IntoIterator<Item = (u8, FieldSet)>,
        foam: Option<FoamWork>,
    ) -> CascadePlan {
        let scene = self.timeline.scene();
        let breaks = self.breaking.contains(&life.cascade.index);
        let foam = foam.map(|foam| FoamWork { breaks, ..foam });
        let plan = CascadePlan::new(levels, foam, &scene.effects).by(scene.model);
        if life.contains(tick) { plan } else { plan.still() }
    }

    fn load(&mut self, tick: i64) -> Result<(), BackendError> {
        if !self.loaded.is_some_and(|loaded| self.timeline.same_sea(loaded, tick)) {
            let sea = self.timeline.at(tick);
            self.breaking = sea.cascades.iter().filter(|c| c.breaks()).map(|c| c.cascade.index).collect();
            self.backend.load(&sea)?;
        }
        self.loaded = Some(tick);
        self.newest = self.newest.max(Some(tick));
        Ok(())
    }
}
