//! The random draw of a layout: one complex number per mode, kept through every change of the spectrum.

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use super::layout::{Cascade, Layout};
use super::noise::{gaussian_pair, log_normal_pair};
use crate::scene::{Amplitudes, Distribution};

/// xi of every mode, per cascade, in the order of an [`super::EnergyTable`]'s rows.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Of mean square 2; real and imaginary part standard normal unless amplitudes are log-normal.
    pub xi: Vec<Vec<Complex64>>,
}

impl Draw {
    /// The draw of a seed.
    pub fn new(seed: u64, amplitudes: Amplitudes, layout: &Layout) -> Self {
        let cascade = |cascade: &Cascade| {
            let (half, patch) = (cascade.half as i32, u32::from(cascade.index));
            let row = |m: i32| {
                (-half..=half).map(move |n| {
                    let (re, im) = match amplitudes.distribution {
                        Distribution::Gaussian => gaussian_pair(seed, patch, n, m),
                        Distribution::LogNormal => log_normal_pair(amplitudes.sigma, seed, patch, n, m),
                    };
                    Complex64::new(re, im)
                })
            };
            (-half..=half).into_par_iter().flat_map_iter(row).collect()
        };
        Self { xi: layout.cascades.iter().map(cascade).collect() }
    }
}
