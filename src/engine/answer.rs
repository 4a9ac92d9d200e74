//! The water at a point of the world, for buoyancy and game servers: from the grids of a surface, or from the modes.

use serde::Serialize;

use super::direct::DirectSum;
use super::sample::Sampler;
use crate::backend::Surface;
use crate::pass::trochoid::Trochoids;
use crate::plan::{Field, FieldSet};
use crate::sea::{Displacement, RestPosition, Timeline, rest_position, rest_position_within};

/// Most steps of a search on a sum of modes, each of which is looked at in every step.
const DIRECT_STEPS: u32 = 30;
/// Most times that the modes are summed for a point: before the first step, in each, and twice for what is told.
pub(super) const DIRECT_LOOKS: usize = DIRECT_STEPS as usize + 3;

/// What is wanted at a point beside the height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProbeFields {
    /// Unit normal of the displaced surface.
    pub normal: bool,
    /// Velocity of the water.
    pub velocity: bool,
    /// Determinant of the horizontal mapping.
    pub jacobian: bool,
}

/// The water at a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProbeAnswer {
    /// World position asked for, metres.
    pub x: f64,
    /// World position asked for, metres.
    pub z: f64,
    /// Height of the water there, metres.
    pub height: f64,
    /// Unit normal of the surface, where it was wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// Velocity of the water, m/s, where it was wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Determinant of the horizontal mapping, where it was wanted; 0 and below: the surface folds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jacobian: Option<f64>,
    /// Whether the surface folds here, so that other sheets may lie above, or no particle was found that has come here.
    pub folded: bool,
    /// Where the particle rests, metres.
    pub rest: [f64; 2],
    /// Distance between the point asked for and the one found, metres.
    pub residual: f64,
    /// Steps that took.
    pub iterations: u32,
}

impl ProbeFields {
    /// Height alone.
    pub const HEIGHT: Self = Self { normal: false, velocity: false, jacobian: false };
    /// All there is.
    pub const ALL: Self = Self { normal: true, velocity: true, jacobian: true };

    /// Fields of a surface that an answer is made of.
    pub(super) fn needed(self, choppiness: f64) -> FieldSet {
        // Without choppiness nothing moves sideways, and nothing need be made of that.
        let still = if choppiness == 0.0 { FieldSet::SIDEWAYS } else { FieldSet::NONE };
        self.shown().union(FieldSet::of(&[Field::Dx, Field::Dz])).difference(still)
    }

    /// Those that are read where the particle rests.
    fn shown(self) -> FieldSet {
        let of = |wanted: bool, fields: FieldSet| if wanted { fields } else { FieldSet::NONE };
        FieldSet::of(&[Field::Height])
            .union(of(self.normal, FieldSet::of(&[Field::SlopeX, Field::SlopeZ])))
            .union(of(self.normal || self.jacobian, FieldSet::DERIVATIVES))
            .union(of(self.velocity, FieldSet::VELOCITY))
    }
}

/// What is read of the particle that has come to a point.
#[derive(Clone, Copy, Default)]
struct Particle {
    height: f64,
    slope: [f64; 2],
    velocity: [f64; 3],
    strain: Displacement,
}

impl Particle {
    fn answer(&self, [x, z]: [f64; 2], found: &RestPosition, wanted: ProbeFields) -> ProbeAnswer {
        let strained = wanted.normal || wanted.jacobian;
        ProbeAnswer {
            x,
            z,
            height: self.height,
            normal: wanted.normal.then(|| self.normal()),
            velocity: wanted.velocity.then_some(self.velocity),
            jacobian: wanted.jacobian.then(|| self.strain.jacobian()),
            folded: found.folded() || strained && self.strain.jacobian() <= 0.0,
            rest: found.at,
            residual: found.residual,
            iterations: found.iterations,
        }
    }

    /// Normal of the displaced surface: the cross product of its two tangents.
    fn normal(&self) -> [f64; 3] {
        let ([hx, hz], Displacement { dxx, dzz, dxz, .. }) = (self.slope, self.strain);
        let across = [hz * dxz - hx * (1.0 + dzz), self.strain.jacobian(), hx * dxz - hz * (1.0 + dxx)];
        let length = across.iter().map(|v| v * v).sum::<f64>().sqrt();
        // A point in which the surface shrinks to nothing has no normal; up is none that misleads.
        if length > 0.0 { across.map(|v| v / length) } else { [0.0, 1.0, 0.0] }
    }
}

