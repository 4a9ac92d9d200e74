//! What a count is predicted to be: from frames of its past, from both its neighbours in time, or from samples of its
//! own frame that are known already. Whole numbers that wrap at 32 bits, so that both ends agree to the bit.

use crate::wire::TILE;

/// Taps of a prediction.
pub const TAPS: usize = 8;
/// A tap of 1 is this many bits up ...
pub const TAP_BITS: u32 = 12;
/// ... but the last tap's so many more.
pub const GAIN_BITS: u32 = 4;

/// Weights of a prediction, in units of 2^-12.
///
/// In time, over the frame before (or both neighbours added up): here, west, east, north, south; then here in the frame
/// before that, and in the one before that. A wave turns by 2 cos(w dt) from frame to frame; its Taylor series in the
/// wavenumber is what the four neighbours hold. In space: west, north, north-west, north-east, west of west, north of
/// north, and none.
///
/// The last, in units of 2^-16, weighs the first again: counts run to thousands, and an error of 2^-13 in their common
/// weight would be felt in each of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taps(pub [i16; TAPS]);

impl Taps {
    /// Taps near to these weights: each rounded, but the first so that they add up to `whole`, and the last to what the
    /// weights add up to beyond that. `None` where one is too large.
    pub fn nearest(weights: [f64; TAPS - 1], whole: f64) -> Option<Self> {
        let one = f64::from(1 << TAP_BITS);
        let mut taps = [0.0; TAPS];
        for (tap, weight) in taps.iter_mut().zip(weights).skip(1) {
            *tap = (weight * one).round();
        }
        taps[0] = whole * one - taps.iter().sum::<f64>();
        let gain = weights.iter().sum::<f64>() - whole;
        taps[TAPS - 1] = (gain * one * f64::from(1 << GAIN_BITS)).round();
        taps.iter().all(|tap| tap.abs() <= f64::from(i16::MAX)).then(|| Self(taps.map(|tap| tap as i16)))
    }
}

/// Planes that a plane of the same size is predicted from, each n x n, `[z][x]`.
#[derive(Clone, Copy, Debug)]
pub enum Basis<'a> {
    /// Samples of its own that are known already.
    Space,
    /// Frames of its past, the newest first; what is not there is empty.
    Past([&'a [i16]; 3]),
    /// The frames before and after it.
    Between(&'a [i16], &'a [i16]),
}

/// Predictions of row `z`, in units of 2^-12 counts, with the widest vectors that this machine has.
pub fn predict_row(basis: Basis, taps: Taps, n: usize, z: usize, row: &mut [i32]) {
    pulp::Arch::new().dispatch(PredictRow { basis, taps, n, z, row });
}

/// What is compiled once for each kind of machine: all of it is inlined into `call`.
struct PredictRow<'a> {
    basis: Basis<'a>,
    taps: Taps,
    n: usize,
    z: usize,
    row: &'a mut [i32],
}

impl pulp::NullaryFnOnce for PredictRow<'_> {
    type Output = ();
    #[inline(always)]
    fn call(self) {
        predict_row_inlined(self.basis, self.taps, self.n, self.z, self.row);
    }
}

/// The same, for who is compiled for the machine already. Patches repeat, so neighbours are looked for around the edges.
#[inline(always)]
pub fn predict_row_inlined(basis: Basis, taps: Taps, n: usize, z: usize, row: &mut [i32]) {
    match basis {
        Basis::Space => row.fill(0),
        Basis::Past([first, second, third]) => {
            row.fill(0);
            add_cross(&Line::of(first, n, z), taps, row);
            for (plane, tap) in [(second, taps.0[5]), (third, taps.0[6])] {
                if let Some(samples) = plane.get(z * n..(z + 1) * n) {
                    row.iter_mut().zip(samples).for_each(|(sum, sample)| *sum = sum.wrapping_add(times(tap, *sample)));
                }
            }
        }
        Basis::Between(before, after) => {
            row.fill(0);
            add_cross(&Line::of(before, n, z), taps, row);
            add_cross(&Line::of(after, n, z), taps, row);
        }
    }
}

/// A row and its neighbours, the row with its ends joined.
struct Line<'a> {
    joined: [i16; TILE + 2],
    above: &'a [i16],
    below: &'a [i16],
}

impl<'a> Line<'a> {
    #[inline(always)]
    fn of(plane: &'a [i16], n: usize, z: usize) -> Self {
        let row = |z: usize| &plane[z % n * n..][..n];
        let here = row(z);
        let mut joined = [0; TILE + 2];
        joined[1..=n].copy_from_slice(here);
        (joined[0], joined[n + 1]) = (here[n - 1], here[0]);
        Self { joined, above: row(z + n - 1), below: row(z + 1) }
    }
}

#[inline(always)]
fn times(tap: i16, sample: i16) -> i32 {
    i32::from(tap) * i32::from(sample)
}

#[inline(always)]
fn add_cross(line: &Line, Taps([centre, west, east, north, south, .., gain]): Taps, row: &mut [i32]) {
    // Slices of one length: the loop becomes vectors.
    let n = row.len();
    let (left, here, right) = (&line.joined[..n], &line.joined[1..=n], &line.joined[2..n + 2]);
    let (above, below) = (&line.above[..n], &line.below[..n]);
    for x in 0..n {
        let across = times(centre, here[x]).wrapping_add(times(west, left[x])).wrapping_add(times(east, right[x]));
        let along = times(north, above[x]).wrapping_add(times(south, below[x]));
        row[x] = row[x].wrapping_add(across).wrapping_add(along).wrapping_add(times(gain, here[x]) >> GAIN_BITS);
    }
}

/// Prediction of sample `x` of row `z` from the samples of `plane` above it and to its left, in units of 2^-12 counts.
/// What lies outside the plane counts as its nearest neighbour inside; the first row follows its left, the first column
/// what is above it.
#[inline(always)]
pub fn predict_in_space(plane: &[i16], taps: Taps, n: usize, z: usize, x: usize) -> i32 {
    let at = z * n + x;
    let sample = |back: usize| plane[at - back];
    match (z, x) {
        (0, 0) => 0,
        (0, _) => i32::from(sample(1)) << TAP_BITS,
        (_, 0) => i32::from(sample(n)) << TAP_BITS,
        _ => {
            let (west, north, north_west) = (sample(1), sample(n), sample(n + 1));
            let north_east = if x + 1 < n { sample(n - 1) } else { north };
            let far_west = if x > 1 { sample(2) } else { west };
            let far_north = if z > 1 { sample(2 * n) } else { north };
            let samples = [west, north, north_west, north_east, far_west, far_north].into_iter();
            let sum = samples.zip(taps.0).fold(0i32, |sum, (sample, tap)| sum.wrapping_add(times(tap, sample)));
            sum.wrapping_add(times(taps.0[TAPS - 1], west) >> GAIN_BITS)
        }
    }
}
