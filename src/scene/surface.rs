//! How the sea is cut into cascades, and when it repeats.

/// Side and grid of one periodic patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Side in metres.
    pub length_m: f64,
    /// Samples a side, a power of two.
    pub n: usize,
}

/// What the scene says about its cascades.
#[derive(Clone, Debug, PartialEq)]
pub enum CascadeRequest {
    /// Count and lengths follow from the scene's longest and shortest waves.
    Automatic {
        /// Samples a side of every cascade; `None`: as the waves need it.
        n: Option<usize>,
        /// Where a cascade's band ends, as a share of its Nyquist wavenumber.
        band_limit: f64,
        /// The shortest wave wanted, metres.
        finest_wavelength_m: f64,
    },
    /// Patches chosen by hand, longest first.
    Chosen {
        /// The patches.
        patches: Vec<Patch>,
        /// Where a cascade's band ends, as a share of its Nyquist wavenumber.
        band_limit: f64,
    },
}

impl CascadeRequest {
    /// Samples a side where nothing else is said or needed.
    pub const USUAL_N: usize = 256;
    /// Most patches of a layout.
    pub const MAX_PATCHES: usize = 8;
    /// Most modes of a layout: about half a gigabyte of tables.
    pub const MAX_MODES: f64 = 5e6;
    /// Most samples of all cascades of a layout, about a gigabyte of fields, a third more with all levels: 16 patches of 1024 x 1024, 4 of 2048 x 2048.
    pub const MAX_SAMPLES: usize = 1 << 24;

    /// Modes of one patch, about.
    pub fn modes(n: usize, band_limit: f64) -> f64 {
        let side = band_limit * n as f64 + 1.0;
        side * side
    }
}

/// The period after which the sea is exactly the same again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repeat {
    /// Length in ticks, 7200 (one second) to 2^32 (6.9 days).
    pub ticks: u64,
}

impl Default for Repeat {
    fn default() -> Self {
        Self { ticks: 1 << 32 }
    }
}
