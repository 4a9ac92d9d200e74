//! Which passes a demand needs: the fewest transforms for the fields that somebody wants. Pure.
//!
//! A [`Demand`] is what subscribers want. Of one tick of it, each cascade's [`CascadePlan`] says which levels are made,
//! of which fields, by which transforms. Backends execute a [`Plan`] and know nothing of clients, rates or units.

mod demand;
mod field;
mod packing;
mod passes;

pub use demand::{Demand, LINGER_TICKS, Lingering, fields_of};
pub use field::{Field, FieldSet};
pub use packing::Packing;
pub use passes::{Listing, PassLine, levels_of};

use crate::scene::{Effects, Model, Normals};
use crate::sea::Layout;

/// What foam has to do at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamWork {
    /// Forget what is held and begin with none.
    pub restart: bool,
    /// Share of the held foam that is left: of one foam step when advancing, else since the last one.
    pub decay: f32,
    /// Share of its growth that foam makes in that time.
    pub growth: f32,
    /// The tick is on the foam grid: what is made here is what is held from now on.
    pub advance: bool,
    /// Water of this cascade can break. Where none can, foam only fades, and no Jacobian is needed.
    pub breaks: bool,
}

/// Work on one level of detail of one cascade.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelPlan {
    /// The level: a grid of its own, with the waves that it can hold.
    pub level: u8,
    /// Fields to leave on the surface.
    pub fields: FieldSet,
    /// Transforms that give them, or what they are assembled from.
    pub transforms: Vec<Packing>,
    /// How normals are made, where they are among the fields.
    pub normals: Normals,
}

/// A field as it goes on the wire: whole multiples of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counted {
    /// The level; of foam, which is made on the full grid, averages for it.
    pub level: u8,
    /// The field.
    pub field: Field,
    /// What one count is worth.
    pub step: f32,
    /// Factor on every sample: the share of foam that is shown where a cascade comes or goes.
    pub share: f32,
}

/// All that is looked at of a cascade after a step. A backend from which reading is dear leaves no more than that.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Fields as counts.
    pub counts: Vec<Counted>,
    /// Fields of the full grid as samples.
    pub samples: FieldSet,
}

impl Wanted {
    /// Whether nothing is looked at.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty() && self.samples.is_empty()
    }
}

/// Work for one cascade at one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CascadePlan {
    /// Finest first; the full grid among them where there is foam.
    pub levels: Vec<LevelPlan>,
    /// Foam, always of the full grid, where it is wanted.
    pub foam: Option<FoamWork>,
    /// What is looked at; `None`: every field, as samples.
    pub wanted: Option<Wanted>,
}

/// Work for every cascade at one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// In the order of the layout.
    pub cascades: Vec<CascadePlan>,
}

impl LevelPlan {
    /// The least work that gives `fields`. Without choppiness nothing moves sideways: those fields are zero and need no
    /// transform.
    fn new(level: u8, fields: FieldSet, effects: &Effects) -> Self {
        let mut sources = fields.union(assembled_from(fields, effects.normals));
        if effects.choppiness == 0.0 {
            sources = sources.difference(FieldSet::SIDEWAYS);
        }
        Self { level, fields, transforms: Packing::of(sources).collect(), normals: effects.normals }
    }

    /// Fields that come out of its transforms.
    pub fn transformed(&self) -> FieldSet {
        self.transforms.iter().fold(FieldSet::NONE, |set, packing| set.union(packing.fields()))
    }

    /// Fields that it computes: those wanted, and those they are made of.
    pub fn computed(&self) -> FieldSet {
        self.transformed().union(self.fields).union(assembled_from(self.fields, self.normals))
    }

    /// Number of real fields that are transformed; a packed transform counts as two.
    pub fn transforms(&self) -> usize {
        self.transformed().len()
    }
}

/// Fields that others are made of, sample by sample.
fn assembled_from(fields: FieldSet, normals: Normals) -> FieldSet {
    const MAPPING: FieldSet = FieldSet::of(&[Field::Jacobian, Field::Eigenvalue]);
    const NORMALS: FieldSet = FieldSet::of(&[Field::NormalX, Field::NormalZ]);
    let mut sources = FieldSet::NONE;
    if !fields.intersection(MAPPING).is_empty() {
        sources = sources.union(FieldSet::DERIVATIVES);
    }
    if !fields.intersection(NORMALS).is_empty() {
        sources = sources.union(match normals {
            Normals::None => FieldSet::NONE,
            Normals::Exact | Normals::DisplacedSlopes => {
                FieldSet::DERIVATIVES.union(FieldSet::of(&[Field::SlopeX, Field::SlopeZ]))
            }
            Normals::Diagonal => FieldSet::of(&[Field::SlopeX, Field::SlopeZ, Field::Dxx, Field::Dzz]),
            Normals::CentralDifference | Normals::Sobel => FieldSet::of(&[Field::Height, Field::Dx, Field::Dz]),
        });
    }
    sources
}

impl CascadePlan {
    /// The least work that gives these fields at these levels, and foam.
    pub fn new(levels: impl IntoIterator<Item = (u8, FieldSet)>, foam: Option<FoamWork>, effects: &Effects) -> Self {
        let mut wanted: Vec<(u8, FieldSet)> = Vec::new();
        let of_foam = foam.map(|foam| {
            let made = FieldSet::of(&[Field::Foam]);
            (0, if foam.breaks { made.with(Field::Jacobian) } else { made })
        });
        for (level, fields) in levels.into_iter().chain(of_foam) {
            let fields = if foam.is_none() { fields.difference(FieldSet::of(&[Field::Foam])) } else { fields };
            match wanted.iter_mut().find(|(known, _)| *known == level) {
                Some((_, known)) => *known = known.union(fields),
                None => wanted.push((level, fields)),
            }
        }
        wanted.sort_by_key(|(level, _)| *level);
        let wanted = wanted.into_iter().filter(|(_, fields)| !fields.is_empty());
        let levels = wanted.map(|(level, fields)| LevelPlan::new(level, fields, effects)).collect();
        Self { levels, foam, wanted: None }
    }

    /// The same, of which no more is looked at than this.
    pub fn leaving(self, wanted: Wanted) -> Self {
        Self { wanted: Some(wanted), ..self }
    }

    /// The same by this model: trochoids give every field by themselves, and need no transform.
    pub fn by(self, model: Model) -> Self {
        match model {
            Model::Fft => self,
            Model::Trochoid(_) => self.still(),
        }
    }

    /// The same where there are no waves: fields are zero and need no transform, foam goes on.
    pub fn still(mut self) -> Self {
        self.levels.iter_mut().for_each(|level| level.transforms.clear());
        self
    }

    /// Number of real fields that are transformed.
    pub fn transforms(&self) -> usize {
        self.levels.iter().map(LevelPlan::transforms).sum()
    }
}

impl Plan {
    /// Number of real fields that are transformed, a packed transform counting as two, and of their samples, on a
    /// layout.
    pub fn work(&self, layout: &Layout) -> (usize, usize) {
        let levels = self.cascades.iter().zip(&layout.cascades);
        let levels = levels.flat_map(|(plan, cascade)| plan.levels.iter().map(move |level| (level, cascade)));
        levels.fold((0, 0), |(transforms, samples), (level, cascade)| {
            let (n, _) = cascade.level(level.level);
            (transforms + level.transforms(), samples + level.transforms() * n * n)
        })
    }
}
