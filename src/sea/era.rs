//! One layout of a timeline and the sea on it: draw, tables of every stage, exact phase, and the ticks it is there.
//!
//! Phase offsets begin at zero with the water in effect when the layout begins, and are a fold over the changes of
//! water from there on. All stages share one random draw.

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, OnceLock};

use rustfft::num_complex::Complex64;

use super::dispersion::Dispersion;
use super::draw::Draw;
use super::foam_threshold::FoamThresholds;
use super::layout::{Cascade, Layout};
use super::modes::{CascadeModes, Mode};
use super::phase::{cycles_per_repeat, turn_of_tick};
use super::stages::{Inserted, Stages};
use super::table::EnergyTable;
use super::warnings::warnings;
use crate::scene::{CrossFade, Foam, Scene};
use crate::wire::TICKS_PER_SECOND;

/// How long before it acts a record of a sequence is built, ticks: half a minute.
const AHEAD_TICKS: i64 = 30 * TICKS_PER_SECOND;

/// A cascade and the ticks at which it is part of the sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Life {
    /// The cascade.
    pub cascade: Cascade,
    /// The first tick; `i64::MIN` for the cascades that a scene begins with.
    pub from_tick: i64,
    /// The tick after the last; `None` while no change of layout ends it.
    pub until_tick: Option<i64>,
    fall: Option<CrossFade>,
}

impl Life {
    /// Whether the cascade is part of the sea of a tick.
    pub fn contains(&self, tick: i64) -> bool {
        tick >= self.from_tick && !self.is_over(tick)
    }

    /// Share of its foam that is shown at a tick: foam outlives the waves that made it, but not the cascade.
    pub fn foam_left(&self, tick: i64) -> f64 {
        1.0 - self.fall.map_or(0.0, |fall| fall.share(tick))
    }

    /// Whether the cascade has ended by a tick.
    pub fn is_over(&self, tick: i64) -> bool {
        self.until_tick.is_some_and(|until| tick >= until)
    }
}

/// A layout, and everything that follows from it and the stages. Tables stand in the order of the stages.
#[derive(Clone, Debug)]
pub struct Era {
    pub layout: Layout,
    /// How it came, with the sequence of the change; `None` for the layout that the scene begins with.
    rise: Option<(CrossFade, u64)>,
    /// How it goes.
    fall: Option<CrossFade>,
    /// Jacobian below which water foams, where that is not calibrated.
    foams_below: Option<f64>,
    draw: OnceLock<Arc<Draw>>,
    tables: Vec<Tables>,
}

/// What one stage is on this layout; made when it is asked for.
#[derive(Clone, Debug, Default)]
struct Tables {
    energy: OnceLock<Arc<StageEnergy>>,
    rotation: OnceLock<Arc<Rotation>>,
}

#[derive(Debug)]
struct StageEnergy {
    table: EnergyTable,
    foam: FoamThresholds,
}

/// How the modes of every cascade turn: the same for all stages with the same water.
#[derive(Debug)]
struct Rotation {
    /// Cycles per repeat and phase offset, in the order of `CascadeModes::modes`.
    turns: Vec<Vec<(u32, u32)>>,
    widening: Vec<Vec<f64>>,
}

impl Era {
    /// The era of a layout that came by `rise`, with a change of that sequence, beside `stages` stages.
    pub fn new(layout: Layout, rise: Option<(CrossFade, u64)>, stages: usize) -> Self {
        let (draw, tables) = (OnceLock::new(), vec![Tables::default(); stages]);
        Self { layout, rise, fall: None, foams_below: None, draw, tables }
    }

    /// The same, where water foams below a Jacobian that nobody calibrated.
    pub fn uncalibrated(self, jacobian: f64) -> Self {
        Self { foams_below: Some(jacobian), ..self }
    }

    /// Ends it.
    pub fn end(&mut self, fall: CrossFade) {
        self.fall = Some(fall);
    }

    /// The first tick at which it is there.
    pub fn from(&self) -> i64 {
        self.rise.map_or(i64::MIN, |(rise, _)| rise.from)
    }

    /// The tick after the last at which it is there.
    pub fn until(&self) -> i64 {
        self.fall.map_or(i64::MAX, |fall| fall.until)
    }

    /// The tick from which on another layout can be accepted after it.
    pub fn settled(&self) -> i64 {
        self.rise.map_or(i64::MIN, |(rise, _)| rise.over())
    }

    /// Its cascades, each with its ticks.
    pub fn lives(&self) -> impl Iterator<Item = Life> {
        let (from_tick, fall) = (self.from(), self.fall);
        let life = move |cascade: &Cascade| Life {
            cascade: *cascade,
            from_tick,
            until_tick: fall.map(|fall| fall.until),
            fall,
        };
        self.layout.cascades.iter().map(life)
    }

