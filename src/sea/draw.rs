//! The random draw of a layout: one complex Gaussian per mode, kept through every change of the spectrum.

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::layout::{Cascade, Layout};
use super::noise::gaussian_pair;

/// xi of every mode, per cascade, in the order of an [`super::EnergyTable`]'s rows.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Real and imaginary part, each standard normal.
    pub xi: Vec<Vec<Complex64>>,
}

impl Draw {
    /// The draw of a seed.
    pub fn new(seed: u64, layout: &Layout) -> Self {
        let cascade = |cascade: &Cascade| {
            let (half, patch) = (cascade.half as i32, u32::from(cascade.index));
            let row = |m: i32| {
                (-half..=half).map(move |n| {
                    let (re, im) = gaussian_pair(seed, patch, n, m);
                    Complex64::new(re, im)
                })
            };
            (-half..=half).into_par_iter().flat_map_iter(row).collect()
        };
        Self { xi: layout.cascades.iter().map(cascade).collect() }
    }
}
