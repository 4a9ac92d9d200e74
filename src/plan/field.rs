//! The fields of a surface, and sets of them.

/// A real field over the grid of one cascade.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Field {
    /// Height, metres.
    Height,
    /// Horizontal displacement along x, metres, choppiness included.
    Dx,
    /// Horizontal displacement along z, metres, choppiness included.
    Dz,
    /// Derivative of height along x.
    SlopeX,
    /// Derivative of height along z.
    SlopeZ,
    /// d Dx / dx.
    Dxx,
    /// d Dz / dz.
    Dzz,
    /// d Dx / dz, which equals d Dz / dx.
    Dxz,
    /// Determinant of the horizontal mapping of this cascade alone; negative where it folds.
    Jacobian,
    /// Foam of this cascade, 0 to 1.
    Foam,
}

impl Field {
    /// Every field, in order.
    pub const ALL: [Self; 10] = [
        Self::Height,
        Self::Dx,
        Self::Dz,
        Self::SlopeX,
        Self::SlopeZ,
        Self::Dxx,
        Self::Dzz,
        Self::Dxz,
        Self::Jacobian,
        Self::Foam,
    ];

    /// Those that come out of a transform, in order.
    pub const SPECTRAL: [Self; 8] =
        [Self::Height, Self::Dx, Self::Dz, Self::SlopeX, Self::SlopeZ, Self::Dxx, Self::Dzz, Self::Dxz];

    /// Name in exports and metrics.
    pub fn name(self) -> &'static str {
        ["height", "dx", "dz", "slope_x", "slope_z", "dxx", "dzz", "dxz", "jacobian", "foam"][self as usize]
    }
}

/// A set of fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FieldSet(u16);

impl FieldSet {
    /// No field.
    pub const NONE: Self = Self(0);
    /// The eight that come out of a transform.
    pub const SPECTRAL: Self = Self(0xff);
    /// Derivatives of the horizontal displacement.
    pub const DERIVATIVES: Self = Self(0b1110_0000);
    /// Everything that choppiness makes.
    pub const SIDEWAYS: Self = Self(0b1110_0110);

    /// The set of these fields.
    pub fn of(fields: &[Field]) -> Self {
        fields.iter().fold(Self::NONE, |set, field| set.with(*field))
    }

    /// This set and `field`.
    pub fn with(self, field: Field) -> Self {
        Self(self.0 | 1 << field as u8)
    }

    /// Whether `field` is in the set.
    pub fn contains(self, field: Field) -> bool {
        self.0 & (1 << field as u8) != 0
    }

    /// Fields of either.
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Fields of both.
    pub fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Fields of this set that are not in `other`.
    pub fn difference(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Number of fields.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The fields, in order.
    pub fn iter(self) -> impl Iterator<Item = Field> {
        Field::ALL.into_iter().filter(move |field| self.contains(*field))
    }
}