/// Answers from the grids of a surface whose patches have these sides, metres, each after so many steps of its search at
/// most; `None`: as many as help.
pub(super) fn from_grids(
    surface: &Surface,
    patches_m: impl IntoIterator<Item = f64>,
    points: &[[f64; 2]],
    wanted: ProbeFields,
    most: Option<u32>,
) -> Vec<ProbeAnswer> {
    let sampler = Sampler::new(surface, patches_m);
    let displacement = |rest| sampler.displacement(rest);
    let find = |point: &[f64; 2]| match most {
        None => rest_position(*point, displacement),
        Some(most) => rest_position_within(most, *point, displacement),
    };
    let found: Vec<RestPosition> = points.iter().map(find).collect();
    let rests: Vec<[f64; 2]> = found.iter().map(|found| found.at).collect();
    let read = sampler.fields(&rests, wanted.shown());
    let particle = |i: usize| {
        let at = |field: Field| read[field as usize].get(i).map_or(0.0, |value| f64::from(*value));
        let (dxx, dzz, dxz) = (at(Field::Dxx), at(Field::Dzz), at(Field::Dxz));
        Particle {
            height: at(Field::Height),
            slope: [Field::SlopeX, Field::SlopeZ].map(at),
            velocity: [Field::VelocityX, Field::VelocityY, Field::VelocityZ].map(at),
            strain: Displacement { dxx, dzz, dxz, dzx: dxz, ..Displacement::default() },
        }
    };
    let answer = |(i, (point, found)): (usize, (&[f64; 2], &RestPosition))| particle(i).answer(*point, found, wanted);
    points.iter().zip(&found).enumerate().map(answer).collect()
}

/// The answer for one point from a sum of modes.
pub(super) fn from_modes(sum: &DirectSum, point: [f64; 2], wanted: ProbeFields) -> ProbeAnswer {
    let found = rest_position_within(DIRECT_STEPS, point, |rest| sum.displacement(rest));
    let motion = sum.motion(found.at);
    let particle = Particle {
        height: motion.height,
        slope: motion.slope,
        velocity: motion.velocity,
        strain: sum.displacement(found.at),
    };
    particle.answer(point, &found, wanted)
}

/// The trochoids of the sea that was evaluated last, made when somebody asks for them.
#[derive(Default)]
pub(super) struct Evaluated(Option<(i64, Vec<Trochoids>)>);

impl Evaluated {
    /// Those of a tick's sea.
    pub fn at(&mut self, timeline: &Timeline, tick: i64) -> &[Trochoids] {
        let held = self.0.take().filter(|(at, _)| timeline.same_sea(*at, tick));
        let made = held.unwrap_or_else(|| {
            let sea = timeline.at(tick);
            (tick, sea.cascades.iter().map(|modes| Trochoids::new(modes, &sea)).collect())
        });
        &self.0.insert(made).1
    }

    /// Forgets them: the timeline is another, or nobody asks any more.
    pub fn forget(&mut self) {
        self.0 = None;
    }
}

/// Answers from trochoids: heights over the world, which nothing carries sideways.
pub(super) fn from_trochoids(
    cascades: &[Trochoids],
    tick: i64,
    points: &[[f64; 2]],
    wanted: ProbeFields,
) -> Vec<ProbeAnswer> {
    let places: Vec<(f64, f64)> = points.iter().map(|[x, z]| (*x, *z)).collect();
    let mut particles = vec![Particle::default(); points.len()];
    for cascade in cascades {
        for (sum, fields) in particles.iter_mut().zip(cascade.points(tick, &places, 0.0)) {
            let at = |field: Field| f64::from(fields[field as usize]);
            sum.height += at(Field::Height);
            sum.slope = [sum.slope[0] + at(Field::SlopeX), sum.slope[1] + at(Field::SlopeZ)];
            let velocity = [Field::VelocityX, Field::VelocityY, Field::VelocityZ].map(at);
            sum.velocity.iter_mut().zip(velocity).for_each(|(sum, more)| *sum += more);
        }
    }
    let here = |at: [f64; 2]| RestPosition { at, residual: 0.0, iterations: 0, arrived: true, jacobian: 1.0 };
    particles.iter().zip(points).map(|(particle, point)| particle.answer(*point, &here(*point), wanted)).collect()
}
