//! The sea that everything is measured on: its modes, where it is looked at, what the reference says there, and what the
//! CPU makes of it.

use crate::backend::{Backend, Cpu, Surface};
use crate::engine::{Clock, Sampler};
use crate::pass::trochoid::Trochoids;
use crate::plan::{CascadePlan, Field, FieldSet, Plan};
use crate::reference;
use crate::scene::{CascadeRequest, Effects, Model, Patch, Scene};
use crate::sea::{CascadeModes, Sea, Timeline};
use crate::wire::TICKS_PER_SECOND;

use super::errors::{Errors, Particle};

/// When the sea is looked at: ten minutes after its beginning, off the grids of frames and foam.
const TICK: i64 = 600 * TICKS_PER_SECOND + 77;
/// Fields that displacement and exact normals are made of.
pub const LOOKED_AT: FieldSet = FieldSet::of(&[
    Field::Height,
    Field::Dx,
    Field::Dz,
    Field::SlopeX,
    Field::SlopeZ,
    Field::Dxx,
    Field::Dzz,
    Field::Dxz,
]);

/// Spectral fields of a particle, in the order of [`Field`], summed over all cascades.
pub type Fields = [f64; 11];

/// What all axes share.
pub struct Ground<'a> {
    /// For times.
    pub clock: &'a Clock,
    /// The scene, made of all its modes.
    pub scene: Scene,
    /// Its sea.
    pub sea: Sea,
    /// The tick at which it is looked at.
    pub tick: i64,
    /// Its significant wave height, metres.
    pub hs_m: f64,
    /// Where it is looked at: rest positions x and z, metres, every pair of them.
    pub spots: [Vec<f64>; 2],
    /// What the reference says there.
    pub truth: Vec<Particle>,
    /// Rounds of a time.
    pub rounds: usize,
    /// Fewer settings.
    pub quick: bool,
}

impl<'a> Ground<'a> {
    /// Of a scene; one of trochoids is taken as the sum of all its modes.
    pub fn new(scene: &Scene, quick: bool, clock: &'a Clock) -> Self {
        let scene = Scene { model: Model::Fft, ..scene.clone() };
        let timeline = Timeline::new(&scene);
        let (sea, hs_m) = (timeline.at(TICK), timeline.hs_at(TICK));
        let spots = spots(sea.cascades[0].cascade.patch_m, if quick { 24 } else { 64 });
        let truth = particles(&fields(&sea, TICK, &spots));
        let rounds = if quick { 5 } else { 25 };
        Self { clock, hs_m, scene, sea, tick: TICK, spots, truth, rounds, quick }
    }

    /// The sea of the same scene with patches chosen by hand.
    pub fn with_patches(&self, patches: Vec<Patch>, band_limit: f64) -> Sea {
        let scene = Scene { cascades: CascadeRequest::Chosen { patches, band_limit }, ..self.scene.clone() };
        Timeline::new(&scene).at(self.tick)
    }

    /// What the reference says of a sea at the spots.
    pub fn particles(&self, sea: &Sea, tick: i64) -> Vec<Particle> {
        particles(&fields(sea, tick, &self.spots))
    }

    /// Errors of what was made at the spots.
    pub fn errors(&self, made: &[Particle]) -> Errors {
        Errors::of(made, &self.truth, self.hs_m)
    }
}

/// Significant wave height of these modes as they were drawn, metres: on the mean over all times, not over all draws.
pub fn hs_m(sea: &Sea) -> f64 {
    let energy = |modes: &CascadeModes| {
        let rows = modes.rows();
        let each = modes.modes.iter().enumerate().map(move |(i, mode)| {
            let twice = if i < rows { 1.0 } else { 2.0 };
            twice * (mode.forward.norm_sqr() + mode.backward.norm_sqr())
        });
        each.sum::<f64>()
    };
    4.0 * sea.cascades.iter().map(energy).sum::<f64>().sqrt()
}

