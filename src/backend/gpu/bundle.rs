//! Fields that are made together: up to two packings and a single field, whose rows one kernel makes and assembles.
//!
//! Invariant: a field is always made by the same bundle and the same kernel, so that its bits depend on no other demand.

use super::uniforms::{
    HEIGHT, SHEAR, SIDEWAYS, SLOPES, STRETCH, WRITE_A, WRITE_B, WRITE_EIGENVALUE, WRITE_JACOBIAN, WRITE_NORMALS,
    WRITE_SINGLE,
};
use crate::plan::{Field, FieldSet, LevelPlan, Packing};
use crate::scene::Normals;

/// Up to three transforms, each with its slot between the passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bundle {
    pub slots: [Option<Packing>; 3],
    /// Fields assembled on the spot.
    assembled: &'static [Field],
}

/// Every bundle: motion, gradient, velocity.
pub const BUNDLES: [Bundle; 3] = [
    Bundle {
        slots: [Some(Packing::Packed(Field::Dx, Field::Dz)), None, Some(Packing::HalfComplex(Field::Height))],
        assembled: &[],
    },
    Bundle {
        slots: [
            Some(Packing::Packed(Field::SlopeX, Field::SlopeZ)),
            Some(Packing::Packed(Field::Dxx, Field::Dzz)),
            Some(Packing::HalfComplex(Field::Dxz)),
        ],
        assembled: &[Field::Jacobian, Field::Eigenvalue, Field::NormalX, Field::NormalZ],
    },
    Bundle {
        slots: [
            Some(Packing::Packed(Field::VelocityX, Field::VelocityZ)),
            None,
            Some(Packing::HalfComplex(Field::VelocityY)),
        ],
        assembled: &[],
    },
];

/// Places in [`BUNDLES`].
pub const MOTION: usize = 0;
pub const GRADIENT: usize = 1;

/// Which buffer of a level a field stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// Planes of a bundle.
    Planes(usize),
    /// What the gradient bundle assembles.
    Assembled,
    /// Foam shown.
    Foam,
}

/// The buffer of a field, and its plane there.
pub fn place(field: Field) -> (Source, usize) {
    if field == Field::Foam {
        return (Source::Foam, 0);
    }
    for (index, bundle) in BUNDLES.iter().enumerate() {
        if let Some(plane) = bundle.planes().position(|held| held == Some(field)) {
            return (Source::Planes(index), plane);
        }
    }
    let plane = BUNDLES[GRADIENT].assembled.iter().position(|held| *held == field);
    (Source::Assembled, plane.expect("every field has a place"))
}

/// What a bundle does at one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// Slots that are transformed.
    pub made: [bool; 3],
    /// Bits of what is written, as the shader has them.
    pub write: u32,
}

impl Work {
    /// Planes that are written.
    pub fn planes(self) -> u64 {
        // Packings and normals are two.
        [(WRITE_A, 2), (WRITE_B, 2), (WRITE_SINGLE, 1), (WRITE_JACOBIAN, 1), (WRITE_EIGENVALUE, 1), (WRITE_NORMALS, 2)]
            .iter()
            .filter(|(bit, _)| self.write & bit != 0)
            .map(|(_, planes)| planes)
            .sum()
    }
}

impl Bundle {
    /// Two planes for each packing, one for the single field.
    fn planes(&self) -> impl Iterator<Item = Option<Field>> + '_ {
        self.slots.iter().enumerate().flat_map(|(slot, packing)| match packing {
            Some(Packing::Packed(a, b)) => vec![Some(*a), Some(*b)],
            Some(Packing::HalfComplex(field)) => vec![Some(*field)],
            None => vec![None; if slot < 2 { 2 } else { 1 }],
        })
    }

    /// What it does under a plan; nothing when no field of it is wanted.
    pub fn work(&self, plan: &LevelPlan) -> Option<Work> {
        let by_points = matches!(plan.normals, Normals::CentralDifference | Normals::Sobel);
        let normals = FieldSet::of(&[Field::NormalX, Field::NormalZ]);
        let points = FieldSet::of(&[Field::Dx, Field::Height, Field::Dz]);
        let mut here = plan.fields;
        if by_points && !plan.fields.intersection(normals).is_empty() {
            here = here.union(points);
        }
        let mut write = 0;
        for (slot, packing) in self.slots.iter().enumerate() {
            let wanted = packing.is_some_and(|packing| !packing.fields().intersection(here).is_empty());
            write |= if wanted { [WRITE_A, WRITE_B, WRITE_SINGLE][slot] } else { 0 };
        }
        for field in self.assembled.iter().filter(|field| plan.fields.contains(**field)) {
            write |= match field {
                Field::Jacobian => WRITE_JACOBIAN,
                Field::Eigenvalue => WRITE_EIGENVALUE,
                _ if by_points => 0,
                _ => WRITE_NORMALS,
            };
        }
        let made = self.slots.map(|slot| slot.is_some_and(|packing| plan.transforms.contains(&packing)));
        (write != 0).then_some(Work { made, write })
    }
}

/// What the shaders call a packing, and whether it is of the rate of the height.
pub fn kind(packing: Packing) -> (u32, bool) {
    match packing {
        Packing::HalfComplex(Field::Dxz) => (SHEAR, false),
        Packing::HalfComplex(field) => (HEIGHT, field == Field::VelocityY),
        Packing::Packed(Field::SlopeX, _) => (SLOPES, false),
        Packing::Packed(Field::Dxx, _) => (STRETCH, false),
        Packing::Packed(field, _) => (SIDEWAYS, field == Field::VelocityX),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_field_has_a_place_of_its_own() {
        let places: BTreeSet<_> = Field::ALL.into_iter().map(place).collect();
        assert_eq!(places.len(), Field::ALL.len());
    }

    #[test]
    fn every_transform_stands_in_one_bundle() {
        let all: Vec<Packing> = BUNDLES.iter().flat_map(|bundle| bundle.slots.into_iter().flatten()).collect();
        assert_eq!(all.len(), Packing::ALL.len());
        assert!(Packing::ALL.iter().all(|packing| all.contains(packing)));
    }
}
