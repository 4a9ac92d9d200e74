//! Probes a sea at points of the world: computes what they need of it and no more, and nothing twice.

use std::sync::Arc;

use thiserror::Error;

use super::answer::{DIRECT_LOOKS, Evaluated, ProbeAnswer, ProbeFields, from_grids, from_modes, from_trochoids};
use super::direct::DirectSum;
use crate::backend::{Backend, BackendError};
use crate::plan::{CascadePlan, FieldSet, Plan};
use crate::scene::Model;
use crate::sea::Timeline;

/// Most terms that a direct sum may come to, were every point to take every look at the modes that it may: two seconds of
/// one core. Points that need a few steps, as nearly all do, take a fifth of that.
const MAX_DIRECT_SUMS: usize = 800_000_000;

/// How the sea is summed at a point. Trochoids are evaluated where they are asked for, whichever is named.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ProbeMethod {
    /// Bicubic, from the grids of the backend.
    #[default]
    Grid,
    /// The strongest modes that hold this share of the energy, 0 to 1, one by one in f64.
    Direct {
        /// 1: all modes.
        share: f64,
    },
}

/// The water at some points, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Probed {
    /// The tick.
    pub tick: i64,
    /// Newest entry of the log in effect at the tick.
    pub sequence: u64,
    /// In the order of the points.
    pub answers: Vec<ProbeAnswer>,
    /// Two-dimensional transforms that were made for them.
    pub transforms: u64,
    /// Root mean square of the height of the modes that were left out, metres.
    pub omitted_rms_m: f64,
}

/// Why points can't be probed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProbeError {
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// Too much to sum.
    #[error("{points} points of {modes} modes each are too many to sum directly: at most {most} points")]
    TooManySums {
        /// Points that were asked for.
        points: usize,
        /// Modes summed at each.
        modes: usize,
        /// Most points of so many modes.
        most: usize,
    },
}

/// Answers for points of a sea, from a backend of its own.
pub struct Prober {
    backend: Box<dyn Backend>,
    timeline: Arc<Timeline>,
    /// Tick whose sea the backend holds.
    loaded: Option<i64>,
    /// Tick and fields of the surface that the backend made last.
    made: Option<(i64, FieldSet)>,
    /// Tick and share of the modes that were summed last.
    summed: Option<(i64, f64, DirectSum)>,
    evaluated: Evaluated,
}

impl Prober {
    /// A prober that has done nothing yet.
    pub fn new(backend: Box<dyn Backend>, timeline: Arc<Timeline>) -> Self {
        Self { backend, timeline, loaded: None, made: None, summed: None, evaluated: Evaluated::default() }
    }

    /// The timeline from the next probe on.
    pub fn set_timeline(&mut self, timeline: Arc<Timeline>) {
        if !Arc::ptr_eq(&self.timeline, &timeline) {
            self.timeline = timeline;
            self.forget();
        }
    }

    /// The first tick whose sea is known.
    pub fn since(&self) -> i64 {
        self.timeline.since()
    }

    fn forget(&mut self) {
        (self.loaded, self.made, self.summed) = (None, None, None);
        self.evaluated.forget();
    }

    /// The water above these points (x, z) of the world, metres, at a tick. The surface of the last tick is kept: what
    /// it has is not made again.
    ///
    /// # Errors
    /// [`ProbeError`].
    pub fn probe(
        &mut self,
        tick: i64,
        points: &[[f64; 2]],
        wanted: ProbeFields,
        method: ProbeMethod,
    ) -> Result<Probed, ProbeError> {
        let (sequence, choppiness) = (self.timeline.sequence_at(tick), self.timeline.scene().effects.choppiness);
        let (answers, transforms, omitted_rms_m) = match method {
            _ if self.timeline.scene().model != Model::Fft => {
                (from_trochoids(self.evaluated.at(&self.timeline, tick), tick, points, wanted), 0, 0.0)
            }
            ProbeMethod::Grid => {
                let transforms = match self.make(tick, wanted.needed(choppiness)) {
                    Ok(transforms) => transforms,
                    Err(error) => {
                        self.forget();
                        return Err(error.into());
                    }
                };
                let patches = self.timeline.layout().cascades.iter().map(|cascade| cascade.patch_m);
                (from_grids(self.backend.surface(), patches, points, wanted, None), transforms, 0.0)
            }
            ProbeMethod::Direct { share } => {
                let sum = self.sum(tick, share);
                let (modes, most) = (sum.modes(), (MAX_DIRECT_SUMS / DIRECT_LOOKS / sum.modes().max(1)).max(1));
                if points.len() > most {
                    return Err(ProbeError::TooManySums { points: points.len(), modes, most });
                }
                (points.iter().map(|point| from_modes(sum, *point, wanted)).collect(), 0, sum.omitted_rms_m)
            }
        };
        Ok(Probed { tick, sequence, answers, transforms, omitted_rms_m })
    }

    /// Makes a surface with these fields, unless it is the last; returns the transforms it took.
    fn make(&mut self, tick: i64, needed: FieldSet) -> Result<u64, BackendError> {
        let held = self.made.filter(|(made, _)| *made == tick).map_or(FieldSet::NONE, |(_, fields)| fields);
        if needed.difference(held).is_empty() {
            return Ok(0);
        }
        let fields = needed.union(held);
        let effects = &self.timeline.scene().effects;
        // Where a cascade is no part of the sea it is still water, and nothing is made of it.
        let work = |there: bool| match there {
            true => CascadePlan::new([(0, fields)], None, effects),
            false => CascadePlan::default(),
        };
        let plan = Plan { cascades: self.timeline.lives().map(|life| work(life.contains(tick))).collect() };
        if !self.loaded.is_some_and(|loaded| self.timeline.same_sea(loaded, tick)) {
            self.backend.load(&self.timeline.at(tick))?;
            self.loaded = Some(tick);
        }
        self.backend.step(tick, &plan)?;
        self.made = Some((tick, fields));
        Ok(plan.work(self.timeline.layout()).0 as u64)
    }

    fn sum(&mut self, tick: i64, share: f64) -> &DirectSum {
        let held = self.summed.take().filter(|(at, of, _)| (*at, *of) == (tick, share));
        let sum = held.unwrap_or_else(|| (tick, share, DirectSum::new(&self.timeline.at(tick), tick, share)));
        &self.summed.insert(sum).2
    }
}
