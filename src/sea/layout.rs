//! How a scene's waves are shared out to periodic patches: every wavenumber to exactly one cascade, in energy.

use std::f64::consts::PI;

use super::spectrum::Spectrum;
use crate::scene::{CascadeRequest, Patch, Scene, SeaState, WindSea};

/// The largest patch holds this many of the longest peak wavelengths: one random sea at 3 has an Hs 10 to 21 % off.
const PEAKS_PER_PATCH: f64 = 16.0;
/// Largest ratio of neighbouring patches: each begins where it still has a ring of six modes.
const MAX_RATIO: f64 = 7.0;
/// Share of the energy that may lie in waves too short for an automatic layout, in any sea state that it serves.
const UNRESOLVED: f64 = 0.004;
/// That share makes a layout no finer than this, metres; only a wish for finer waves does.
const FINEST_M: f64 = 0.05;
/// Winds below this, m/s, raise nothing that an automatic layout must hold: Hs of 2 mm.
const LEAST_WIND: f64 = 0.3;
/// Most levels of detail, and samples a side of the coarsest.
const MAX_LEVELS: u8 = 8;
const SMALLEST_LEVEL: usize = 8;
/// Neighbouring bands overlap from this share of the edge up to the edge, and add to one in energy all the way.
const OVERLAP: f64 = 0.9;

/// One periodic patch and its band of wavenumbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    /// Its number in units, frames and the random draw. Layouts that follow each other have different ones.
    pub index: u8,
    /// Side of the square patch, metres.
    pub patch_m: f64,
    /// Samples a side.
    pub n: usize,
    /// Where the band has risen to full energy, rad/m; 0 for the first cascade.
    pub from_k: f64,
    /// Where the band has fallen to nothing, rad/m.
    pub to_k: f64,
    /// Modes are (n, m) with |n|, |m| <= `half`; all others are zero.
    pub half: usize,
    /// The band falls softly, because another cascade takes over.
    soft_end: bool,
}

impl Cascade {
    /// Spacing of wavenumbers, rad/m.
    pub fn dk(&self) -> f64 {
        2.0 * PI / self.patch_m
    }

    /// Cells of an energy table.
    pub fn cells(&self) -> usize {
        (2 * self.half + 1) * (2 * self.half + 1)
    }

    /// Wave vectors (kx, kz), rad/m, of the cells of an energy table: rows of m = -half..=half, each of n.
    pub fn wave_vectors(&self) -> impl Iterator<Item = (f64, f64)> {
        let (half, dk) = (self.half as i32, self.dk());
        (-half..=half).flat_map(move |m| (-half..=half).map(move |n| (f64::from(n) * dk, f64::from(m) * dk)))
    }

    /// Share of the energy at wavenumber `k` that is this cascade's.
    pub fn weight(&self, k: f64) -> f64 {
        let rise = if self.from_k == 0.0 { 1.0 } else { overlap(k / self.from_k) };
        let fall = match self.soft_end {
            true => 1.0 - overlap(k / self.to_k),
            false => f64::from(u8::from(k <= self.to_k)),
        };
        rise * fall
    }

    /// Levels of detail that it can be made at: halvings of its grid, down to 8 samples a side.
    pub fn levels(&self) -> u8 {
        (1..MAX_LEVELS).take_while(|level| self.n >> level >= SMALLEST_LEVEL).count() as u8 + 1
    }

    /// Samples a side of a level, and the highest mode that it holds: the spectrum is cut where the grid ends, so that
    /// nothing folds back.
    pub fn level(&self, level: u8) -> (usize, usize) {
        let n = self.n >> level;
        (n, self.half.min((n / 2).saturating_sub(1)))
    }

    /// Longest wavelength that it holds, metres.
    pub fn longest_m(&self) -> f64 {
        if self.from_k == 0.0 { self.patch_m } else { (2.0 * PI / (OVERLAP * self.from_k)).min(self.patch_m) }
    }

