//! The passes on the CPU, transforms side by side over the threads.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::{Backend, BackendError, CascadeSurface, Surface, Tap};
use crate::pass::evolve::{Amplitudes, EvolveTable};
use crate::pass::transform::{Transform, Workspace};
use crate::pass::trochoid::Trochoids;
use crate::pass::{assemble, foam};
use crate::plan::{CascadePlan, Field, FieldSet, LevelPlan, Packing, Plan};
use crate::scene::{Model, Normals};
use crate::sea::{Cascade, CascadeModes, HeldFoam, Sea, turn_of_tick};

/// The CPU backend. Gives the same bytes on any number of threads.
pub struct Cpu {
    threads: rayon::ThreadPool,
    repeat: u64,
    cascades: Vec<CascadeEngine>,
    surface: Surface,
    workspaces: Workspaces,
}

/// Memory that transforms work in: as many as have run side by side.
#[derive(Default)]
struct Workspaces(Mutex<Vec<Workspace>>);

struct CascadeEngine {
    cascade: Cascade,
    table: EvolveTable,
    /// In place of the table and all that follows from it, where the sea is made of them.
    trochoids: Option<Trochoids>,
    /// By level; made when it is first asked for.
    transforms: Vec<Option<Transform>>,
    heights: Amplitudes,
    rates: Amplitudes,
    held_foam: Vec<HeldFoam>,
    foam_threshold: f32,
}

impl Cpu {
    /// Its name in logs, metrics and status.
    pub const NAME: &str = "cpu";

    /// A backend with its own threads; `None` takes one for each core.
    ///
    /// # Panics
    /// If the system gives no threads.
    pub fn new(threads: Option<usize>) -> Self {
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|i| format!("swellcast-cpu-{i}"))
            .build()
            .expect("the system gives threads at start");
        Self {
            threads,
            repeat: 1,
            cascades: Vec::new(),
            surface: Surface::default(),
            workspaces: Workspaces::default(),
        }
    }
}

impl Backend for Cpu {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn load(&mut self, sea: &Sea) -> Result<(), BackendError> {
        self.repeat = sea.repeat;
        let made = self.threads.install(|| {
            let of = |modes: &CascadeModes| match sea.model {
                Model::Fft => (EvolveTable::new(modes, sea.choppiness, sea.repeat), None),
                Model::Trochoid(_) => (EvolveTable::default(), Some(Trochoids::new(modes, sea))),
            };
            sea.cascades.par_iter().map(of).collect::<Vec<_>>()
        });
        let surfaces = std::mem::take(&mut self.surface.cascades);
        let mut held: Vec<_> = std::mem::take(&mut self.cascades).into_iter().zip(surfaces).collect();
        for (modes, made) in sea.cascades.iter().zip(made) {
            // A cascade that stays keeps its foam, wherever it stands now.
            let (mut engine, surface) = match held.iter().position(|(engine, _)| engine.cascade == modes.cascade) {
                Some(at) => held.swap_remove(at),
                None => (CascadeEngine::new(modes.cascade), CascadeSurface::new(&modes.cascade)),
            };
            (engine.table, engine.trochoids) = made;
            engine.foam_threshold = modes.foam_threshold as f32;
            self.cascades.push(engine);
            self.surface.cascades.push(surface);
        }
        Ok(())
    }

    fn step(&mut self, tick: i64, plan: &Plan) -> Result<&Surface, BackendError> {
        if plan.cascades.len() != self.cascades.len() {
            return Err(BackendError::PlanMismatch { plan: plan.cascades.len(), sea: self.cascades.len() });
        }
        let turn = turn_of_tick(tick, self.repeat);
        let work = self.cascades.par_iter_mut().zip(&mut self.surface.cascades).zip(&plan.cascades);
        let workspaces = &self.workspaces;
        self.threads.install(|| {
            work.for_each(|((engine, surface), plan)| engine.step(tick, turn, plan, surface, workspaces));
        });
        self.surface.tick = tick;
        Ok(&self.surface)
    }

    fn surface(&self) -> &Surface {
        &self.surface
    }

    fn tap(&self, cascade: usize, tap: Tap) -> Option<Vec<f32>> {
        let engine = self.cascades.get(cascade)?;
        match tap {
            Tap::Heights => {
                Some(engine.heights.re.iter().zip(&engine.heights.im).flat_map(|(re, im)| [*re, *im]).collect())
            }
            Tap::HeldFoam => Some(engine.held_foam.iter().map(|held| held.foam).collect()),
        }
    }
}

impl CascadeEngine {
    fn new(cascade: Cascade) -> Self {
        Self {
            cascade,
            table: EvolveTable::default(),
            trochoids: None,
            transforms: (0..cascade.levels()).map(|_| None).collect(),
            heights: Amplitudes::default(),
            rates: Amplitudes::default(),
            held_foam: Vec::new(),
            foam_threshold: 0.0,
        }
    }

