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
    /// Velocity of the water particle along x, m/s: the rate of Dx.
    VelocityX,
    /// Velocity of the water particle upward, m/s.
    VelocityY,
    /// Velocity of the water particle along z, m/s.
    VelocityZ,
    /// Determinant of the horizontal mapping of this cascade alone; negative where it folds.
    Jacobian,
    /// Smaller eigenvalue of that mapping: how far it is squeezed across the crests; 0 and below where it folds.
    Eigenvalue,
    /// Slope along x of this cascade's displaced surface, as seen from the world, by the scene's way of normals.
    NormalX,
    /// The same along z.
    NormalZ,
    /// Foam of this cascade, 0 to 1.
    Foam,
}

impl Field {
    /// Every field, in order.
    pub const ALL: [Self; 16] = [
        Self::Height,
        Self::Dx,
        Self::Dz,
        Self::SlopeX,
        Self::SlopeZ,
        Self::Dxx,
        Self::Dzz,
        Self::Dxz,
        Self::VelocityX,
        Self::VelocityY,
        Self::VelocityZ,
        Self::Jacobian,
        Self::Eigenvalue,
        Self::NormalX,
        Self::NormalZ,
        Self::Foam,
    ];

    /// Those that come out of a transform, in order.
    pub const SPECTRAL: [Self; 11] = *Self::ALL.first_chunk().expect("they stand first");

    /// Name in exports and metrics.
    pub fn name(self) -> &'static str {
        [
            "height",
            "dx",
            "dz",
            "slope_x",
            "slope_z",
            "dxx",
            "dzz",
            "dxz",
            "velocity_x",
            "velocity_y",
            "velocity_z",
            "jacobian",
            "eigenvalue",
            "normal_x",
            "normal_z",
            "foam",
        ][self as usize]
    }
}

/// A set of fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FieldSet(u16);

impl FieldSet {
    /// No field.
    pub const NONE: Self = Self(0);
    /// Those that come out of a transform.
    pub const SPECTRAL: Self = Self::of(&Field::SPECTRAL);
    /// Derivatives of the horizontal displacement.
    pub const DERIVATIVES: Self = Self::of(&[Field::Dxx, Field::Dzz, Field::Dxz]);
    /// Velocity of the water.
    pub const VELOCITY: Self = Self::of(&[Field::VelocityX, Field::VelocityY, Field::VelocityZ]);
    /// Everything that choppiness makes.
    pub const SIDEWAYS: Self =
        Self::DERIVATIVES.union(Self::of(&[Field::Dx, Field::Dz, Field::VelocityX, Field::VelocityZ]));

    /// The set of these fields.
    pub const fn of(fields: &[Field]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < fields.len() {
            bits |= 1 << fields[i] as u8;
            i += 1;
        }
        Self(bits)
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
    pub const fn union(self, other: Self) -> Self {
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