    /// Share of its amplitudes in the sea of a tick. Squares of two eras that cross-fade sum to 1: their draws are
    /// independent, so energies add.
    pub fn amplitude(&self, tick: i64) -> f64 {
        let quarter = |share: f64| FRAC_PI_2 * share;
        let rising = self.rise.map_or(1.0, |(rise, _)| match rise.share(tick) {
            1.0 => 1.0,
            share => libm::sin(quarter(share)),
        });
        let falling = self.fall.map_or(1.0, |fall| match fall.share(tick) {
            1.0 => 0.0,
            share => libm::cos(quarter(share)),
        });
        rising * falling
    }

    /// Energy of every mode at a tick, m^2, as in an [`EnergyTable`].
    pub fn energies(&self, stages: &Stages, tick: i64) -> Vec<Vec<f64>> {
        let amplitude = self.amplitude(tick);
        if amplitude == 0.0 {
            return self.layout.cascades.iter().map(|cascade| vec![0.0; cascade.cells()]).collect();
        }
        let parts = self.parts(stages, tick);
        let cascade = |(index, cascade): (usize, &Cascade)| {
            let energy = |i: usize| {
                let root: f64 = parts.iter().map(|(part, w)| w * libm::sqrt(part.table.energy[index][i])).sum();
                amplitude * amplitude * root * root
            };
            (0..cascade.cells()).map(energy).collect()
        };
        self.layout.cascades.iter().enumerate().map(cascade).collect()
    }

    /// Share of the area that its foam covers at a tick.
    pub fn foam_coverage(&self, stages: &Stages, tick: i64) -> f64 {
        let amplitude = self.amplitude(tick);
        let coverage = |(part, w): &(Arc<StageEnergy>, f64)| w * part.foam.coverage;
        if amplitude == 0.0 {
            0.0
        } else {
            self.parts(stages, tick).iter().map(coverage).sum::<f64>() * amplitude * amplitude
        }
    }

    /// What an operator would not expect of the scene that is in effect at a tick, on this layout.
    pub fn warnings(&self, stages: &Stages, tick: i64) -> Vec<String> {
        let wanted = stages.wanted(tick);
        warnings(&stages.get(wanted).scene, &self.layout, &self.energy(stages, wanted).table)
    }

    /// m0 of the spectrum that a stage wants, m^2.
    pub fn wanted_m0(&self, stages: &Stages, index: usize) -> f64 {
        self.energy(stages, index).table.wanted_m0
    }

    /// Its cascades at a tick, all still where it is not there.
    pub fn at(&self, stages: &Stages, tick: i64, repeat: u64) -> Vec<CascadeModes> {
        let amplitude = self.amplitude(tick);
        if amplitude == 0.0 {
            return self.layout.cascades.iter().map(still).collect();
        }
        let parts = self.parts(stages, tick);
        let rotation = self.rotation(stages, stages.newest(tick), repeat);
        let weights = stages.weights(tick).into_iter();
        let widenings: Vec<_> = weights.map(|(stage, w)| (self.rotation(stages, stage, repeat), w)).collect();
        let draw = self.draw(stages);
        let cascade = |index: usize| {
            let cascade = self.layout.cascades[index];
            let (half, side) = (cascade.half, 2 * cascade.half + 1);
            let xi = &draw.xi[index];
            // h0 = sqrt(E)/2 (xi_r + i xi_i): E|h0|^2 = E/2, and both halves of the plane give E (PHYSICS: Hs exact).
            let h0 = |i: usize| -> Complex64 {
                let root: f64 = parts.iter().map(|(part, w)| w * libm::sqrt(part.table.energy[index][i])).sum();
                xi[i] * (0.5 * amplitude * root)
            };
            let mode = |i: usize| {
                let (n, m) = (i / side, i % side);
                let forward = h0(m * side + n + half);
                let backward = h0((side - 1 - m) * side + half - n).conj();
                let (cycles, offset) = rotation.turns[index][i];
                let widening = widenings.iter().map(|(r, w)| w * r.widening[index][i]).sum();
                Mode { forward, backward, cycles, offset, widening }
            };
            let foam_threshold = parts.iter().map(|(part, w)| w * part.foam.jacobian[index]).sum();
            CascadeModes { cascade, foam_threshold, modes: (0..(half + 1) * side).map(mode).collect() }
        };
        (0..self.layout.cascades.len()).map(cascade).collect()
    }

    /// Takes note of a change.
    pub fn insert(&mut self, inserted: &Inserted) {
        self.tables.insert(inserted.at, Tables::default());
        for index in &inserted.seas {
            self.tables[*index].energy = OnceLock::new();
        }
        if let Some(first) = inserted.turning {
            self.tables[first..].iter_mut().for_each(|tables| tables.rotation = OnceLock::new());
        }
    }

    /// Follows [`Stages::fold`], before it is done: the sea is that of `oldest`, the turning that of `last`.
    pub fn fold(&mut self, stages: &Stages, oldest: usize, last: usize, repeat: u64) {
        // Offsets are folded from the first stage.
        let rotation = OnceLock::from(self.rotation(stages, last, repeat));
        let base = Tables { energy: self.tables[oldest].energy.clone(), rotation };
        self.tables.splice(..=last, [base]);
    }

