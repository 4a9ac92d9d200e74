//! How many steps the search for the particle above a point of the world may take.

use super::axis::{Draft, axis};
use super::errors::{Errors, Particle};
use super::ground::{Ground, LOOKED_AT, Made, between};
use super::report::{Axis, Cost, Measure};
use crate::engine::Sampler;
use crate::plan::FieldSet;
use crate::reference;
use crate::sea::rest_position_within;

/// Most steps that are compared.
pub const MOST: u32 = 8;

/// Steps of the search on the CPU's grids, beside the reference's own search over all modes.
pub fn inverse(ground: &Ground) -> Axis {
    // The reference sums all modes at each point, again and again.
    let side = if ground.quick { 6 } else { 14 };
    let [xs, zs] = [0, 1].map(|axis| ground.spots[axis][..side].to_vec());
    let targets: Vec<[f64; 2]> = zs.iter().flat_map(|z| xs.iter().map(|x| [*x, *z])).collect();
    let probes: Vec<reference::Probe> = {
        use rayon::prelude::*;
        targets.par_iter().map(|[x, z]| reference::probe(&ground.sea, ground.tick, *x, *z)).collect()
    };
    // Where the surface folds there is no one particle to be found.
    let found: Vec<bool> = probes.iter().map(|probe| !probe.folded).collect();
    let kept = |i: usize| found[i];
    let truth: Vec<Particle> = probes
        .iter()
        .filter(|probe| !probe.folded)
        .map(|probe| Particle { moved: [probe.x, probe.height, probe.z], normal: probe.normal })
        .collect();
    let mut made = Made::new(ground.sea.clone(), LOOKED_AT, &ground.scene.effects);
    let patches: Vec<f64> = ground.sea.cascades.iter().map(|modes| modes.cascade.patch_m).collect();
    let surface = made.step(ground.tick);
    let search = |most: u32, target: [f64; 2], sampler: &Sampler| {
        rest_position_within(most, target, |at| sampler.displacement(at)).at
    };
    let draft = |most: u32| {
        let sampler = Sampler::new(surface, patches.iter().copied());
        let particle = |(i, target): (usize, &[f64; 2])| {
            let [x, z] = search(most, *target, &sampler);
            let fields = between(surface, &patches, &[vec![x], vec![z]])[0];
            let Particle { moved: [dx, height, dz], normal } = Particle::of(&fields);
            kept(i).then_some(Particle { moved: [x + dx, height, z + dz], normal })
        };
        let made: Vec<Particle> = targets.iter().enumerate().filter_map(particle).collect();
        let (spots, patches) = (&ground.spots, &patches);
        let work = move |_: i64| {
            let sampler = Sampler::new(surface, patches.iter().copied());
            let of = |i: usize| {
                search(most, [spots[0][i % spots[0].len()], spots[1][i / spots[0].len() % spots[1].len()]], &sampler)
            };
            let at: Vec<[f64; 2]> = (0..1000).map(of).collect();
            drop(sampler.fields(&at, FieldSet::SPECTRAL));
        };
        Draft::new(most.to_string(), Errors::of(&made, &truth, ground.hs_m)).costing(work)
    };
    let about = "Steps that the search for the particle above a point may take, on the grids of the CPU; 0 takes the particle \
                 that rests there. Where the surface folds it is left out. The time is that of 1,000 points.";
    axis(ground, "inverse displacement", about, (Measure::Position, Cost::Time), (0..=MOST).map(draft).collect())
}
