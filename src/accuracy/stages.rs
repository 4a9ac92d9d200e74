//! Where a step's time goes: each stage of the CPU by itself, by grid, on one thread (as Barrett 2012 profiled his).

use super::ground::Ground;
use super::report::{STAGES, StageRow};
use crate::engine::Times;
use crate::pass::evolve::{Amplitudes, EvolveTable};
use crate::pass::transform::{Transform, Workspace};
use crate::pass::{assemble, foam};
use crate::plan::{Field, FieldSet, FoamWork, Packing, fields_of};
use crate::scene::{CascadeRequest, Patch, Scene};
use crate::sea::{HeldFoam, Sea, Timeline, turn_of_tick};
use crate::tile::{Plane, Stamp, UnitEncoder};
use crate::wire::{Codec, ErrorClass, Group, UnitName};

/// Eight fields: displacement, slopes and derivatives.
const FIELDS: FieldSet = super::ground::LOOKED_AT;
/// Six channels.
const SENT: [Group; 3] = [Group::Displacement, Group::Slopes, Group::Foam];
/// Ticks between frames: 15 Hz, all of which are sent at once.
const INTERVAL: i64 = 480;

/// One cascade and all that its stages work on.
struct Bench {
    n: usize,
    sea: Sea,
    table: EvolveTable,
    transform: Transform,
    workspace: Workspace,
    heights: Amplitudes,
    planes: Vec<Vec<f32>>,
    held: Vec<HeldFoam>,
    encoders: Vec<UnitEncoder>,
}

/// A row for every grid.
pub fn stages(ground: &Ground, told: &mut dyn FnMut(usize)) -> Vec<StageRow> {
    let sides: &[usize] = if ground.quick { &[64, 128, 256] } else { &[64, 128, 256, 512, 1024, 2048] };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("the system gives a thread");
    let row = |n: &usize| {
        told(*n);
        let rounds = if *n > 512 { 3 } else { ground.rounds };
        one.install(|| measure(ground, *n, rounds))
    };
    sides.iter().map(row).collect()
}

fn measure(ground: &Ground, n: usize, rounds: usize) -> StageRow {
    let length_m = ground.sea.cascades[0].cascade.patch_m;
    let cascades = CascadeRequest::Chosen { patches: vec![Patch { length_m, n }], band_limit: 1.0 / 3.0 };
    let scene = Scene { cascades, ..ground.scene.clone() };
    let mut times = [(); STAGES.len()].map(|()| Vec::new());
    let timed = |times: &mut Vec<f64>, work: &mut dyn FnMut()| {
        let started = ground.clock.now_us();
        work();
        times.push((ground.clock.now_us() - started) as f64 / 1e3);
    };
    let mut bench = None;
    // Spectra take long, and are made once.
    for _ in 0..rounds.min(3) {
        timed(&mut times[0], &mut || bench = Some(Bench::new(&scene, n, ground.tick)));
    }
    let mut bench = bench.expect("there is a round");
    for round in 0..=rounds {
        let tick = (ground.tick / INTERVAL + round as i64) * INTERVAL;
        let stages: [fn(&mut Bench, i64); 6] =
            [Bench::evolve, Bench::transform, Bench::assemble, Bench::normals, Bench::foam, Bench::encode];
        for (stage, times) in stages.into_iter().zip(&mut times[1..]) {
            timed(times, &mut || stage(&mut bench, tick));
        }
    }
    // The first round finds cold caches and no frames to predict from.
    for times in &mut times[1..] {
        times.remove(0);
    }
    StageRow { n, times: times.map(Times::of) }
}

impl Bench {
    fn new(scene: &Scene, n: usize, tick: i64) -> Self {
        let sea = Timeline::new(scene).at(tick);
        let (table, cascade) =
            (EvolveTable::new(&sea.cascades[0], sea.choppiness, sea.repeat), sea.cascades[0].cascade);
        let (class, codec) = (ErrorClass::Millimetre, Codec::Rans);
        let unit = |group| UnitEncoder::new(UnitName { cascade: cascade.index, level: 0, class, group, codec });
        Self {
            n,
            table,
            transform: Transform::new(n, cascade.half),
            workspace: Workspace::default(),
            heights: Amplitudes::default(),
            planes: vec![vec![0.0; n * n]; Field::ALL.len()],
            held: vec![HeldFoam::default(); n * n],
            encoders: SENT.map(unit).into(),
            sea,
        }
    }

    fn evolve(&mut self, tick: i64) {
        let half = self.sea.cascades[0].cascade.half;
        self.table.heights(turn_of_tick(tick, self.sea.repeat), half, &mut self.heights);
    }

    fn transform(&mut self, _tick: i64) {
        for packing in Packing::of(FIELDS) {
            let fields: Vec<Field> = packing.fields().iter().collect();
            let mut taken: Vec<Vec<f32>> =
                fields.iter().map(|field| std::mem::take(&mut self.planes[*field as usize])).collect();
            let mut planes = taken.iter_mut().map(Vec::as_mut_slice);
            let pair = [planes.next().unwrap_or_default(), planes.next().unwrap_or_default()];
            self.transform.run(packing, &self.table, &self.heights, &mut self.workspace, pair);
            for (field, plane) in fields.into_iter().zip(taken) {
                self.planes[field as usize] = plane;
            }
        }
    }

    fn assemble(&mut self, _tick: i64) {
        let mut jacobian = std::mem::take(&mut self.planes[Field::Jacobian as usize]);
        assemble::jacobian(self.strain(), &mut jacobian);
        self.planes[Field::Jacobian as usize] = jacobian;
    }

    fn normals(&mut self, _tick: i64) {
        let [mut x, mut z] =
            [Field::NormalX, Field::NormalZ].map(|field| std::mem::take(&mut self.planes[field as usize]));
        let slopes = [Field::SlopeX, Field::SlopeZ].map(|field| self.planes[field as usize].as_slice());
        assemble::displaced_slopes(false, slopes, self.strain(), [&mut x, &mut z]);
        self.planes[Field::NormalX as usize] = x;
        self.planes[Field::NormalZ as usize] = z;
    }

    fn strain(&self) -> [&[f32]; 3] {
        [Field::Dxx, Field::Dzz, Field::Dxz].map(|field| self.planes[field as usize].as_slice())
    }

    fn foam(&mut self, _tick: i64) {
        let work = FoamWork { restart: false, decay: 0.96, growth: 0.33, advance: true, breaks: true };
        let threshold = self.sea.cascades[0].foam_threshold as f32;
        let mut shown = std::mem::take(&mut self.planes[Field::Foam as usize]);
        foam::foam(&mut self.held, &self.planes[Field::Jacobian as usize], threshold, work, &mut shown);
        self.planes[Field::Foam as usize] = shown;
    }

    fn encode(&mut self, tick: i64) {
        let stamp = Stamp { tick, epoch: 1, sequence: 0, layout: 0 };
        for (encoder, group) in self.encoders.iter_mut().zip(SENT) {
            let planes: Vec<Plane> =
                fields_of(group).iter().map(|field| Plane::Samples(&self.planes[*field as usize])).collect();
            // Fields of a sea are finite.
            drop(encoder.take(self.n, &planes, stamp));
        }
    }
}
