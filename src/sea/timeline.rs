//! The sea as a function of the tick: a fold over the log of changes, the same on every server.
//!
//! Each change begins a [`Stage`]. Under way, it is blended over what came before by a smoothstep of the tick; a
//! change that interrupts another is blended over it while the other goes on, so amplitudes never jump and never
//! rise above those of the seas being blended. All stages share one random draw and one layout.

use std::sync::{Arc, OnceLock};

use rustfft::num_complex::Complex64;

use super::dispersion::Dispersion;
use super::draw::Draw;
use super::foam_threshold::FoamThresholds;
use super::layout::Layout;
use super::modes::{CascadeModes, Mode, Sea};
use super::phase::{cycles_per_repeat, turn_of_tick};
use super::statistics::Statistics;
use super::table::EnergyTable;
use super::warnings::warnings;
use crate::scene::{Change, Foam, Scene, SeaState};

/// Most transitions under way at one tick; each costs memory and a share of every frame.
pub const MAX_OVERLAPPING: usize = 16;

/// Ticks before now for which tables are kept: as far back as foam remembers, and ten seconds more.
const KEEP_TICKS: i64 = Foam::MAX_MEMORY_STEPS * Foam::STEP_TICKS + 72_000;

/// A scene and every change made to it. Immutable: a change makes a new timeline that shares the old one's tables.
#[derive(Clone, Debug)]
pub struct Timeline {
    scene: Arc<Scene>,
    layout: Arc<Layout>,
    draw: Arc<Draw>,
    /// In order of (effective tick, sequence); the first is the scene itself, in effect since for ever.
    stages: Vec<Stage>,
    warnings: Arc<[String]>,
}

#[derive(Clone, Debug)]
struct Stage {
    sequence: u64,
    effective_tick: i64,
    transition_ticks: i64,
    change: Option<Change>,
    state: SeaState,
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

impl Timeline {
    /// A scene before any change. Integrates its spectrum, which takes a tenth of a second.
    pub fn new(scene: &Scene) -> Self {
        Self::replay(scene, &[], 0)
    }

    /// A scene and its log, for ticks from shortly before `now` on (as far back as foam remembers): what was over by
    /// then is folded into one state and forgotten.
    pub fn replay(scene: &Scene, changes: &[Change], now: i64) -> Self {
        let layout = Layout::of(scene);
        let draw = Draw::new(scene.seed, scene.amplitudes, &layout);
        let first = Stage::new(None, scene.sea.clone());
        let mut timeline = Self {
            scene: Arc::new(scene.clone()),
            layout: Arc::new(layout),
            draw: Arc::new(draw),
            stages: vec![first],
            warnings: Arc::default(),
        };
        for change in changes {
            timeline.insert(*change);
        }
        timeline.prepare(now);
        let newest = timeline.newest(now);
        let (energy, state) = (timeline.energy(newest), &timeline.stages[newest].state);
        timeline.warnings = warnings(scene, state, &timeline.layout, &energy.table).into();
        timeline
    }

    /// The timeline with one more change, for ticks from shortly before `now` on.
    pub fn with(&self, change: Change, now: i64) -> Self {
        let mut next = self.clone();
        next.insert(change);
        next.prepare(now);
        next
    }

    /// The scene it began with.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The cascades.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The sea state that is in effect, or being approached, at a tick.
    pub fn state_at(&self, tick: i64) -> &SeaState {
        &self.stages[self.newest(tick)].state
    }

    /// Sequence of the newest change in effect at a tick; 0 before the first.
    pub fn sequence_at(&self, tick: i64) -> u64 {
        self.stages.iter().filter(|stage| stage.effective_tick <= tick).map(|stage| stage.sequence).max().unwrap_or(0)
    }

    /// Transitions under way at a tick.
    pub fn overlapping(&self, tick: i64) -> usize {
        self.weights(tick).len() - 1
    }

    /// Significant wave height of the modes at a tick, metres: 4 sqrt of their summed energies.
    pub fn hs_at(&self, tick: i64) -> f64 {
        4.0 * libm::sqrt(self.energies_at(tick).iter().flatten().sum())
    }