    /// Builds what the sea of ticks from `now` on needs.
    pub fn prepare(&self, stages: &Stages, now: i64) {
        let first = stages.weights(now.max(self.from())).last().map_or(0, |(index, _)| *index);
        for index in (first..stages.len()).filter(|_| self.until() > now) {
            let stage = stages.get(index);
            // Records of a sequence are built as their time comes, or a start would take as long as all of them.
            let soon = stage.effective_tick < now.saturating_add(AHEAD_TICKS) || !stage.is_record();
            if soon && stage.effective_tick < self.until() && !stage.is_layout() {
                self.energy(stages, index);
            }
        }
        self.draw(stages);
    }

    fn draw(&self, stages: &Stages) -> Arc<Draw> {
        let scene = &stages.get(0).scene;
        let draw = || Arc::new(Draw::new(scene.seed, scene.amplitudes, &self.layout));
        Arc::clone(self.draw.get_or_init(draw))
    }

    fn parts(&self, stages: &Stages, tick: i64) -> Vec<(Arc<StageEnergy>, f64)> {
        stages.weights(tick).into_iter().map(|(index, weight)| (self.energy(stages, index), weight)).collect()
    }

    fn energy(&self, stages: &Stages, index: usize) -> Arc<StageEnergy> {
        let build = || {
            let Scene { sea, effects, .. } = &*stages.get(index).scene;
            let table = EnergyTable::build(sea, &self.layout);
            let thresholds = |foam: &Foam| match self.foams_below {
                Some(jacobian) => FoamThresholds::uncalibrated(&self.layout, jacobian),
                None => FoamThresholds::new(sea, &self.layout, &table, effects.choppiness, foam),
            };
            let foam = effects.foam.as_ref().map_or_else(|| FoamThresholds::none(&self.layout), thresholds);
            Arc::new(StageEnergy { table, foam })
        };
        Arc::clone(self.tables[index].energy.get_or_init(build))
    }

    /// How modes turn during a stage. Offsets are a fold over all changes of the water since the layout began.
    fn rotation(&self, stages: &Stages, index: usize, repeat: u64) -> Arc<Rotation> {
        // Stages that were over before are asked for their widening alone.
        let first = stages.before(self.rise.map_or((i64::MIN, 0), |(rise, sequence)| (rise.from, sequence))).min(index);
        let known = (first..=index).rev().find(|i| self.tables[*i].rotation.get().is_some());
        let mut folded: Option<Arc<Rotation>> = known.and_then(|i| self.tables[i].rotation.get().cloned());
        for i in known.map_or(first, |i| i + 1)..=index {
            let same_water = i > first && stages.get(i - 1).scene.sea.water == stages.get(i).scene.sea.water;
            folded = Some(match folded {
                Some(before) if same_water => before,
                before => Arc::new(self.rotate(stages, i, before.as_deref(), repeat)),
            });
        }
        // Kept for this stage alone: those in between may be many, and are asked for seldom.
        let folded = folded.expect("the loop reaches `index`, or it was known");
        Arc::clone(self.tables[index].rotation.get_or_init(|| folded))
    }

    fn rotate(&self, stages: &Stages, index: usize, before: Option<&Rotation>, repeat: u64) -> Rotation {
        let stage = stages.get(index);
        let dispersion = Dispersion::new(stage.scene.sea.water);
        let turn = if before.is_some() { turn_of_tick(stage.effective_tick, repeat) } else { 0 };
        let (mut turns, mut widening) = (Vec::new(), Vec::new());
        for (index, cascade) in self.layout.cascades.iter().enumerate() {
            let (half, side, dk) = (cascade.half, 2 * cascade.half + 1, cascade.dk());
            let wavenumber = |i: usize| {
                let (n, m) = ((i / side) as f64, (i % side) as f64 - half as f64);
                libm::sqrt(n * n + m * m) * dk
            };
            let turns_of = |i: usize| {
                let k = wavenumber(i);
                if k == 0.0 {
                    return (0, 0);
                }
                let cycles = cycles_per_repeat(dispersion.omega(k), repeat);
                let offset = before.map_or(0, |before| {
                    let (old_cycles, old_offset) = before.turns[index][i];
                    old_offset.wrapping_add(old_cycles.wrapping_sub(cycles).wrapping_mul(turn))
                });
                (cycles, offset)
            };
            let widening_of =
                |i: usize| if wavenumber(i) == 0.0 { 0.0 } else { dispersion.depth_widening(wavenumber(i)) };
            let modes = (half + 1) * side;
            turns.push((0..modes).map(turns_of).collect());
            widening.push((0..modes).map(widening_of).collect());
        }
        Rotation { turns, widening }
    }
}

/// A cascade that is not there: no wave, and nothing that foams.
fn still(cascade: &Cascade) -> CascadeModes {
    let none = Mode { forward: Complex64::ZERO, backward: Complex64::ZERO, cycles: 0, offset: 0, widening: 0.0 };
    let modes = (cascade.half + 1) * (2 * cascade.half + 1);
    CascadeModes { cascade: *cascade, foam_threshold: 0.0, modes: vec![none; modes] }
}
