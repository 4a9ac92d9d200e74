//! How far water is off: heights, displaced positions and normals of the same particles, beside those of the reference.

use serde::{Deserialize, Serialize};

use crate::plan::Field;

/// Where the whole surface is squeezed to less than this it counts as folded: below it no normal stands for the surface.
const FOLDED: f64 = 0.1;

/// One particle of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Particle {
    /// How far it is displaced (x, up, z), metres.
    pub moved: [f64; 3],
    /// Normal of the surface there, of any length.
    pub normal: [f64; 3],
}

/// Root mean squares and extremes over many particles; what was not measured is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Height, rms, as a share of the significant wave height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_rms: Option<f64>,
    /// Height, the largest, as a share of the significant wave height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_max: Option<f64>,
    /// Distance between displaced positions, rms, millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_mm: Option<f64>,
    /// Angle between normals, rms, degrees, where the surface does not fold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_deg: Option<f64>,
    /// The same, 99th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_p99_deg: Option<f64>,
    /// Foam, 0 to 1: rms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foam: Option<f64>,
    /// Share of the area that foam covers: how far off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foam_coverage: Option<f64>,
}

impl Particle {
    /// Of spectral fields, in the order of [`Field`], summed over all cascades: with the exact normal of the displaced
    /// surface.
    pub fn of(fields: &[f64; 11]) -> Self {
        let at = |field: Field| fields[field as usize];
        let (hx, hz) = (at(Field::SlopeX), at(Field::SlopeZ));
        let (dxx, dzz, dxz) = (at(Field::Dxx), at(Field::Dzz), at(Field::Dxz));
        Self {
            moved: [at(Field::Dx), at(Field::Height), at(Field::Dz)],
            normal: [
                -(hx * (1.0 + dzz) - hz * dxz),
                (1.0 + dxx) * (1.0 + dzz) - dxz * dxz,
                -(hz * (1.0 + dxx) - hx * dxz),
            ],
        }
    }
}

impl Errors {
    /// Of particles beside what they should be, in a sea of this significant wave height, metres.
    pub fn of(made: &[Particle], truth: &[Particle], hs_m: f64) -> Self {
        let pairs = || made.iter().zip(truth);
        let off = |(made, truth): (&Particle, &Particle), axis: usize| made.moved[axis] - truth.moved[axis];
        let heights = || pairs().map(|pair| off(pair, 1));
        let distances = pairs().map(|pair| (0..3).map(|axis| off(pair, axis).powi(2)).sum::<f64>());
        let smooth = pairs().filter(|(_, truth)| truth.normal[1] >= FOLDED);
        let mut angles: Vec<f64> = smooth.map(|(made, truth)| angle(made.normal, truth.normal)).collect();
        angles.sort_by(f64::total_cmp);
        let p99 = angles.get(angles.len() * 99 / 100).copied();
        let scale = 1.0 / hs_m.max(f64::MIN_POSITIVE);
        Self {
            height_rms: Some(rms(heights()) * scale),
            height_max: Some(heights().fold(0.0, |most: f64, error| most.max(error.abs())) * scale),
            position_mm: Some(mean(distances).sqrt() * 1e3),
            normal_deg: p99.map(|_| rms(angles.iter().copied())),
            normal_p99_deg: p99,
            foam: None,
            foam_coverage: None,
        }
    }
}

/// Angle between two directions, degrees.
pub fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    cross.iter().map(|v| v * v).sum::<f64>().sqrt().atan2(dot).to_degrees()
}

/// Root mean square; 0 of nothing.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    mean(values.map(|value| value * value)).sqrt()
}

/// Mean; 0 of nothing.
pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    for value in values {
        (sum, count) = (sum + value, count + 1);
    }
    sum / count.max(1) as f64
}
