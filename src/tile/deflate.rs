//! The second coding of residuals, for who has no rANS but an inflate: bytes of residuals in one deflate stream, which
//! only Huffman codes and runs make shorter.

use miniz_oxide::deflate::core::create_comp_flags_from_zip_params;
use miniz_oxide::deflate::core::{CompressorOxide, TDEFLFlush, TDEFLStatus, compress_to_output};
use miniz_oxide::inflate::decompress_to_vec_with_limit;

use super::predict::{Basis, TAP_BITS, Taps, predict_row};
use super::rans::Damaged;
use crate::wire::TILE;

/// zlib's `Z_RLE`: matches at distance 1 alone, Huffman codes for the rest.
const RUNS: i32 = 3;

/// The count nearest to a prediction.
#[inline]
fn nearest(predicted: i32) -> i32 {
    predicted.wrapping_add(1 << (TAP_BITS - 1)) >> TAP_BITS
}

/// In space this coding has taps of its own, fixed, so that planes come back by two running sums: west + north -
/// north-west, where what lies outside is 0. Sums wrap at 16 bits.
fn lorenzo(plane: &[i16], n: usize, z: usize, x: usize) -> i16 {
    let at = z * n + x;
    let west = if x > 0 { plane[at - 1] } else { 0 };
    let north = if z > 0 { plane[at - n] } else { 0 };
    let north_west = if x > 0 && z > 0 { plane[at - n - 1] } else { 0 };
    west.wrapping_add(north).wrapping_sub(north_west)
}

/// Residuals of a plane as bytes: the low bytes of all samples, and where any is beyond them (`true`) the high ones.
/// A residual r stands as 2 r, or -2 r - 1 where it is negative, so that small ones are small numbers.
pub fn residual_bytes(counts: &[i16], basis: Basis, taps: Taps, n: usize, out: &mut Vec<u8>) -> bool {
    let mut folded = Vec::with_capacity(n * n);
    let mut row = [0; TILE];
    for z in 0..n {
        predict_row(basis, taps, n, z, &mut row[..n]);
        for (x, predicted) in row[..n].iter().enumerate() {
            let predicted = match basis {
                Basis::Space => lorenzo(counts, n, z, x),
                _ => nearest(*predicted) as i16,
            };
            let residual = counts[z * n + x].wrapping_sub(predicted);
            folded.push((residual << 1 ^ residual >> 15) as u16);
        }
    }
    out.extend(folded.iter().map(|residual| *residual as u8));
    let wide = folded.iter().any(|residual| *residual > 255);
    if wide {
        out.extend(folded.iter().map(|residual| (residual >> 8) as u8));
    }
    wide
}

/// A plane back from its residuals.
pub fn restore(low: &[u8], high: Option<&[u8]>, basis: Basis, taps: Taps, n: usize, counts: &mut [i16]) {
    let mut row = [0; TILE];
    for z in 0..n {
        predict_row(basis, taps, n, z, &mut row[..n]);
        for (x, predicted) in row[..n].iter().enumerate() {
            let at = z * n + x;
            let folded = u16::from(low[at]) | high.map_or(0, |high| u16::from(high[at])) << 8;
            let residual = (folded >> 1) as i16 ^ -((folded & 1) as i16);
            let predicted = match basis {
                Basis::Space => lorenzo(counts, n, z, x),
                _ => nearest(*predicted) as i16,
            };
            counts[at] = predicted.wrapping_add(residual);
        }
    }
}

/// Appends a deflate stream (RFC 1951) of these bytes.
pub fn deflate(bytes: &[u8], out: &mut Vec<u8>) {
    let flags = create_comp_flags_from_zip_params(1, 0, RUNS);
    let mut compressor = CompressorOxide::new(flags);
    let (status, _) = compress_to_output(&mut compressor, bytes, TDEFLFlush::Finish, |piece| {
        out.extend_from_slice(piece);
        true
    });
    debug_assert_eq!(status, TDEFLStatus::Done);
}

/// The bytes of a deflate stream, at most so many.
///
/// # Errors
/// [`Damaged`] for bytes that are no such stream.
pub fn inflate(stream: &[u8], most: usize) -> Result<Vec<u8>, Damaged> {
    decompress_to_vec_with_limit(stream, most).map_err(|_| Damaged("no deflate stream of so many bytes"))
}
