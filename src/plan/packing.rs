//! How real fields share transforms: two in the real and imaginary part of one complex transform, or one half-complex.
//!
//! Invariant: a field has the same partner always, or always none, so that its bits depend on no other demand.

use super::field::{Field, FieldSet};

/// One two-dimensional transform and the real fields that come out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// One field, from half of its Hermitian spectrum.
    HalfComplex(Field),
    /// Two fields a and b, as a + i b.
    Packed(Field, Field),
}

impl Packing {
    /// Every transform that there is. Height stands alone, since most of those who want little want it alone.
    pub const ALL: [Self; 7] = [
        Self::HalfComplex(Field::Height),
        Self::Packed(Field::Dx, Field::Dz),
        Self::Packed(Field::SlopeX, Field::SlopeZ),
        Self::Packed(Field::Dxx, Field::Dzz),
        Self::HalfComplex(Field::Dxz),
        Self::Packed(Field::VelocityX, Field::VelocityZ),
        Self::HalfComplex(Field::VelocityY),
    ];

    /// The fields that come out.
    pub fn fields(self) -> FieldSet {
        match self {
            Self::HalfComplex(field) => FieldSet::of(&[field]),
            Self::Packed(a, b) => FieldSet::of(&[a, b]),
        }
    }

    /// The transforms that give `fields`.
    pub fn of(fields: FieldSet) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |packing| !packing.fields().intersection(fields).is_empty())
    }
}
