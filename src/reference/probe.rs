//! The water above a fixed point of the world: the particle that has moved there.

use serde::Serialize;

use super::direct::at;
use crate::plan::Field;
use crate::sea::{Displacement, Sea, rest_position};

/// What a probe finds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Probe {
    /// World position asked for, metres.
    pub x: f64,
    /// World position asked for, metres.
    pub z: f64,
    /// Height of the water there, metres.
    pub height: f64,
    /// Unit normal of the surface.
    pub normal: [f64; 3],
    /// Velocity of the water there, m/s.
    pub velocity: [f64; 3],
    /// Determinant of the horizontal mapping; 0 and below: the surface folds and other sheets may lie above.
    pub jacobian: f64,
    /// Whether the surface folds here, or no particle was found that has come here.
    pub folded: bool,
    /// Where the particle rests, metres.
    pub rest: [f64; 2],
    /// Distance between the point asked for and the one found, metres.
    pub residual: f64,
    /// Iterations that took.
    pub iterations: u32,
}

/// Water above the world's (x, z) at a tick: x0 with x0 + D(x0) = x.
pub fn probe(sea: &Sea, tick: i64, x: f64, z: f64) -> Probe {
    let point = |[x, z]: [f64; 2]| at(sea, &sea.cascades, tick, x, z);
    let found = rest_position([x, z], |rest| {
        let point = point(rest);
        let field = |field: Field| point.fields[field as usize];
        let (dxx, dzz, dxz) = (field(Field::Dxx), field(Field::Dzz), field(Field::Dxz));
        Displacement { dx: field(Field::Dx), dz: field(Field::Dz), dxx, dzz, dxz, dzx: dxz }
    });
    let point = point(found.at);
    let field = |field: Field| point.fields[field as usize];
    let (dxx, dzz, dxz) = (field(Field::Dxx), field(Field::Dzz), field(Field::Dxz));
    let (hx, hz) = (field(Field::SlopeX), field(Field::SlopeZ));
    let normal = [-(hx * (1.0 + dzz) - hz * dxz), found.jacobian, -(hz * (1.0 + dxx) - hx * dxz)];
    let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
    Probe {
        x,
        z,
        height: field(Field::Height),
        normal: normal.map(|v| v / length.max(f64::MIN_POSITIVE)),
        velocity: [Field::VelocityX, Field::VelocityY, Field::VelocityZ].map(field),
        jacobian: found.jacobian,
        folded: found.folded(),
        rest: found.at,
        residual: found.residual,
        iterations: found.iterations,
    }
}
