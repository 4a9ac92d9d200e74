//! Ways of normals: from sums of exact derivatives down to differences of neighbouring samples.

use super::axis::{Draft, axis};
use super::errors::{Errors, Particle};
use super::ground::{Ground, Made, fields_on_grid, on_grid, particles};
use super::report::{Axis, Cost, Measure};
use crate::plan::{Field, FieldSet, fields_of};
use crate::scene::{Effects, Normals};
use crate::sea::Sea;
use crate::wire::Group;

/// Every way, exact first.
pub const WAYS: [Normals; 5] =
    [Normals::Exact, Normals::Diagonal, Normals::DisplacedSlopes, Normals::CentralDifference, Normals::Sobel];

/// Every way, at the samples of the grids.
pub fn normals(ground: &Ground) -> Axis {
    let exact = fields_on_grid(&ground.sea, ground.tick, &ground.spots);
    let truth = particles(&exact);
    let draft = |way: &Normals| {
        let effects = Effects { normals: *way, ..ground.scene.effects };
        let streamed = channels(*way);
        let fields = streamed.union(FieldSet::of(fields_of(Group::Displacement)));
        let mut made = Made::new(ground.sea.clone(), fields, &effects);
        let errors = of_way(&mut made, *way, ground.tick, &ground.spots, &truth);
        let (memory, tick) = (made.memory_bytes(), ground.tick);
        let step = move |round: i64| {
            made.step(tick + round * 240);
        };
        Draft::new(format!("{}, {} channels", way.name(), streamed.len()), errors).holding(memory).costing(step)
    };
    let about = "How normals are made, of all cascades at their samples. The time is that of displacement and what the way \
                 needs beside it; a channel more is also bytes more.";
    axis(ground, "normals", about, (Measure::Normal, Cost::Time), WAYS.iter().map(draft).collect())
}

/// Channels that a way streams.
pub fn channels(way: Normals) -> FieldSet {
    let groups = match way {
        Normals::None => [].as_slice(),
        Normals::Exact => &[Group::Slopes, Group::Derivatives],
        Normals::Diagonal => &[Group::Slopes, Group::Stretch],
        _ => &[Group::Normals],
    };
    groups.iter().fold(FieldSet::NONE, |set, group| set.union(FieldSet::of(fields_of(*group))))
}

/// Errors of the normals alone that clients make of what a way streams, samples of all cascades added up.
pub fn of_way(made: &mut Made, way: Normals, tick: i64, spots: &[Vec<f64>; 2], truth: &[Particle]) -> Errors {
    let sea: Sea = made.sea().clone();
    let surface = made.step(tick);
    let mut sums = vec![[0.0; Field::ALL.len()]; truth.len()];
    for (surface, modes) in surface.cascades.iter().zip(&sea.cascades) {
        let [xs, zs] = on_grid(modes, spots);
        for (i, sums) in sums.iter_mut().enumerate() {
            let (x, z) = (xs[i % xs.len()], zs[i / xs.len()]);
            for field in channels(way).iter() {
                sums[field as usize] += surface.plane(field).map_or(0.0, |plane| f64::from(plane[z * surface.n + x]));
            }
        }
    }
    let normal = |sums: &[f64; Field::ALL.len()]| {
        let at = |field: Field| sums[field as usize];
        match way {
            Normals::Exact => Particle::of(sums.first_chunk().expect("spectral fields stand first")).normal,
            Normals::Diagonal => {
                [-at(Field::SlopeX) / (1.0 + at(Field::Dxx)), 1.0, -at(Field::SlopeZ) / (1.0 + at(Field::Dzz))]
            }
            _ => [-at(Field::NormalX), 1.0, -at(Field::NormalZ)],
        }
    };
    let made: Vec<Particle> =
        sums.iter().zip(truth).map(|(sums, truth)| Particle { normal: normal(sums), ..*truth }).collect();
    let Errors { normal_deg, normal_p99_deg, .. } = Errors::of(&made, truth, 1.0);
    Errors { normal_deg, normal_p99_deg, ..Errors::default() }
}
