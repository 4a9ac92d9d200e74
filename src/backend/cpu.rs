//! The passes on the CPU, fields side by side over the threads.

use rayon::prelude::*;
use rustfft::num_complex::Complex32;

use super::{Backend, BackendError, CascadeSurface, Surface, Tap};
use crate::pass::evolve::EvolveTable;
use crate::pass::transform::{Transform, Workspace};
use crate::pass::{assemble, foam};
use crate::plan::{CascadePlan, Field, FieldSet, Plan};
use crate::sea::{Cascade, HeldFoam, Sea, turn_of_tick};

/// The CPU backend. Gives the same bytes on any number of threads.
pub struct Cpu {
    threads: rayon::ThreadPool,
    repeat: u64,
    cascades: Vec<CascadeEngine>,
    surface: Surface,
}

struct CascadeEngine {
    cascade: Cascade,
    table: EvolveTable,
    transform: Transform,
    workspaces: Vec<Workspace>,
    heights: Vec<Complex32>,
    rates: Vec<Complex32>,
    held_foam: Vec<HeldFoam>,
    foam_threshold: f32,
}

impl Cpu {
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
        Self { threads, repeat: 1, cascades: Vec::new(), surface: Surface::default() }
    }
}

impl Backend for Cpu {
    fn name(&self) -> &'static str {
        "cpu"
    }

    fn load(&mut self, sea: &Sea) -> Result<(), BackendError> {
        self.repeat = sea.repeat;
        let tables = self.threads.install(|| {
            sea.cascades.par_iter().map(|modes| EvolveTable::new(modes, sea.choppiness, sea.repeat)).collect::<Vec<_>>()
        });
        let surfaces = std::mem::take(&mut self.surface.cascades);
        let mut held: Vec<_> = std::mem::take(&mut self.cascades).into_iter().zip(surfaces).collect();
        for (modes, table) in sea.cascades.iter().zip(tables) {
            // A cascade that stays keeps its foam, wherever it stands now.
            let (mut engine, surface) = match held.iter().position(|(engine, _)| engine.cascade == modes.cascade) {
                Some(at) => held.swap_remove(at),
                None => {
                    let surface = CascadeSurface { n: modes.cascade.n, ..CascadeSurface::default() };
                    (CascadeEngine::new(modes.cascade), surface)
                }
            };
            engine.table = table;
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
        self.threads.install(|| work.for_each(|((engine, surface), plan)| engine.step(turn, plan, surface)));
        self.surface.tick = tick;
        Ok(&self.surface)
    }

    fn surface(&self) -> &Surface {
        &self.surface
    }

    fn tap(&self, cascade: usize, tap: Tap) -> Option<Vec<f32>> {
        let engine = self.cascades.get(cascade)?;
        match tap {
            Tap::Heights => Some(engine.heights.iter().flat_map(|h| [h.re, h.im]).collect()),
            Tap::HeldFoam => Some(engine.held_foam.iter().map(|held| held.foam).collect()),
        }
    }
}

impl CascadeEngine {
    fn new(cascade: Cascade) -> Self {
        let transform = Transform::new(cascade.n, cascade.half);
        let modes = (cascade.half + 1) * (2 * cascade.half + 1);
        Self {
            cascade,
            table: EvolveTable::default(),
            transform,
            workspaces: Vec::new(),
            heights: vec![Complex32::ZERO; modes],
            rates: vec![Complex32::ZERO; modes],
            held_foam: Vec::new(),
            foam_threshold: 0.0,
        }
    }

    fn step(&mut self, turn: u32, plan: &CascadePlan, surface: &mut CascadeSurface) {
        let samples = self.cascade.n * self.cascade.n;
        let assembled = plan.foam.is_some() || plan.fields.contains(Field::Jacobian);
        let needed = plan.fields.union(plan.transforms);
        let needed = if assembled { needed.union(FieldSet::DERIVATIVES).with(Field::Jacobian) } else { needed };
        for (field, plane) in Field::ALL.into_iter().zip(&mut surface.planes) {
            plane.resize(if needed.contains(field) { samples } else { 0 }, 0.0);
            // A field that needs no transform is nothing, not what stood there before.
            if FieldSet::SPECTRAL.difference(plan.transforms).contains(field) {
                plane.fill(0.0);
            }
        }
        if !plan.transforms.is_empty() {
            self.transform_all(turn, plan.transforms, surface);
        }
        if assembled {
            let [_, _, _, _, _, dxx, dzz, dxz, _, _, _, jacobian, .., shown] = &mut surface.planes;
            assemble::jacobian(dxx, dzz, dxz, jacobian);
            if let Some(work) = plan.foam {
                self.held_foam.resize(samples, HeldFoam::default());
                foam::foam(&mut self.held_foam, jacobian, self.foam_threshold, work, shown);
            }
        }
    }

    fn transform_all(&mut self, turn: u32, fields: FieldSet, surface: &mut CascadeSurface) {
        self.table.heights(turn, &mut self.heights);
        if !fields.intersection(FieldSet::VELOCITY).is_empty() {
            self.table.rates(turn, &mut self.rates);
        }
        while self.workspaces.len() < fields.len() {
            self.workspaces.push(self.transform.workspace());
        }
        let (table, transform, heights, rates) = (&self.table, &self.transform, &self.heights, &self.rates);
        let planes = Field::ALL.into_iter().zip(&mut surface.planes).filter(|(field, _)| fields.contains(*field));
        let jobs: Vec<_> = planes.zip(&mut self.workspaces).collect();
        jobs.into_par_iter().for_each(|((field, plane), workspace)| {
            let (factors, odd) = table.factors(field);
            let source = if FieldSet::VELOCITY.contains(field) { rates } else { heights };
            transform.run(source, factors, odd, workspace, plane);
        });
    }
}