    /// Energy of every mode at a tick, m^2, as in an [`EnergyTable`].
    fn energies_at(&self, tick: i64) -> Vec<Vec<f64>> {
        let parts = self.parts(tick);
        let cascade = |cascade: usize| {
            let root = |i: usize| parts.iter().map(|(part, w)| w * libm::sqrt(part.table.energy[cascade][i])).sum();
            let energy = |i: usize| {
                let root: f64 = root(i);
                root * root
            };
            (0..parts[0].0.table.energy[cascade].len()).map(energy).collect()
        };
        (0..self.layout.cascades.len()).map(cascade).collect()
    }

    /// What the sea of a tick is like.
    pub fn statistics_at(&self, tick: i64) -> Statistics {
        let newest = self.newest(tick);
        let dispersion = Dispersion::new(self.stages[newest].state.water);
        let parts = self.parts(tick);
        let coverage = parts.iter().map(|(part, w)| w * part.foam.coverage).sum();
        let choppiness = self.scene.effects.choppiness;
        let wanted_m0 = self.energy(newest).table.wanted_m0;
        Statistics::new(&dispersion, &self.layout, &self.energies_at(tick), wanted_m0, coverage, choppiness)
    }

    /// What an operator would not expect of the scene.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// 4 sqrt(m0) of the spectrum that is wanted at a tick, resolved by the cascades or not, metres.
    pub fn wanted_hs_at(&self, tick: i64) -> f64 {
        4.0 * libm::sqrt(self.energy(self.newest(tick)).table.wanted_m0)
    }

    /// Whether the sea of two ticks is the same but for the turning of its modes.
    pub fn same_sea(&self, a: i64, b: i64) -> bool {
        self.newest(a) == self.newest(b) && self.weights(a) == self.weights(b)
    }

