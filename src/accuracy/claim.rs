//! What a stream errs, unit by unit: what a client has after decoding, beside the reference at the same samples.

use serde::Serialize;

use super::ground::with_modes;
use super::received::received;
use crate::backend::{Backend, BackendError, Cpu};
use crate::plan::{CascadePlan, Field, FieldSet, Plan, fields_of, levels_of};
use crate::reference;
use crate::scene::Model;
use crate::sea::{Sea, Timeline};
use crate::wire::{Group, UnitName};

/// Most samples a side that are looked at; of finer grids every second one, or fourth, and so on.
const MOST: usize = 256;
/// As clients and the fast path have it: where the surface is squeezed to less, it counts as this.
const LEAST_JACOBIAN: f64 = 0.1;

/// One channel of one unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelClaim {
    /// The unit.
    pub unit: UnitName,
    /// The channel's name.
    pub channel: &'static str,
    /// Largest error of a sample beside the field it was made of, which is guaranteed.
    pub bound: f64,
    /// Root mean square of the errors beside the reference; `None` where that takes too long: of foam, and of trochoids.
    pub rms: Option<f64>,
    /// The largest of them.
    pub max: Option<f64>,
}

/// Every channel of these units at a tick. Units of cascades that are then no part of the sea are left out.
///
/// # Errors
/// [`BackendError`] of the CPU, which makes what is compared.
pub fn claims(timeline: &Timeline, tick: i64, units: &[UnitName]) -> Result<Vec<ChannelClaim>, BackendError> {
    let (sea, scene) = (timeline.at(tick), timeline.scene());
    let mut cpu = Cpu::new(None);
    cpu.load(&sea)?;
    let here = |index: u8| units.iter().filter(move |unit| unit.cascade == index);
    let plan = |life: crate::sea::Life| {
        let known = here(life.cascade.index).filter(|unit| unit.level < life.cascade.levels());
        CascadePlan::new(levels_of(known), None, &scene.effects).by(scene.model)
    };
    let surface = cpu.step(tick, &Plan { cascades: timeline.lives().map(plan).collect() })?;
    let mut claims = Vec::new();
    for unit in units {
        let Some((place, life)) = timeline.life_of(unit.cascade).filter(|(_, life)| life.contains(tick)) else {
            continue;
        };
        if unit.level >= life.cascade.levels() {
            continue;
        }
        let known = unit.group != Group::Foam && scene.model == Model::Fft;
        let errors = if known { errors(&sea, place, tick, *unit, surface) } else { Vec::new() };
        for (channel, name) in unit.group.channels().iter().enumerate() {
            let bound = f64::from(unit.class.max_error(unit.group));
            let [rms, max] = [0, 1].map(|which| errors.get(channel).map(|errors: &[f64; 2]| errors[which]));
            claims.push(ChannelClaim { unit: *unit, channel: name, bound, rms, max });
        }
    }
    Ok(claims)
}

/// Root mean square and largest error of every channel of a unit.
fn errors(sea: &Sea, place: usize, tick: i64, unit: UnitName, surface: &crate::backend::Surface) -> Vec<[f64; 2]> {
    let Some(planes) = received(&surface.cascades[place], unit) else { return Vec::new() };
    // The waves that the level can hold.
    let (n, half) = sea.cascades[place].cascade.level(unit.level);
    let one = Sea { cascades: vec![sea.cascades[place].clone()], ..sea.clone() };
    let one = with_modes(&one, |_| (n, half));
    let stride = n.div_ceil(MOST);
    let samples: Vec<usize> = (0..n).step_by(stride).collect();
    let spacing = one.cascades[0].cascade.patch_m / n as f64;
    let along: Vec<f64> = samples.iter().map(|sample| *sample as f64 * spacing).collect();
    let truth = reference::lattice(&one, 0, tick, &along, &along);
    let channel = |(field, plane): (&Field, &Vec<f32>)| {
        let (mut square, mut most) = (0.0, 0.0_f64);
        for (i, truth) in truth.iter().enumerate() {
            let (x, z) = (samples[i % samples.len()], samples[i / samples.len()]);
            let error = (f64::from(plane[z * n + x]) - value(*field, truth)).abs();
            (square, most) = (square + error * error, most.max(error));
        }
        [(square / truth.len() as f64).sqrt(), most]
    };
    fields_of(unit.group).iter().zip(&planes).map(channel).collect()
}

/// A field of one cascade out of the spectral ones.
fn value(field: Field, spectral: &[f64; 11]) -> f64 {
    let at = |field: Field| spectral[field as usize];
    if FieldSet::SPECTRAL.contains(field) {
        return at(field);
    }
    let (dxx, dzz, dxz) = (at(Field::Dxx), at(Field::Dzz), at(Field::Dxz));
    let jacobian = (1.0 + dxx) * (1.0 + dzz) - dxz * dxz;
    let seen = |own: f64, other: f64, along: f64| (own * (1.0 + along) - other * dxz) / jacobian.max(LEAST_JACOBIAN);
    match field {
        Field::Jacobian => jacobian,
        Field::Eigenvalue => 1.0 + 0.5 * (dxx + dzz) - libm::hypot(0.5 * (dxx - dzz), dxz),
        Field::NormalX => seen(at(Field::SlopeX), at(Field::SlopeZ), dzz),
        Field::NormalZ => seen(at(Field::SlopeZ), at(Field::SlopeX), dxx),
        _ => 0.0,
    }
}
