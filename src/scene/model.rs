//! The two ways to make a sea out of its spectrum: the sum of all modes, or of the strongest trochoids.

use super::bound::SceneError;

/// What the modes of a sea are summed by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// All modes, by inverse Fourier transforms.
    #[default]
    Fft,
    /// The strongest modes as trochoids, and noise in place of the rest (Thon, Dischler & Ghazanfarpour 2000).
    Trochoid(Trochoid),
}

/// `[trochoid]`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trochoid {
    /// They are chosen out of so many modes a side, the longest of each cascade.
    pub grid: usize,
    /// How many of them are kept, the strongest.
    pub components: usize,
    /// Gradient noise in place of the waves that were not kept.
    pub turbulence: bool,
}

impl Default for Trochoid {
    fn default() -> Self {
        Self { grid: 64, components: 64, turbulence: true }
    }
}

impl Trochoid {
    /// # Errors
    /// [`SceneError::Bound`] for the first number out of bounds.
    pub(super) fn check(self) -> Result<Self, SceneError> {
        if !(16..=512).contains(&self.grid) || !self.grid.is_power_of_two() {
            return Err(SceneError::bound("trochoid.grid", self.grid, "a power of two from 16 to 512"));
        }
        if !(1..=4096).contains(&self.components) {
            return Err(SceneError::bound("trochoid.components", self.components, "1 to 4096"));
        }
        Ok(self)
    }
}