/// So many positions a side, spread evenly over a patch and along no grid: multiples of two irrational shares of it.
pub fn spots(patch_m: f64, side: usize) -> [Vec<f64>; 2] {
    let along = |share: f64| (0..side).map(|i| ((i as f64 + 0.5) * share).fract() * patch_m).collect();
    [along(0.618_033_988_749_894_9), along(0.754_877_666_246_692_7)]
}

/// What the reference says of a sea at every pair of positions, all cascades summed; trochoids, which are evaluated where
/// they are asked for, say it themselves.
pub fn fields(sea: &Sea, tick: i64, [xs, zs]: &[Vec<f64>; 2]) -> Vec<Fields> {
    let places: Vec<(f64, f64)> = zs.iter().flat_map(|z| xs.iter().map(|x| (*x, *z))).collect();
    let each = sea.cascades.iter().enumerate().map(|(cascade, modes)| match sea.model {
        Model::Fft => reference::lattice(sea, cascade, tick, xs, zs),
        Model::Trochoid(_) => {
            let at = |fields: [f32; 16]| std::array::from_fn(|field| f64::from(fields[field]));
            Trochoids::new(modes, sea).points(tick, &places, 0.0).into_iter().map(at).collect()
        }
    });
    summed(each, places.len())
}

/// Particles of these fields.
pub fn particles(fields: &[Fields]) -> Vec<Particle> {
    fields.iter().map(Particle::of).collect()
}

/// The same at the samples of each cascade's grid that lie next before the positions: patches have no common measure, so
/// that somewhere in the world any sample of one lies over any of the others.
pub fn fields_on_grid(sea: &Sea, tick: i64, spots: &[Vec<f64>; 2]) -> Vec<Fields> {
    let each = sea.cascades.iter().enumerate().map(|(cascade, modes)| {
        let spacing = modes.cascade.patch_m / modes.cascade.n as f64;
        let [xs, zs] = on_grid(modes, spots).map(|samples| samples.iter().map(|i| *i as f64 * spacing).collect());
        let (xs, zs): (Vec<f64>, Vec<f64>) = (xs, zs);
        reference::lattice(sea, cascade, tick, &xs, &zs)
    });
    summed(each, spots[0].len() * spots[1].len())
}

/// What planes hold at those samples; a field that is not there counts as nothing.
pub fn sampled_on_grid<'p>(
    plane: impl Fn(usize, Field) -> Option<&'p [f32]>,
    sea: &Sea,
    spots: &[Vec<f64>; 2],
) -> Vec<Fields> {
    let each = sea.cascades.iter().enumerate().map(|(cascade, modes)| {
        let ([xs, zs], n) = (on_grid(modes, spots), modes.cascade.n);
        let planes = Field::SPECTRAL.map(|field| plane(cascade, field));
        let at = |x: usize, z: usize| planes.map(|plane| plane.map_or(0.0, |plane| f64::from(plane[z * n + x])));
        zs.iter().flat_map(|z| xs.iter().map(|x| at(*x, *z))).collect::<Vec<_>>()
    });
    summed(each, spots[0].len() * spots[1].len())
}

/// Particles of a surface at those samples.
pub fn particles_on_grid(surface: &Surface, sea: &Sea, spots: &[Vec<f64>; 2]) -> Vec<Particle> {
    let plane = |cascade: usize, field: Field| surface.cascades.get(cascade).and_then(|cascade| cascade.plane(field));
    sampled_on_grid(plane, sea, spots).iter().map(Particle::of).collect()
}

/// Numbers of the samples before the positions, along x and along z.
pub fn on_grid(modes: &CascadeModes, spots: &[Vec<f64>; 2]) -> [Vec<usize>; 2] {
    let (n, patch_m) = (modes.cascade.n, modes.cascade.patch_m);
    let sample = |metres: &f64| ((metres / patch_m).rem_euclid(1.0) * n as f64) as usize % n;
    [0, 1].map(|axis| spots[axis].iter().map(sample).collect())
}