    /// Shortest wavelength that it holds, metres.
    pub fn shortest_m(&self) -> f64 {
        2.0 * PI / self.to_k
    }
}

/// Smooth step in the logarithm of `x` from [`OVERLAP`] to 1.
fn overlap(x: f64) -> f64 {
    // Most waves lie outside: no logarithm for those.
    if x >= 1.0 {
        return 1.0;
    }
    if x <= OVERLAP {
        return 0.0;
    }
    let t = 1.0 - libm::log(x) / libm::log(OVERLAP);
    t * t * (3.0 - 2.0 * t)
}

/// The cascades of a scene, longest first; fixed until a change of layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Counts the changes of layout before it.
    pub generation: u32,
    /// Longest first.
    pub cascades: Vec<Cascade>,
}

impl Layout {
    /// The layout a scene asks for. An automatic one serves the whole declared wind range, so that no change of
    /// wind changes it.
    pub fn of(scene: &Scene) -> Self {
        Self::of_generation(scene, 0)
    }

    /// The same, after so many changes of layout.
    pub fn of_generation(scene: &Scene, generation: u32) -> Self {
        let (patches, band_limit) = match &scene.cascades {
            CascadeRequest::Chosen { patches, band_limit } => (patches.clone(), *band_limit),
            CascadeRequest::Automatic { n, band_limit, finest_wavelength_m } => {
                (automatic(scene, *n, *band_limit, *finest_wavelength_m), *band_limit)
            }
        };
        let mut cascades: Vec<Cascade> = Vec::with_capacity(patches.len());
        for (i, patch) in patches.iter().enumerate() {
            let to_k = band_end(patch, band_limit);
            let half = ((to_k * patch.length_m / (2.0 * PI) + 0.5).floor() as usize).min(patch.n / 2 - 1);
            let from_k = cascades.last().map_or(0.0, |before: &Cascade| before.to_k);
            let soft_end = i + 1 < patches.len();
            let index = Self::first_number(generation) + i as u8;
            cascades.push(Cascade { index, patch_m: patch.length_m, n: patch.n, from_k, to_k, half, soft_end });
        }
        Self { generation, cascades }
    }

    /// The number of the first cascade of a generation: even ones have 0 to 7, odd ones 8 to 15, so that neighbours
    /// have no number, and no random draw, in common.
    fn first_number(generation: u32) -> u8 {
        (generation % 2) as u8 * CascadeRequest::MAX_PATCHES as u8
    }

    /// Whether cascades of a generation may have a number.
    pub fn numbers(generation: u32, number: u8) -> bool {
        (0..CascadeRequest::MAX_PATCHES as u8).contains(&number.wrapping_sub(Self::first_number(generation)))
    }
}

/// End of a patch's band, rad/m; never into the cells of the empty Nyquist row.
fn band_end(patch: &Patch, band_limit: f64) -> f64 {
    let nyquist = PI * patch.n as f64 / patch.length_m;
    (band_limit * nyquist).min(nyquist - PI / patch.length_m)
}

