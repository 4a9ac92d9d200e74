//! One tick of the sea under a demand: load what is in effect, step the backend, encode each live unit once.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytes::Bytes;
use rayon::prelude::*;

use super::foam_track::FoamTrack;
use crate::backend::{Backend, BackendError, Surface};
use crate::plan::{CascadePlan, Field, FieldSet, Plan};
use crate::scene::Foam;
use crate::sea::Timeline;
use crate::tile::{EncodeError, Stamp, encode};
use crate::wire::{Group, UnitName};

/// What subscribers want: each live unit and the smallest interval, in ticks, at which somebody wants it.
pub type Demand = BTreeMap<UnitName, i64>;

/// All frames of one tick.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The tick.
    pub tick: i64,
    /// A unit appears once per tile.
    pub frames: Vec<(UnitName, Bytes)>,
    /// Units whose frame was not made, because it held a value that is not finite.
    pub refused: u64,
    /// Two-dimensional transforms it took.
    pub transforms: u64,
}

/// Fields a group is made of, in the order of its channels.
fn fields(group: Group) -> &'static [Field] {
    match group {
        Group::Displacement => &[Field::Dx, Field::Height, Field::Dz],
        Group::Slopes => &[Field::SlopeX, Field::SlopeZ],
        Group::Derivatives => &[Field::Dxx, Field::Dzz, Field::Dxz],
        Group::Foam => &[Field::Foam],
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
    /// Per cascade; `None` where nobody wants foam.
    foam: Vec<Option<FoamTrack>>,
    transforms: u64,
}

impl Stepper {
    /// A stepper that has done nothing yet.
    ///
    /// # Panics
    /// If the system gives no threads.
    pub fn new(backend: Box<dyn Backend>, timeline: Arc<Timeline>, epoch: u64) -> Self {
        let foam = vec![None; timeline.layout().cascades.len()];
        let encoders = rayon::ThreadPoolBuilder::new().thread_name(|i| format!("swellcast-encode-{i}")).build();
        let encoders = encoders.expect("the system gives threads at start");
        Self { backend, encoders, timeline, epoch, loaded: None, newest: None, foam, transforms: 0 }
    }

