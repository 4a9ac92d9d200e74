//! What kernels are told, word by word as their shaders declare it, and the numbers that both sides name.

/// A number of 32 bits in a uniform.
pub trait Word {
    /// Its bits.
    fn word(self) -> u32;
}

impl Word for u32 {
    fn word(self) -> u32 {
        self
    }
}

impl Word for f32 {
    fn word(self) -> u32 {
        self.to_bits()
    }
}

/// Declares a struct of words. `FIELDS` are its members in order, as a shader must declare them.
macro_rules! uniform {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default)]
        pub struct $name { $(pub $field: $kind),* }

        impl $name {
            pub const FIELDS: &'static [&'static str] = &[$(stringify!($field)),*];

            pub fn words(self) -> [u32; Self::FIELDS.len()] {
                [$(self.$field.word()),*]
            }
        }
    };
}

uniform! {
    /// The first pass of a bundle.
    Columns {
        turn: u32, half: u32, table_half: u32, blocks: u32,
        slot0: u32, kind0: u32, rate0: u32,
        slot1: u32, kind1: u32, rate1: u32,
        slot2: u32, kind2: u32, rate2: u32,
        dk: f32, scale0: f32, scale1: f32, scale2: f32,
    }
}

uniform! {
    /// The second pass of a bundle.
    Rows {
        frame: u32, half: u32, blocks: u32, made: u32, write: u32, normals: u32,
        unscale_a: f32, unscale_b: f32, unscale_single: f32,
    }
}

uniform! {
    /// Normals by differences.
    Differences { frame: u32, n: u32, middle: f32, side: f32 }
}

uniform! {
    /// A step of foam.
    Foam {
        frame: u32, samples: u32, restart: u32, advance: u32, breaks: u32,
        threshold: f32, decay: f32, growth: f32, steepness: f32, flush: f32,
    }
}

uniform! {
    /// One plane to counts.
    Quantise {
        plane: u32, n: u32, stride: u32, words: u32, found: u32, inverse_step: f32, share: f32, none: u32,
    }
}

/// Every struct that both sides declare: its name and members.
pub const SHARED: [(&str, &[&str]); 6] = [
    ("Columns", Columns::FIELDS),
    ("Rows", Rows::FIELDS),
    ("Differences", Differences::FIELDS),
    ("Foam", Foam::FIELDS),
    ("Quantise", Quantise::FIELDS),
    // As `EvolveTable::words` gives it.
    ("Mode", &["p", "q", "r", "t", "cycles", "offset", "omega", "chop"]),
];

/// Declares numbers that shaders declare, too, under the same names.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident = $value:literal;)*) => {
        $($(#[$doc])* pub const $name: u32 = $value;)*

        /// Every number that both sides name.
        pub const NUMBERS: &[(&str, u32)] = &[$((stringify!($name), $name)),*];
    };
}

numbers! {
    /// Words before the first plane of a buffer.
    HEADER = 64;
    /// Bits of what rows write: both planes of a packing, the single field, and what is assembled.
    WRITE_A = 1;
    WRITE_B = 4;
    WRITE_SINGLE = 16;
    WRITE_JACOBIAN = 32;
    WRITE_EIGENVALUE = 64;
    WRITE_NORMALS = 128;
    /// Kinds of packing.
    HEIGHT = 0;
    SIDEWAYS = 1;
    SLOPES = 2;
    STRETCH = 3;
    SHEAR = 4;
    /// Bits of what is found about counts: some were clamped, some were no numbers, all were made.
    WIDE = 1;
    ODD = 2;
    DONE = 4;
}
