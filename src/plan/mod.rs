//! Which passes a demand needs: the fewest transforms for the fields that somebody wants. Pure.
//!
//! Backends execute a [`Plan`] and know nothing of clients, rates or units.

mod field;

pub use field::{Field, FieldSet};

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
}

/// Work for one cascade at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CascadePlan {
    /// Fields to leave on the surface.
    pub fields: FieldSet,
    /// Fields that need a transform: those wanted, and those others are assembled from.
    pub transforms: FieldSet,
    /// Foam, where it is wanted.
    pub foam: Option<FoamWork>,
}

/// Work for every cascade at one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// In the order of the layout.
    pub cascades: Vec<CascadePlan>,
}

impl CascadePlan {
    /// The least work that gives `fields`, and foam. Without choppiness nothing moves sideways: those fields are
    /// zero and need no transform.
    pub fn new(fields: FieldSet, foam: Option<FoamWork>, choppiness: f64) -> Self {
        let mut transforms = fields.intersection(FieldSet::SPECTRAL);
        if foam.is_some() || fields.contains(Field::Jacobian) {
            transforms = transforms.union(FieldSet::DERIVATIVES);
        }
        if choppiness == 0.0 {
            transforms = transforms.difference(FieldSet::SIDEWAYS);
        }
        let fields = if foam.is_some() { fields.with(Field::Foam) } else { fields };
        Self { fields, transforms, foam }
    }
}

impl Plan {
    /// Number of two-dimensional transforms.
    pub fn transforms(&self) -> usize {
        self.cascades.iter().map(|cascade| cascade.transforms.len()).sum()
    }
}
