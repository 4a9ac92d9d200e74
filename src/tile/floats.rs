//! Payloads of floats as they were computed, for who studies them: 32 bits, or rounded to 16.

use half::f16;

use super::counts::EncodeError;
use super::level::{Tile, averages, row_of};
use crate::wire::{Codec, Group, UnitName};

/// Largest relative error of a 16-bit float, and its absolute one where numbers are small.
const HALF_RELATIVE: f32 = 1.0 / 2048.0;
const HALF_SMALLEST: f32 = 1.0 / (1 << 25) as f32;

/// The payload of a tile, and the largest error of each channel.
///
/// # Errors
/// [`EncodeError::NotFinite`]; a number beyond 16-bit floats counts as infinite.
pub fn float_payload(
    unit: UnitName,
    n: usize,
    planes: &[&[f32]],
    tile: Tile,
) -> Result<(Vec<u8>, [f32; 3]), EncodeError> {
    let mut payload = Vec::new();
    let mut errors = [0.0; 3];
    let (stride, level_n) = (1 << unit.level, n >> unit.level);
    let mut samples = Vec::with_capacity(tile.side);
    for ((plane, channel), error) in planes.iter().zip(unit.group.channels()).zip(&mut errors) {
        let mut largest = 0.0f32;
        for row in 0..tile.side {
            samples.clear();
            match (unit.group, stride) {
                (Group::Foam, 2..) => samples.extend(averages(plane, n, stride, tile, row)),
                _ => samples.extend_from_slice(row_of(plane, level_n, tile, row)),
            }
            let most = if unit.codec == Codec::F16 { f16::MAX.to_f32() } else { f32::MAX };
            for sample in &samples {
                // A NaN is not below anything.
                if !matches!(sample.abs().partial_cmp(&most), Some(order) if order.is_le()) {
                    return Err(EncodeError::NotFinite { channel });
                }
                largest = largest.max(sample.abs());
            }
            if unit.codec == Codec::F16 {
                payload.extend(samples.iter().flat_map(|sample| f16::from_f32(*sample).to_le_bytes()));
            } else {
                payload.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
            }
        }
        if unit.codec == Codec::F16 {
            *error = (largest * HALF_RELATIVE).max(HALF_SMALLEST);
        }
    }
    Ok((payload, errors))
}

/// Samples back from a payload.
pub fn floats(codec: Codec, payload: &[u8]) -> Vec<f32> {
    match codec {
        Codec::F16 => payload.as_chunks::<2>().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect(),
        _ => payload.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
    }
}