    /// Name of the backend.
    pub fn backend(&self) -> &'static str {
        self.backend.name()
    }

    /// Takes a timeline that differs from the last one in its future; what it changes of the past is run again.
    pub fn set_timeline(&mut self, timeline: Arc<Timeline>) {
        if self.newest.is_some_and(|tick| timeline.sequence_at(tick) != self.timeline.sequence_at(tick)) {
            self.foam.iter_mut().flatten().for_each(FoamTrack::forget);
        }
        (self.timeline, self.loaded) = (timeline, None);
    }

    /// Forgets what the backend holds: after an error, all of it is loaded and run again.
    pub fn forget(&mut self) {
        self.loaded = None;
        self.foam.iter_mut().flatten().for_each(FoamTrack::forget);
    }

    /// Keeps foam's memory where somebody wants foam, and lets it go elsewhere.
    pub fn set_demand(&mut self, demand: &Demand) {
        let settings: Option<Foam> = self.timeline.scene().effects.foam;
        let repeat = self.timeline.scene().repeat.ticks;
        for (cascade, track) in self.foam.iter_mut().enumerate() {
            let wanted = demand.keys().any(|unit| usize::from(unit.cascade) == cascade && unit.group == Group::Foam);
            match (settings.filter(|_| wanted), &track) {
                (Some(foam), None) => *track = Some(FoamTrack::new(foam, repeat)),
                (None, _) => *track = None,
                (Some(_), Some(_)) => {}
            }
        }
    }

    /// Whether frames of `tick` would carry all the foam that is wanted.
    pub fn foam_is_warm(&self, tick: i64) -> bool {
        self.foam.iter().flatten().all(|track| track.missing(tick).is_none())
    }

    /// Runs one step of foam that is missing before `tick`; false when none is.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn warm_foam(&mut self, tick: i64) -> Result<bool, BackendError> {
        let Some(foam_tick) = self.foam.iter().flatten().find_map(|track| track.missing(tick)) else {
            return Ok(false);
        };
        self.load(foam_tick)?;
        let choppiness = self.timeline.scene().effects.choppiness;
        let mut plan = Plan::default();
        for track in &mut self.foam {
            // Cascades that stand at the same step are run together.
            let track = track.as_mut().filter(|track| track.missing(tick) == Some(foam_tick));
            let work = track.as_ref().map(|track| track.catch_up(foam_tick));
            plan.cascades.push(CascadePlan::new(FieldSet::NONE, work, choppiness));
            if let Some(track) = track {
                track.ran(foam_tick);
            }
        }
        self.transforms += plan.transforms() as u64;
        self.backend.step(foam_tick, &plan)?;
        Ok(true)
    }

    /// These fields of every cascade at `tick`, foam warm from the first.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn surface(&mut self, tick: i64, fields: FieldSet) -> Result<&Surface, BackendError> {
        let settings = self.timeline.scene().effects.foam.filter(|_| fields.contains(Field::Foam));
        let repeat = self.timeline.scene().repeat.ticks;
        self.foam.fill_with(|| settings.map(|foam| FoamTrack::new(foam, repeat)));
        while self.warm_foam(tick)? {}
        self.load(tick)?;
        let choppiness = self.timeline.scene().effects.choppiness;
        let cascade = |track: &Option<FoamTrack>| {
            CascadePlan::new(fields, track.as_ref().map(|track| track.show(tick)), choppiness)
        };
        let plan = Plan { cascades: self.foam.iter().map(cascade).collect() };
        self.foam.fill(None);
        self.backend.step(tick, &plan)
    }

    /// Frames of every unit that is wanted at `tick`. Foam is left out where it is not warm.
    ///
    /// # Errors
    /// [`BackendError`].
    pub fn frames(&mut self, tick: i64, demand: &Demand) -> Result<Batch, BackendError> {
        let choppiness = self.timeline.scene().effects.choppiness;
        let mut units: Vec<UnitName> = Vec::with_capacity(demand.len());
        units.extend(demand.iter().filter(|(_, interval)| tick % **interval == 0).map(|(unit, _)| *unit));
        let mut plan = Plan::default();
        for (cascade, track) in self.foam.iter_mut().enumerate() {
            let here = units.iter().filter(|unit| usize::from(unit.cascade) == cascade);
            let wanted = here.fold(FieldSet::NONE, |set, unit| set.union(FieldSet::of(fields(unit.group))));
            // On the foam grid foam advances even when no frame of it is wanted, or the next would find a gap.
            let warm = track.as_mut().filter(|track| track.missing(tick).is_none());
            let foam = warm.and_then(|track| {
                let work = track.show(tick);
                if work.advance {
                    track.ran(tick);
                }
                (work.advance || wanted.contains(Field::Foam)).then_some(work)
            });
            plan.cascades.push(CascadePlan::new(wanted.difference(FieldSet::of(&[Field::Foam])), foam, choppiness));
        }
        self.load(tick)?;
        let transforms = self.transforms + plan.transforms() as u64;
        self.transforms = 0;
        let surface = self.backend.step(tick, &plan)?;
        let stamp = Stamp {
            tick: surface.tick,
            epoch: self.epoch,
            sequence: self.timeline.sequence_at(surface.tick),
            layout: self.timeline.layout().generation,
        };
        let encode = |unit| (unit, encode_unit(surface, unit, stamp));
        let encoded: Vec<_> = self.encoders.install(|| units.into_par_iter().map(encode).collect());
        let mut batch = Batch { tick: surface.tick, frames: Vec::with_capacity(encoded.len()), refused: 0, transforms };
        for (unit, frames) in encoded {
            match frames {
                Ok(frames) => batch.frames.extend(frames.into_iter().map(|frame| (unit, frame))),
                Err(error) => {
                    tracing::error!(tick, ?unit, %error, "frame refused");
                    batch.refused += 1;
                }
            }
        }
        Ok(batch)
    }

    fn load(&mut self, tick: i64) -> Result<(), BackendError> {
        if !self.loaded.is_some_and(|loaded| self.timeline.same_sea(loaded, tick)) {
            self.backend.load(&self.timeline.at(tick))?;
        }
        self.loaded = Some(tick);
        self.newest = self.newest.max(Some(tick));
        Ok(())
    }
}

/// Nothing where a field of the unit was not made (foam that is not warm).
fn encode_unit(surface: &Surface, unit: UnitName, stamp: Stamp) -> Result<Vec<Bytes>, EncodeError> {
    let Some(cascade) = surface.cascades.get(usize::from(unit.cascade)) else { return Ok(Vec::new()) };
    let planes: Option<Vec<&[f32]>> = fields(unit.group).iter().map(|field| cascade.plane(*field)).collect();
    planes.map_or_else(|| Ok(Vec::new()), |planes| encode(unit, cascade.n, &planes, stamp))
}
