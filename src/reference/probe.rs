//! The water above a fixed point of the world: the particle that has moved there, found by Newton's method.

use serde::Serialize;

use super::direct::at;
use crate::plan::Field;
use crate::sea::Sea;

/// Residual that counts as arrived, metres.
const ARRIVED_M: f64 = 1e-4;
const MAX_ITERATIONS: u32 = 100;

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
    /// Whether the surface folds here.
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
    let (mut x0, mut z0) = (x, z);
    let mut best: Option<Probe> = None;
    let mut iterations = 0;
    loop {
        let point = at(sea, &sea.cascades, tick, x0, z0);
        let field = |field: Field| point.fields[field as usize];
        let (dxx, dzz, dxz) = (field(Field::Dxx), field(Field::Dzz), field(Field::Dxz));
        let jacobian = (1.0 + dxx) * (1.0 + dzz) - dxz * dxz;
        let (rx, rz) = (x - x0 - field(Field::Dx), z - z0 - field(Field::Dz));
        let residual = libm::hypot(rx, rz);
        if best.is_none_or(|best| residual < best.residual) {
            let (hx, hz) = (field(Field::SlopeX), field(Field::SlopeZ));
            let normal = [-(hx * (1.0 + dzz) - hz * dxz), jacobian, -(hz * (1.0 + dxx) - hx * dxz)];
            let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
            best = Some(Probe {
                x,
                z,
                height: field(Field::Height),
                normal: normal.map(|v| v / length.max(f64::MIN_POSITIVE)),
                velocity: [Field::VelocityX, Field::VelocityY, Field::VelocityZ].map(field),
                jacobian,
                folded: jacobian <= 0.0,
                rest: [x0, z0],
                residual,
                iterations,
            });
        }
        if residual <= ARRIVED_M || iterations == MAX_ITERATIONS {
            return Probe { iterations, ..best.expect("the first turn sets it") };
        }
        // Newton where the mapping is well behaved, else the plain step, which contracts while slopes are mild; both
        // shortened more and more, so that neither can circle for ever.
        let shorten = if iterations < 20 { 1.0 } else { 20.0 / f64::from(iterations) * 0.5 };
        let (sx, sz) = match jacobian > 0.2 {
            true => (((1.0 + dzz) * rx - dxz * rz) / jacobian, ((1.0 + dxx) * rz - dxz * rx) / jacobian),
            false => (rx, rz),
        };
        (x0, z0) = (x0 + shorten * sx, z0 + shorten * sz);
        iterations += 1;
    }
}