/// Patches of an automatic layout: one after the other from 16 of the longest peaks down to the finest waves wanted.
fn automatic(scene: &Scene, n: Option<usize>, band_limit: f64, wanted_m: f64) -> Vec<Patch> {
    let (mut longest, mut wanted_end) = (0.0_f64, 2.0 * PI / wanted_m);
    let mut ends: Option<f64> = Some(0.0);
    for state in extremes(scene) {
        let spectrum = Spectrum::new(&state);
        longest = longest.max(spectrum.longest_peak_m().unwrap_or(0.0));
        let share = spectrum.wavenumber_below_share(UNRESOLVED).unwrap_or(0.0);
        wanted_end = wanted_end.max(share.min(2.0 * PI / FINEST_M));
        ends = ends.zip(spectrum.highest_wavenumber()).map(|(a, b)| a.max(b));
    }
    let longest = if longest > 0.0 { longest } else { 10.0 };
    let wanted_end = ends.filter(|end| *end > 0.0).map_or(wanted_end, |end| end.min(wanted_end));
    let first_m = (PEAKS_PER_PATCH * longest).clamp(0.1, 1e5);

    let n = n.unwrap_or_else(|| serving_n(first_m, band_limit, wanted_end));
    let first = Patch { length_m: first_m, n };
    let span = wanted_end / band_end(&first, band_limit);
    let max_ratio = max_ratio(&first, band_limit);
    let more = more_patches(span, max_ratio).min(CascadeRequest::MAX_PATCHES - 1);
    let ratio = libm::pow(span, 1.0 / more.max(1) as f64).min(max_ratio);
    let length = |i: usize| first.length_m / libm::pow(ratio, i as f64);
    // Millimetres, so that a layout is written down exactly; the ratios stay far from simple fractions.
    let rounded = |metres: f64| if metres > 1.0 { (metres * 1e3).round() / 1e3 } else { metres };
    (0..=more).map(|i| Patch { length_m: rounded(length(i)).max(0.1), n }).collect()
}

/// The sea states that a layout must hold: the ends of the wind's range, with each of the measured records.
fn extremes(scene: &Scene) -> Vec<SeaState> {
    let records = scene.replay.iter().flat_map(|replay| replay.records.iter().cloned().map(Some));
    let records: Vec<_> = std::iter::once(scene.sea.measured.clone()).chain(records).collect();
    let winds: Vec<_> = match (scene.sea.wind, scene.wind_range_mps) {
        (Some(wind), Some([low, high])) => {
            let blown = |speed: f64| Some(WindSea { speed_mps: speed.max(LEAST_WIND), ..wind });
            vec![blown(low), blown(high)]
        }
        (wind, _) => vec![wind],
    };
    let state = |wind: Option<WindSea>| {
        let sea = &scene.sea;
        records.iter().map(move |record| SeaState {
            wind,
            measured: record.clone(),
            water: sea.water,
            swells: sea.swells.clone(),
        })
    };
    winds.into_iter().flat_map(state).collect()
}

/// The usual grid; a smaller one where it holds every wave in one patch, a larger one where the usual takes too many.
fn serving_n(first_m: f64, band_limit: f64, wanted_end: f64) -> usize {
    let patches = |n: usize| {
        let first = Patch { length_m: first_m, n };
        1 + more_patches(wanted_end / band_end(&first, band_limit), max_ratio(&first, band_limit))
    };
    let usual = CascadeRequest::USUAL_N;
    if let Some(small) = [64, 128].into_iter().find(|n| patches(*n) == 1) {
        return small;
    }
    let fits = |n: &usize| {
        CascadeRequest::MAX_PATCHES as f64 * CascadeRequest::modes(*n, band_limit) <= CascadeRequest::MAX_MODES
            && CascadeRequest::MAX_PATCHES * n * n <= CascadeRequest::MAX_SAMPLES
    };
    let served = |n: &usize| patches(*n) <= CascadeRequest::MAX_PATCHES;
    let sizes = [usual, 2 * usual, 4 * usual, 8 * usual];
    sizes.into_iter().find(|n| fits(n) && served(n)).or(sizes.into_iter().rev().find(fits)).unwrap_or(usual)
}

/// Largest ratio of neighbouring patches; a small grid must not start its band below two modes.
fn max_ratio(first: &Patch, band_limit: f64) -> f64 {
    (band_end(first, band_limit) * first.length_m / (4.0 * PI)).clamp(1.3, MAX_RATIO)
}

/// Patches needed beside the first to reach waves `span` times shorter than it holds.
fn more_patches(span: f64, max_ratio: f64) -> usize {
    if span > 1.0 { (libm::log(span) / libm::log(max_ratio)).ceil() as usize } else { 0 }
}