fn summed(each: impl Iterator<Item = Vec<Fields>>, points: usize) -> Vec<Fields> {
    let mut sums = vec![[0.0; 11]; points];
    for fields in each {
        for (sum, fields) in sums.iter_mut().zip(fields) {
            sum.iter_mut().zip(fields).for_each(|(sum, field)| *sum += field);
        }
    }
    sums
}

/// The same modes on a grid of another side: those that it can't hold are left out.
pub fn with_grid(sea: &Sea, n: usize) -> Sea {
    with_modes(sea, |modes| (n, modes.cascade.half.min(n / 2 - 1)))
}

/// The same sea where each cascade has a grid of n samples a side and modes up to `half`, which `of` says.
pub fn with_modes(sea: &Sea, of: impl Fn(&CascadeModes) -> (usize, usize)) -> Sea {
    let cut = |modes: &CascadeModes| {
        let (rows, all) = (modes.rows(), modes.cascade.half);
        let ((n, half), mut cascade) = (of(modes), modes.cascade);
        (cascade.n, cascade.half) = (n, half);
        let columns = modes.modes.chunks_exact(rows).take(half + 1);
        let modes_left = columns.flat_map(|column| &column[all - half..=all + half]).copied().collect();
        CascadeModes { cascade, modes: modes_left, ..*modes }
    };
    Sea { cascades: sea.cascades.iter().map(cut).collect(), ..sea.clone() }
}

/// A sea on the CPU, with what is looked at of it.
pub struct Made {
    cpu: Cpu,
    plan: Plan,
    sea: Sea,
}

impl Made {
    /// These fields of a sea, normals in the way of `effects`.
    pub fn new(sea: Sea, fields: FieldSet, effects: &Effects) -> Self {
        let mut cpu = Cpu::new(None);
        cpu.load(&sea).expect("the CPU takes every sea");
        let plan = CascadePlan::new([(0, fields)], None, effects).by(sea.model);
        let plan = Plan { cascades: vec![plan; sea.cascades.len()] };
        Self { cpu, plan, sea }
    }

    /// Makes them at a tick.
    pub fn step(&mut self, tick: i64) -> &Surface {
        self.cpu.step(tick, &self.plan).expect("the plan is of this sea")
    }

    /// The sea.
    pub fn sea(&self) -> &Sea {
        &self.sea
    }

    /// What a client reads between the samples at every pair of positions: bicubic, all cascades summed.
    pub fn between(&mut self, tick: i64, spots: &[Vec<f64>; 2]) -> Vec<Fields> {
        let patches: Vec<f64> = self.sea.cascades.iter().map(|modes| modes.cascade.patch_m).collect();
        between(self.step(tick), &patches, spots)
    }

    /// Bytes of its planes, its tables and the amplitudes of one tick.
    pub fn memory_bytes(&self) -> u64 {
        let each = self.sea.cascades.iter().zip(&self.plan.cascades);
        let bytes = each.map(|(modes, plan)| {
            let computed: usize = plan.levels.iter().map(|level| level.computed().len()).sum();
            // Eight words of a mode in the table, and the two of its amplitude.
            4 * computed * modes.cascade.n * modes.cascade.n + 40 * modes.modes.len()
        });
        bytes.sum::<usize>() as u64
    }
}

/// The same of any surface whose patches have these sides, metres.
pub fn between(surface: &Surface, patches_m: &[f64], [xs, zs]: &[Vec<f64>; 2]) -> Vec<Fields> {
    let at: Vec<[f64; 2]> = zs.iter().flat_map(|z| xs.iter().map(|x| [*x, *z])).collect();
    let read = Sampler::new(surface, patches_m.iter().copied()).fields(&at, FieldSet::SPECTRAL);
    (0..at.len()).map(|i| Field::SPECTRAL.map(|field| f64::from(read[field as usize][i]))).collect()
}