    /// The sea of a tick.
    pub fn at(&self, tick: i64) -> Sea {
        let parts = self.parts(tick);
        let rotation = self.rotation(self.newest(tick));
        let widenings: Vec<_> = self.weights(tick).into_iter().map(|(stage, w)| (self.rotation(stage), w)).collect();
        let cascade = |index: usize| {
            let cascade = self.layout.cascades[index];
            let (half, side) = (cascade.half, 2 * cascade.half + 1);
            let xi = &self.draw.xi[index];
            // h0 = sqrt(E)/2 (xi_r + i xi_i): E|h0|^2 = E/2, and both halves of the plane give E (PHYSICS: Hs exact).
            let h0 = |i: usize| -> Complex64 {
                let root: f64 = parts.iter().map(|(part, w)| w * libm::sqrt(part.table.energy[index][i])).sum();
                xi[i] * (0.5 * root)
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
        Sea {
            cascades: (0..self.layout.cascades.len()).map(cascade).collect(),
            repeat: self.scene.repeat.ticks,
            choppiness: self.scene.effects.choppiness,
        }
    }

    /// Index of the stage in effect at a tick.
    fn newest(&self, tick: i64) -> usize {
        self.stages.partition_point(|stage| stage.effective_tick <= tick).max(1) - 1
    }

    /// Stages that make the sea of a tick, newest first, and their shares of its amplitude, which sum to 1.
    fn weights(&self, tick: i64) -> Vec<(usize, f64)> {
        let mut rest = 1.0;
        let mut weights = Vec::with_capacity(2);
        for index in (0..=self.newest(tick)).rev() {
            let share = self.stages[index].share(tick);
            if share > 0.0 || index == 0 {
                weights.push((index, rest * share));
            }
            rest *= 1.0 - share;
            if rest == 0.0 {
                break;
            }
        }
        weights
    }

    fn parts(&self, tick: i64) -> Vec<(Arc<StageEnergy>, f64)> {
        self.weights(tick).into_iter().map(|(index, weight)| (self.energy(index), weight)).collect()
    }

    fn energy(&self, index: usize) -> Arc<StageEnergy> {
        let stage = &self.stages[index];
        let build = || {
            let table = EnergyTable::build(&stage.state, &self.layout);
            let effects = &self.scene.effects;
            let thresholds =
                |foam: &Foam| FoamThresholds::new(&stage.state, &self.layout, &table, effects.choppiness, foam);
            let foam = effects.foam.as_ref().map_or_else(|| FoamThresholds::none(&self.layout), thresholds);
            Arc::new(StageEnergy { table, foam })
        };
        Arc::clone(stage.energy.get_or_init(build))
    }

    /// How modes turn during a stage. Offsets are a fold over all changes of the water before it.
    fn rotation(&self, index: usize) -> Arc<Rotation> {
        let known = (0..=index).rev().find(|i| self.stages[*i].rotation.get().is_some());
        let mut folded: Option<Arc<Rotation>> = known.and_then(|i| self.stages[i].rotation.get().cloned());
        for i in known.map_or(0, |i| i + 1)..=index {
            let stage = &self.stages[i];
            let same_water = i > 0 && self.stages[i - 1].state.water == stage.state.water;
            folded = Some(match folded {
                Some(before) if same_water => before,
                before => Arc::new(self.rotate(stage, before.as_deref())),
            });
        }
        // Kept for this stage alone: those in between may be many, and are asked for seldom.
        let folded = folded.expect("the loop reaches `index`, or it was known");
        Arc::clone(self.stages[index].rotation.get_or_init(|| folded))
    }

    fn rotate(&self, stage: &Stage, before: Option<&Rotation>) -> Rotation {
        let dispersion = Dispersion::new(stage.state.water);
        let repeat = self.scene.repeat.ticks;
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

    fn insert(&mut self, change: Change) {
        let key = (change.effective_tick, change.sequence);
        let at = self.stages.partition_point(|stage| (stage.effective_tick, stage.sequence) < key).max(1);
        self.stages.insert(at, Stage::new(Some(change), self.stages[at - 1].state.clone()));
        // What a later change doesn't set, it inherits: fold again from here.
        let mut turning_changed = false;
        for i in at..self.stages.len() {
            let before = self.stages[i - 1].state.clone();
            let stage = &mut self.stages[i];
            let state = stage.change.map_or(before.clone(), |change| change.kind.apply(&before));
            turning_changed |= i == at && state.water != before.water;
            if i > at && state != stage.state {
                stage.energy = OnceLock::new();
            }
            turning_changed |= i > at && state.water != stage.state.water;
            if turning_changed {
                stage.rotation = OnceLock::new();
            }
            stage.state = state;
        }
    }

    /// Builds what frames from `now` on need, and lets go of what none of them can: a log of years is one stage and
    /// the few that may still be seen.
    fn prepare(&mut self, now: i64) {
        let oldest = self.weights(now.saturating_sub(KEEP_TICKS)).last().map_or(0, |(index, _)| *index);
        // Offsets are folded from the first stage.
        let rotation = self.rotation(oldest);
        let sequence = self.stages[..=oldest].iter().map(|stage| stage.sequence).max().unwrap_or(0);
        let base = Stage {
            sequence,
            effective_tick: i64::MIN,
            transition_ticks: 0,
            change: None,
            rotation: OnceLock::from(rotation),
            ..self.stages[oldest].clone()
        };
        self.stages.splice(..=oldest, [base]);
        let first = self.weights(now).last().map_or(0, |(index, _)| *index);
        for index in first..self.stages.len() {
            self.energy(index);
        }
    }
}

impl Stage {
    fn new(change: Option<Change>, state: SeaState) -> Self {
        Self {
            sequence: change.map_or(0, |change| change.sequence),
            effective_tick: change.map_or(i64::MIN, |change| change.effective_tick),
            transition_ticks: change.map_or(0, |change| change.transition_ticks),
            change,
            state,
            energy: OnceLock::new(),
            rotation: OnceLock::new(),
        }
    }

    /// Smoothstep of the way through this stage's transition, 0 to 1.
    fn share(&self, tick: i64) -> f64 {
        let since = tick.saturating_sub(self.effective_tick);
        if since >= self.transition_ticks {
            return 1.0;
        }
        let t = since as f64 / self.transition_ticks as f64;
        t * t * (3.0 - 2.0 * t)
    }
}
