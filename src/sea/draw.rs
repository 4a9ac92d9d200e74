//! The random draw of a layout: one complex Gaussian per mode, kept through every change of the spectrum.

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::layout::Layout;
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
        let cascade = |patch: usize| {
            let half = layout.cascades[patch].half as i32;
            let row = |m: i32| {
                (-half..=half).map(move |n| {
                    let (re, im) = gaussian_pair(seed, patch as u32, n, m);
                    Complex64::new(re, im)
                })
            };
            (-half..=half).into_par_iter().flat_map_iter(row).collect()
        };
        Self { xi: (0..layout.cascades.len()).map(cascade).collect() }
    }
}
