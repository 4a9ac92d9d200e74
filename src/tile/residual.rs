//! What is left of a plane after its prediction: a symbol of eight bits for each sample, where predictions know how
//! surely they can be rounded.
//!
//! A prediction is no whole number. Its fraction says which of the two counts beside it is the likelier, and how much:
//! where errors are smaller than a count that is half of what there is to be known. So residuals are taken from the
//! count below the prediction, and each quarter of a count is a context with statistics of its own.

use super::predict::{Basis, TAP_BITS, Taps, predict_in_space, predict_row_inlined};
use crate::wire::TILE;

/// Contexts where residuals are small: quarters of a count.
pub const CONTEXTS: usize = 4;
/// The symbol of a residual that is no symbol: the count itself follows elsewhere.
pub const ESCAPE: i8 = -128;
/// Most low bits that are cut off a residual.
pub const MAX_SHIFT: u8 = 8;
/// Tiles below this are too small to pay for more than one table.
const SMALL: usize = 64;
/// Residuals, on average, up to which no bits are cut off.
const USUAL: u64 = 20;

/// The residuals of a plane.
#[derive(Debug, Default)]
pub struct Residuals {
    /// Of each sample its symbol plus 128, and its context times 256.
    pub keys: Vec<u16>,
    /// How many contexts are told apart.
    pub contexts: usize,
    /// Low bits of each sample; empty without a shift.
    pub low: Vec<u8>,
    /// Counts of the samples that escape, in order.
    pub escapes: Vec<i16>,
    /// Low bits that were cut off.
    pub shift: u8,
    /// Scratch: residuals, and contexts in place.
    wide: Vec<i16>,
    places: Vec<u16>,
}

impl Residuals {
    /// Takes the residuals of a plane of n x n counts.
    pub fn take(&mut self, counts: &[i16], basis: Basis, taps: Taps, n: usize) {
        self.wide.resize(n * n, 0);
        self.places.resize(n * n, 0);
        self.keys.resize(n * n, 0);
        let (wide, places) = (self.wide.as_mut_slice(), self.places.as_mut_slice());
        let total = pulp::Arch::new().dispatch(Subtract { counts, basis, taps, n, wide, places });
        let mean = total / (n * n) as u64;
        self.shift = (0..MAX_SHIFT).find(|shift| mean >> shift <= USUAL).unwrap_or(MAX_SHIFT);
        self.contexts = if self.shift > 0 || n < SMALL { 1 } else { CONTEXTS };
        let Self { keys, contexts, low, escapes, shift, wide, places } = self;
        let (keys, wide, places) = (keys.as_mut_slice(), wide.as_slice(), places.as_slice());
        let many = if *contexts > 1 { u16::MAX } else { 0 };
        let escaped = pulp::Arch::new().dispatch(Symbols { keys, wide, places, shift: *shift, many });
        low.clear();
        if *shift > 0 {
            let mask = (1u16 << *shift) - 1;
            low.extend(wide.iter().map(|residual| (*residual as u16 & mask) as u8));
        }
        escapes.clear();
        if escaped {
            let all = keys.iter().zip(counts);
            escapes.extend(all.filter(|(key, _)| **key & 0xff == index_of(ESCAPE)).map(|(_, count)| *count));
        }
    }
}

/// Residuals and contexts of all samples. Compiled once for each kind of machine: all of it is inlined into `call`.
struct Subtract<'a> {
    counts: &'a [i16],
    basis: Basis<'a>,
    taps: Taps,
    n: usize,
    wide: &'a mut [i16],
    places: &'a mut [u16],
}

impl pulp::NullaryFnOnce for Subtract<'_> {
    /// The sum of the residuals, signs aside.
    type Output = u64;
    #[inline(always)]
    fn call(self) -> u64 {
        let Self { counts, basis, taps, n, wide, places } = self;
        let mut row = [0; TILE];
        let row = &mut row[..n];
        let mut total = 0u64;
        let lines = counts.chunks_exact(n).zip(wide.chunks_exact_mut(n).zip(places.chunks_exact_mut(n)));
        for (z, (line, (wide, places))) in lines.enumerate() {
            if let Basis::Space = basis {
                for (x, sample) in row.iter_mut().enumerate() {
                    *sample = predict_in_space(counts, taps, n, z, x);
                }
            } else {
                predict_row_inlined(basis, taps, n, z, row);
            }
            let mut sum = 0u32;
            for x in 0..n {
                let residual = i32::from(line[x]) - floor(row[x]);
                wide[x] = residual.clamp(-32768, 32767) as i16;
                places[x] = (context_of(row[x]) << 8) as u16;
                sum += residual.unsigned_abs();
            }
            total += u64::from(sum);
        }
        total
    }
}

/// Symbols of all samples, beside those bits of their contexts that are in `many`.
struct Symbols<'a> {
    keys: &'a mut [u16],
    wide: &'a [i16],
    places: &'a [u16],
    shift: u8,
    many: u16,
}

impl pulp::NullaryFnOnce for Symbols<'_> {
    /// Whether any escapes.
    type Output = bool;
    #[inline(always)]
    fn call(self) -> bool {
        let Self { keys, wide, places, shift, many } = self;
        let mut any = false;
        for i in 0..keys.len().min(wide.len()).min(places.len()) {
            let high = wide[i] >> shift;
            // The ends of the range may stand for anything beyond.
            let escapes = !(-127..=127).contains(&high) | (wide[i] == i16::MIN) | (wide[i] == i16::MAX);
            any |= escapes;
            let symbol = if escapes { i16::from(ESCAPE) } else { high };
            keys[i] = (symbol + 128) as u16 | (places[i] & many);
        }
        any
    }
}

/// The place of a symbol among 256.
pub fn index_of(symbol: i8) -> u16 {
    (i16::from(symbol) + 128) as u16
}

/// The count below a prediction.
#[inline(always)]
pub fn floor(predicted: i32) -> i32 {
    predicted >> TAP_BITS
}

/// The quarter of a count in which a prediction lies.
#[inline(always)]
pub fn context_of(predicted: i32) -> usize {
    (predicted >> (TAP_BITS - 2)) as usize & (CONTEXTS - 1)
}
