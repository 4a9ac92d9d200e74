//! How far off a scene is at a setting: what the layout leaves out, and what is lost between its samples.

use super::Setting;
use super::waves::{Missing, Waves};
use crate::accuracy::errors::{Errors, Particle};
use crate::backend::{Backend, Cpu};
use crate::engine::Sampler;
use crate::pass::trochoid::Trochoids;
use crate::plan::{CascadePlan, Field, FieldSet, Plan};
use crate::reference::lattice;
use crate::scene::{Model, Normals, Scene};
use crate::sea::{Sea, Timeline};

/// Particles are looked at at so many places along either axis of the first patch.
const PLACES: usize = 24;
/// Steps from place to place, as shares of the patch: the two most irrational numbers, so that places lie evenly and every
/// other patch is met at phases of all kinds.
const STEPS: [f64; 2] = [0.618_033_988_749_894_9, 0.414_213_562_373_095_1];
/// What a particle's place and normal are made of.
const READ: FieldSet = FieldSet::of(&[
    Field::Height,
    Field::Dx,
    Field::Dz,
    Field::SlopeX,
    Field::SlopeZ,
    Field::Dxx,
    Field::Dzz,
    Field::Dxz,
]);

/// How far off a scene is at a setting, at a tick: waves that the layout leaves out, and what a client that reads between
/// the samples of its grids makes of those that it holds, as if independent. The same on every run.
pub fn errors(scene: &Scene, setting: &Setting, tick: i64) -> Errors {
    // Foam moves no particle.
    errors_at(&Timeline::uncalibrated(&setting.of(scene)), setting.finest_m, tick)
}

/// The same of a timeline as it stands, where slopes of waves down to `finest_m` metres are wanted.
pub fn errors_at(timeline: &Timeline, finest_m: f64, tick: i64) -> Errors {
    let (left_out, between) = (left_out(timeline, finest_m, tick), between(timeline, tick));
    let both = |error: fn(&Errors) -> Option<f64>| match (error(&left_out), error(&between)) {
        (Some(a), Some(b)) => Some(a.hypot(b)),
        (a, b) => a.or(b),
    };
    let seen = timeline.scene().effects.normals != Normals::None;
    Errors {
        height_rms: both(|errors| errors.height_rms),
        position_mm: both(|errors| errors.position_mm),
        normal_deg: both(|errors| errors.normal_deg).filter(|_| seen),
        normal_p99_deg: both(|errors| errors.normal_p99_deg).filter(|_| seen),
        ..Errors::default()
    }
}

/// What waves would add that the layout doesn't hold: energy of any length, slopes down to the finest wanted.
fn left_out(timeline: &Timeline, finest_m: f64, tick: i64) -> Errors {
    let waves = Waves::new(timeline.state_at(tick));
    let Missing { m0, slope } = waves.left_out(timeline.layout(), finest_m);
    let chop = timeline.scene().effects.choppiness;
    // Slopes of many waves along two axes: their length has Rayleigh's distribution.
    let p99 = slope * 100_f64.ln();
    Errors {
        height_rms: Some(if m0 > 0.0 { 0.25 * (m0 / waves.m0()).sqrt() } else { 0.0 }),
        position_mm: Some((m0 * (1.0 + chop * chop)).sqrt() * 1e3),
        normal_deg: Some(slope.sqrt().atan().to_degrees()),
        normal_p99_deg: Some(p99.sqrt().atan().to_degrees()),
        ..Errors::default()
    }
}

/// Particles as they are read bicubically from the CPU's grids, beside those of the layout's own waves.
fn between(timeline: &Timeline, tick: i64) -> Errors {
    let (scene, sea) = (timeline.scene(), timeline.at(tick));
    let patches: Vec<f64> = sea.cascades.iter().map(|modes| modes.cascade.patch_m).collect();
    let along = |step: f64| (0..PLACES).map(|i| patches[0] * (step * (i as f64 + 0.5)).fract()).collect::<Vec<f64>>();
    let [xs, zs] = STEPS.map(along);
    let truth: Vec<Particle> = own(&sea, tick, &xs, &zs).iter().map(Particle::of).collect();
    let mut cpu = Cpu::new(None);
    let plan = CascadePlan::new([(0, READ)], None, &scene.effects).by(scene.model);
    let plan = Plan { cascades: vec![plan; patches.len()] };
    let made = cpu.load(&sea).and_then(|()| cpu.step(tick, &plan));
    // The CPU refuses no plan that is made for its sea.
    let Ok(surface) = made else { return Errors::default() };
    let places: Vec<[f64; 2]> = zs.iter().flat_map(|z| xs.iter().map(move |x| [*x, *z])).collect();
    let fields = Sampler::new(surface, patches.iter().copied()).fields(&places, READ);
    let read = |i: usize| std::array::from_fn(|field| fields[field].get(i).map_or(0.0, |value| f64::from(*value)));
    let made: Vec<Particle> = (0..places.len()).map(|i| Particle::of(&read(i))).collect();
    Errors::of(&made, &truth, timeline.wanted_hs_at(tick))
}

/// Spectral fields of the layout's own waves, all cascades summed, of the particles that rest at every pair of `xs` and
/// `zs`: in f64 by the reference, or of trochoids, which are evaluated where they are asked for, by themselves.
fn own(sea: &Sea, tick: i64, xs: &[f64], zs: &[f64]) -> Vec<[f64; 11]> {
    let places: Vec<(f64, f64)> = zs.iter().flat_map(|z| xs.iter().map(move |x| (*x, *z))).collect();
    let mut sums = vec![[0.0; 11]; places.len()];
    for (index, modes) in sea.cascades.iter().enumerate() {
        let fields = match sea.model {
            Model::Fft => lattice(sea, index, tick, xs, zs),
            Model::Trochoid(_) => {
                let at = |fields: [f32; 16]| std::array::from_fn(|field| f64::from(fields[field]));
                Trochoids::new(modes, sea).points(tick, &places, 0.0).into_iter().map(at).collect()
            }
        };
        for (sum, own) in sums.iter_mut().zip(fields) {
            sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
    }
    sums
}
