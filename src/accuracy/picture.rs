//! The same water at four settings, seen from straight above, each beside how far its heights are off.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::errors::{Particle, rms};
use super::image::{FINER, Image};
use crate::backend::{Backend, BackendError, CascadeSurface, Cpu, Surface};
use crate::engine::Sampler;
use crate::pass::quantise::quantiser_step;
use crate::plan::{CascadePlan, Field, FieldSet, Plan, fields_of};
use crate::scene::Scene;
use crate::sea::{CascadeModes, Dispersion, Timeline, rest_position_within};
use crate::wire::{ErrorClass, Group};

/// Halvings of every grid in the coarse picture.
const COARSE: u8 = 2;
/// The class of the picture of counts.
const CLASS: ErrorClass = ErrorClass::TwentyMillimetres;
/// Groups that a picture is made of.
const GROUPS: [Group; 3] = [Group::Displacement, Group::Slopes, Group::Derivatives];
/// Peak wavelengths that are seen.
const PEAKS: f64 = 2.0;
/// Share of the significant wave height that has the full colour of a difference, nearly.
const SCALE: f64 = 0.25;
/// Steps of the search for the particle that is seen at a point; it takes more only in a fold.
const SEARCH: u32 = 12;
/// Pixels of a still, and between its pictures.
const STILL: [usize; 2] = [1200, 500];
const GAP: usize = 8;

/// One setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The setting.
    pub setting: String,
    /// The water, sunlit.
    pub water: Image,
    /// How far its heights are above (red) or below (blue) those of the best.
    pub difference: Image,
    /// The same, rms and most, millimetres.
    pub off_mm: [f64; 2],
}

/// The same water at several settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictures {
    /// Side of the square that is seen, metres.
    pub side_m: f64,
    /// Difference of height that has the full colour, millimetres; in all pictures the same.
    pub scale_mm: f64,
    /// The best first.
    pub pictures: Vec<Picture>,
}

/// Pictures of a scene's sea at a tick, `side` pixels a side, by the CPU.
///
/// # Errors
/// [`BackendError`] of the CPU.
pub fn pictures(scene: &Scene, tick: i64, side: usize) -> Result<Pictures, BackendError> {
    let timeline = Timeline::new(scene);
    let (sea, statistics) = (timeline.at(tick), timeline.statistics_at(tick));
    let level = |modes: &CascadeModes| COARSE.min(modes.cascade.levels() - 1);
    let fields = FieldSet::of(&GROUPS.map(fields_of).concat());
    let cascade = |modes: &CascadeModes| {
        CascadePlan::new([(0, fields), (level(modes), fields)], None, &scene.effects).by(scene.model)
    };
    let plan = Plan { cascades: sea.cascades.iter().map(cascade).collect() };
    let mut cpu = Cpu::new(None);
    cpu.load(&sea)?;
    let surface = cpu.step(tick, &plan)?;

    let coarse = sea.cascades.iter().zip(&surface.cascades).map(|(modes, made)| read(made, level(modes), |_, v| v));
    let counted = surface.cascades.iter().map(|made| read(made, 0, |group, value| rounded(value, group)));
    let [coarse, counted] = [coarse.collect(), counted.collect()].map(|cascades| Surface { tick, cascades });
    let longest = Surface { tick, cascades: surface.cascades.iter().take(1).cloned().collect() };
    let settings = [
        ("as it is, full grids".to_owned(), surface),
        (format!("level {COARSE}, a quarter of the samples a side"), &coarse),
        ("the longest cascade alone".to_owned(), &longest),
        (format!("counts of the class {}", CLASS.name()), &counted),
    ];

    let patches_m: Vec<f64> = sea.cascades.iter().map(|modes| modes.cascade.patch_m).collect();
    let dispersion = Dispersion::new(timeline.state_at(tick).water);
    let peak_m = statistics.tp_s.map(|tp_s| 2.0 * PI / dispersion.wavenumber(2.0 * PI / tp_s));
    // Where there are no waves, any square will do.
    let side_m = PEAKS * peak_m.unwrap_or(10.0);
    let scale_mm = round_below(SCALE * statistics.hs_m * 1e3);
    let seen = settings.map(|(setting, surface)| {
        (setting, seen_from_above(&Sampler::new(surface, patches_m.iter().copied()), side_m, side * FINER))
    });
    let best: Vec<f64> = seen[0].1.iter().map(height_mm).collect();
    let picture = |(setting, particles): (String, Vec<Particle>)| {
        let off: Vec<f64> = particles.iter().zip(&best).map(|(particle, best)| height_mm(particle) - best).collect();
        let most = off.iter().fold(0.0, |most: f64, off| most.max(off.abs()));
        Picture {
            setting,
            water: Image::water(&particles, side, statistics.hs_m),
            difference: Image::difference(&off, side, scale_mm),
            off_mm: [rms(off.into_iter()), most],
        }
    };
    Ok(Pictures { side_m, scale_mm, pictures: seen.map(picture).into() })
}

impl Pictures {
    /// All of them as one picture of 1200 x 500 pixels: the middle of each, and below it that of its difference.
    pub fn still(&self) -> Image {
        let [width, height] = STILL;
        let columns = self.pictures.len().max(1);
        let tile = [(width + GAP) / columns - GAP, (height + GAP) / 2 - GAP];
        let mut still = Image::white(width, height);
        for (column, picture) in self.pictures.iter().enumerate() {
            let x = column * (tile[0] + GAP);
            still.put(&picture.water, [x, 0], tile);
            still.put(&picture.difference, [x, tile[1] + GAP], tile);
        }
        still
    }
}

/// A level of a cascade as a grid of its own, its samples changed by group.
fn read(made: &CascadeSurface, level: u8, change: impl Fn(Group, f32) -> f32) -> CascadeSurface {
    let mut planes = [const { Vec::new() }; Field::ALL.len()];
    for group in GROUPS {
        for field in fields_of(group) {
            let samples = made.plane_at(level, *field).unwrap_or_default();
            planes[*field as usize] = samples.iter().map(|sample| change(group, *sample)).collect();
        }
    }
    CascadeSurface::of(made.n >> level, planes)
}

/// What counts leave of a sample.
fn rounded(sample: f32, group: Group) -> f32 {
    let step = quantiser_step(CLASS, group);
    (sample / step).round_ties_even() * step
}

/// The particles that are seen at the points of a lattice over the square, rows from north to south.
fn seen_from_above(water: &Sampler, side_m: f64, side: usize) -> Vec<Particle> {
    let metre = |at: usize| ((at as f64 + 0.5) / side as f64 - 0.5) * side_m;
    let row = |z: usize| {
        let rest = |x: usize| rest_position_within(SEARCH, [metre(x), metre(z)], |at| water.displacement(at)).at;
        let at: Vec<[f64; 2]> = (0..side).map(rest).collect();
        let fields = water.fields(&at, FieldSet::SPECTRAL);
        let particle = |x: usize| Particle::of(&std::array::from_fn(|field| f64::from(fields[field][x])));
        (0..side).map(particle).collect::<Vec<_>>()
    };
    (0..side).into_par_iter().flat_map_iter(row).collect()
}

fn height_mm(particle: &Particle) -> f64 {
    particle.moved[1] * 1e3
}

/// The greatest of 1, 2, 5, 10 .. that is not above a number; at least 1.
fn round_below(value: f64) -> f64 {
    let power = 10_f64.powf(value.max(1.0).log10().floor());
    [5.0, 2.0].into_iter().find(|digit| digit * power <= value).unwrap_or(1.0) * power
}