    fn step(
        &mut self,
        tick: i64,
        turn: u32,
        plan: &CascadePlan,
        surface: &mut CascadeSurface,
        workspaces: &Workspaces,
    ) {
        self.evolve(turn, plan);
        for level in &plan.levels {
            let (n, half) = self.cascade.level(level.level);
            let transform = &mut self.transforms[usize::from(level.level)];
            if !level.transforms.is_empty() {
                transform.get_or_insert_with(|| Transform::new(n, half));
            }
        }
        surface.keep(plan);
        let engine = &*self;
        plan.levels.par_iter().zip(surface.planes_of(plan)).for_each(|(level, planes)| {
            let (n, _) = engine.cascade.level(level.level);
            if let Some(trochoids) = &engine.trochoids {
                trochoids.fill(tick, n, level.fields, planes);
            } else {
                engine.transform(level, planes, workspaces);
                assemble(level, n, engine.cascade.patch_m as f32, planes);
            }
        });
        if let Some(work) = plan.foam {
            let [.., jacobian, _, _, _, shown] = surface.planes(0);
            self.held_foam.resize(shown.len(), HeldFoam::default());
            foam::foam(&mut self.held_foam, jacobian, self.foam_threshold, work, shown);
        }
    }

    fn evolve(&mut self, turn: u32, plan: &CascadePlan) {
        let finest = plan.levels.iter().find(|level| !level.transforms.is_empty());
        let Some(finest) = finest else { return };
        let (_, half) = self.cascade.level(finest.level);
        if plan.levels.iter().flat_map(|level| &level.transforms).copied().any(is_velocity) {
            self.table.heights_and_rates(turn, half, &mut self.heights, &mut self.rates);
        } else {
            self.table.heights(turn, half, &mut self.heights);
        }
    }

    fn transform(&self, level: &LevelPlan, planes: &mut [Vec<f32>; Field::ALL.len()], workspaces: &Workspaces) {
        let Some(transform) = &self.transforms[usize::from(level.level)] else { return };
        let mut planes: Vec<_> = planes.iter_mut().map(|plane| Some(plane.as_mut_slice())).collect();
        let mut take = |field: Field| planes[field as usize].take().unwrap_or_default();
        let jobs: Vec<_> = (level.transforms.iter())
            .map(|packing| match *packing {
                Packing::HalfComplex(field) => (*packing, [take(field), &mut []]),
                Packing::Packed(a, b) => (*packing, [take(a), take(b)]),
            })
            .collect();
        jobs.into_par_iter().with_max_len(1).for_each(|(packing, planes)| {
            let amplitudes = if is_velocity(packing) { &self.rates } else { &self.heights };
            workspaces.with(|workspace| transform.run(packing, &self.table, amplitudes, workspace, planes));
        });
    }
}

impl Workspaces {
    fn with<T>(&self, work: impl FnOnce(&mut Workspace) -> T) -> T {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut workspace = free().pop().unwrap_or_default();
        let done = work(&mut workspace);
        free().push(workspace);
        done
    }
}

fn is_velocity(packing: Packing) -> bool {
    !packing.fields().intersection(FieldSet::VELOCITY).is_empty()
}

/// Makes those fields of a level that come of others.
fn assemble(level: &LevelPlan, n: usize, patch_m: f32, planes: &mut [Vec<f32>; Field::ALL.len()]) {
    let [height, dx, dz, hx, hz, dxx, dzz, dxz, _, _, _, jacobian, eigenvalue, sx, sz, _] = planes;
    if level.fields.contains(Field::Jacobian) {
        assemble::jacobian([dxx, dzz, dxz], jacobian);
    }
    if level.fields.contains(Field::Eigenvalue) {
        assemble::eigenvalue([dxx, dzz, dxz], eigenvalue);
    }
    if !level.fields.contains(Field::NormalX) && !level.fields.contains(Field::NormalZ) {
        return;
    }
    sx.resize(n * n, 0.0);
    sz.resize(n * n, 0.0);
    match level.normals {
        Normals::None => {}
        Normals::CentralDifference | Normals::Sobel => {
            assemble::slopes_of_points(level.normals, n, patch_m / n as f32, [dx, height, dz], [sx, sz]);
        }
        Normals::Exact | Normals::DisplacedSlopes => {
            assemble::displaced_slopes(false, [hx, hz], [dxx, dzz, dxz], [sx, sz]);
        }
        Normals::Diagonal => assemble::displaced_slopes(true, [hx, hz], [dxx, dzz, dxz], [sx, sz]),
    }
}
