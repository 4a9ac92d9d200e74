//! A plan as people read it: pass by pass, with what of each transform is skipped, and what a second of it takes.

use serde::Serialize;

use super::packing::Packing;
use super::{CascadePlan, Demand, Field, FieldSet, LevelPlan, Plan, fields_of};
use crate::scene::{Foam, Model, Scene};
use crate::sea::{Cascade, CascadeModes, Layout, Sea};
use crate::wire::{Group, TICKS_PER_SECOND, UnitName};

/// One pass over one grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassLine {
    /// Number of the cascade.
    pub cascade: u8,
    /// Level of detail.
    pub level: u8,
    /// `evolve`, `half_complex`, `packed` and `assemble`, or `trochoid`; and `foam`.
    pub pass: &'static str,
    /// Fields that it makes.
    pub fields: Vec<&'static str>,
    /// Samples a side; of `evolve`, none.
    pub n: usize,
    /// Modes turned, or samples written in all.
    pub points: usize,
    /// Columns transformed, of those that a transform of n x n without empty ones has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<[usize; 2]>,
}

/// What a demand takes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Listing {
    /// Passes of a frame in which every unit is due.
    pub passes: Vec<PassLine>,
    /// Real fields transformed in such a frame.
    pub transforms: usize,
    /// Samples of those.
    pub samples: usize,
    /// Real fields transformed in a second, at the rates that are wanted; foam's own steps included.
    pub transforms_per_second: f64,
    /// Samples of those.
    pub samples_per_second: f64,
}

/// What waves are due of some units of one cascade; foam is apart.
pub fn levels_of<'a>(units: impl Iterator<Item = &'a UnitName>) -> impl Iterator<Item = (u8, FieldSet)> {
    units.filter(|unit| unit.group != Group::Foam).map(|unit| (unit.level, FieldSet::of(fields_of(unit.group))))
}

impl Listing {
    /// Of a demand for a sea with this layout, and of points that are followed: their fields, and the smallest of their
    /// intervals. Foam of those cascades whose water breaks takes transforms.
    pub fn new(demand: &Demand, points: Option<(FieldSet, i64)>, layout: &Layout, scene: &Scene, sea: &Sea) -> Self {
        let all = plan_at(demand, points, scene, sea, 0);
        let passes = all
            .cascades
            .iter()
            .zip(&layout.cascades)
            .flat_map(|(plan, cascade)| lines(plan, cascade, scene.model))
            .collect();
        let (transforms, samples) = all.work(layout);
        // Frames of all rates and steps of foam come together again after so many ticks.
        const ROUND: i64 = 1440;
        let (mut in_round, mut samples_in_round) = (0, 0);
        let intervals = demand.values().copied().chain(points.map(|(_, interval)| interval));
        let ticks: std::collections::BTreeSet<i64> = intervals
            .flat_map(|interval| (0..ROUND).step_by(interval as usize))
            .chain((0..ROUND).step_by(Foam::STEP_TICKS as usize))
            .collect();
        for tick in ticks {
            let (transforms, samples) = plan_at(demand, points, scene, sea, tick).work(layout);
            (in_round, samples_in_round) = (in_round + transforms, samples_in_round + samples);
        }
        let a_second = TICKS_PER_SECOND as f64 / ROUND as f64;
        Self {
            passes,
            transforms,
            samples,
            transforms_per_second: in_round as f64 * a_second,
            samples_per_second: samples_in_round as f64 * a_second,
        }
    }
}

/// Work at a tick once foam is warm.
fn plan_at(demand: &Demand, points: Option<(FieldSet, i64)>, scene: &Scene, sea: &Sea, tick: i64) -> Plan {
    let followed = points.filter(|(_, interval)| tick % interval == 0).map(|(fields, _)| (0, fields));
    let cascade = |modes: &CascadeModes| {
        let number = modes.cascade.index;
        let here = demand.iter().filter(move |(unit, _)| unit.cascade == number);
        let due = here.clone().filter(|(_, interval)| tick % **interval == 0).map(|(unit, _)| unit);
        let advance = tick % Foam::STEP_TICKS == 0;
        let shown = due.clone().any(|unit| unit.group == Group::Foam);
        let held = here.clone().any(|(unit, _)| unit.group == Group::Foam);
        let work = super::FoamWork { restart: false, decay: 1.0, growth: 1.0, advance, breaks: modes.breaks() };
        let foam = scene.effects.foam.is_some() && (shown || held && advance);
        CascadePlan::new(levels_of(due).chain(followed), foam.then_some(work), &scene.effects).by(scene.model)
    };
    Plan { cascades: sea.cascades.iter().map(cascade).collect() }
}

fn lines(plan: &CascadePlan, cascade: &Cascade, model: Model) -> Vec<PassLine> {
    let line = |level, pass, fields: FieldSet, n, points| PassLine {
        cascade: cascade.index,
        level,
        pass,
        fields: fields.iter().map(Field::name).collect(),
        n,
        points,
        columns: None,
    };
    let mut lines = Vec::new();
    if let Some(finest) = plan.levels.iter().find(|level| !level.transforms.is_empty()) {
        // Whole columns of modes are turned, as many as the finest level needs.
        let modes = (cascade.level(finest.level).1 + 1) * (2 * cascade.half + 1);
        lines.push(line(finest.level, "evolve", FieldSet::NONE, 0, modes));
    }
    for LevelPlan { level, fields, transforms, .. } in &plan.levels {
        let (n, half) = cascade.level(*level);
        if model != Model::Fft {
            let made = fields.difference(FieldSet::of(&[Field::Foam]));
            lines.push(line(*level, "trochoid", made, n, made.len() * n * n));
            continue;
        }
        for packing in transforms {
            let (pass, columns) = match packing {
                Packing::HalfComplex(_) => ("half_complex", [half + 1, n / 2 + 1]),
                Packing::Packed(..) => ("packed", [2 * half + 1, n]),
            };
            let made = packing.fields();
            lines.push(PassLine { columns: Some(columns), ..line(*level, pass, made, n, made.len() * n * n) });
        }
        let assembled = fields.difference(FieldSet::SPECTRAL).difference(FieldSet::of(&[Field::Foam]));
        if !assembled.is_empty() {
            lines.push(line(*level, "assemble", assembled, n, assembled.len() * n * n));
        }
    }
    if plan.foam.is_some() {
        lines.push(line(0, "foam", FieldSet::of(&[Field::Foam]), cascade.n, cascade.n * cascade.n));
    }
    lines
}
