//! The channels of a unit: out of a surface, and into its frames.

use crate::backend::CascadeSurface;
use crate::pass::quantise::quantiser_step;
use crate::plan::{Counted, fields_of};
use crate::tile::{EncodeError, Plane, SentFrame, Stamp, UnitEncoder};
use crate::wire::{Group, UnitName};

/// The channels of a unit as they go on the wire.
pub(super) fn counted(unit: UnitName, foam_left: f32) -> impl Iterator<Item = Counted> {
    let (level, step) = (unit.level, quantiser_step(unit.class, unit.group));
    let share = if unit.group == Group::Foam { foam_left } else { 1.0 };
    fields_of(unit.group).iter().map(move |field| Counted { level, field: *field, step, share })
}

/// Nothing where a field of the unit was not made (foam that is not warm).
pub(super) fn encode_unit(
    cascade: Option<&CascadeSurface>,
    unit: UnitName,
    foam_left: f32,
    stamp: Stamp,
    encoder: &mut UnitEncoder,
) -> Result<Vec<SentFrame>, EncodeError> {
    let Some(cascade) = cascade else { return Ok(Vec::new()) };
    let counts: Option<Vec<Plane>> = counted(unit, foam_left)
        .map(|counted| cascade.counts(counted).map(|(counts, found)| Plane::Counts(counts, found)))
        .collect();
    if let Some(counts) = counts.filter(|_| !unit.codec.is_float()) {
        return encoder.take(cascade.n, &counts, stamp);
    }
    // Foam is made on the full grid, and averaged for the others.
    let level = if unit.group == Group::Foam { 0 } else { unit.level };
    let planes: Option<Vec<&[f32]>> =
        fields_of(unit.group).iter().map(|field| cascade.plane_at(level, *field)).collect();
    let Some(planes) = planes else { return Ok(Vec::new()) };
    let mut samples = |planes: &[&[f32]]| {
        encoder.take(cascade.n, &planes.iter().map(|plane| Plane::Samples(plane)).collect::<Vec<_>>(), stamp)
    };
    if unit.group != Group::Foam || foam_left >= 1.0 {
        return samples(&planes);
    }
    let fading: Vec<Vec<f32>> = planes.iter().map(|p| p.iter().map(|foam| foam * foam_left).collect()).collect();
    samples(&fading.iter().map(Vec::as_slice).collect::<Vec<_>>())
}
