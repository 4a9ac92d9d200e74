//! The shape of a trochoid over the world: psi = theta - s sin(theta), y = cos(theta), without solving Kepler's equation
//! for every sample.
//!
//! Two tables that all waves share. Up to a steepness of about a half, cos(theta) is a short series in cos(n psi) with
//! the coefficients (2/n) J_n'(n s) (Bessel 1824): a polynomial in cos(psi), which is turned along a row and needs no
//! look-up. Steeper waves look up cos(theta) and sin(theta) in rows by steepness, stretched towards the cusp.

use std::f64::consts::PI;
use std::sync::OnceLock;

/// Most terms of the series.
pub const TERMS: usize = 12;
/// What the terms left out may sum to, as a share of the radius ...
const VALUE_ERROR: f64 = 4e-5;
/// ... and of k times the radius, for the slope.
const SLOPE_ERROR: f64 = 4e-4;
/// Rows of the table, evenly in sqrt(1 - s) from the cusp to [`FLATTEST`].
const ROWS: usize = 96;
/// The steepness of the last row: the series serves those below.
const FLATTEST: f64 = 0.4;
/// Columns, evenly in the fourth root of psi / pi from crest to trough.
const COLUMNS: usize = 512;
/// 1 - s cos(theta) is taken to be at least this in a slope, which a cusp has no bound for.
const BLUNT: f32 = 1.0 / 64.0;

/// The shape of one steepness.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Steepness, 0 to 1.
    pub steepness: f32,
    /// Coefficients of cos(n psi), n = 1 to [`TERMS`], at their places; the first is not used.
    harmonics: [f64; TERMS + 1],
    /// The terms that are enough, multiplied out; `None`: more than there are.
    enough: Option<Polynomial>,
    /// cos(theta) and sin(theta) by column, where the series is not enough.
    table: Vec<[f32; 2]>,
}

/// cos(theta) + s/2, which has no mean, as a polynomial in cos(psi), coefficients from the lowest power.
#[derive(Clone, Copy, Debug)]
pub struct Polynomial {
    /// Coefficients.
    pub coefficients: [f32; TERMS + 1],
    /// Highest power that may have one.
    pub degree: usize,
}

/// How a profile is evaluated.
#[derive(Debug)]
pub enum Shape<'a> {
    /// By its series.
    Series(Polynomial),
    /// By its table.
    Table(&'a [[f32; 2]]),
}

impl Profile {
    /// The profile of a steepness from 0 to 1.
    pub fn new(steepness: f64) -> Self {
        let mut harmonics = [0.0; TERMS + 1];
        let mut beyond = (0.0, 0.0);
        // From the last to the first, so that what is left out is known at each.
        let mut enough = None;
        for n in (1..=TERMS + 8).rev() {
            let c = harmonic(n, steepness);
            if n <= TERMS {
                harmonics[n] = c;
                if beyond.0 <= VALUE_ERROR && beyond.1 <= SLOPE_ERROR {
                    enough = Some(n);
                }
            }
            beyond = (beyond.0 + c.abs(), beyond.1 + n as f64 * c.abs());
        }
        let table = if enough.is_none() { row(steepness) } else { Vec::new() };
        let enough = enough.map(|terms| polynomial(&harmonics, terms));
        Self { steepness: steepness as f32, harmonics, enough, table }
    }

    /// The way to evaluate it with no harmonic above `limit`; a grid can't show those beyond its Nyquist wavenumber.
    pub fn shape(&self, limit: usize) -> Shape<'_> {
        match self.enough {
            Some(polynomial) if polynomial.degree <= limit => Shape::Series(polynomial),
            None if limit > TERMS => Shape::Table(&self.table),
            _ => Shape::Series(polynomial(&self.harmonics, limit.min(TERMS))),
        }
    }
}

/// Chebyshev's polynomials, cos(n psi) = T_n(cos psi), multiplied out.
fn polynomial(harmonics: &[f64; TERMS + 1], terms: usize) -> Polynomial {
    let mut sum = [0.0; TERMS + 1];
    let (mut before, mut now) = ([0.0; TERMS + 1], [0.0; TERMS + 1]);
    (before[0], now[1]) = (1.0, 1.0);
    for harmonic in &harmonics[1..=terms] {
        sum.iter_mut().zip(now).for_each(|(sum, c)| *sum += harmonic * c);
        let mut next = before.map(|c: f64| -c);
        next[1..].iter_mut().zip(now).for_each(|(next, c)| *next += 2.0 * c);
        (before, now) = (now, next);
    }
    Polynomial { coefficients: sum.map(|c| c as f32), degree: terms }
}

/// (2/n) J_n'(n s): coefficient of cos(n psi) in cos(theta).
fn harmonic(n: usize, steepness: f64) -> f64 {
    let half = 0.5 * n as f64 * steepness;
    // (x/2)^(n-1) / n!, then the power series of the derivative.
    let mut term = (1..n).fold(1.0 / n as f64, |term, i| term * half / i as f64);
    let mut sum = 0.0;
    for m in 0..60 {
        let share = term * (2 * m + n) as f64 * 0.5;
        sum += share;
        if share.abs() <= 1e-17 * sum.abs() {
            break;
        }
        term *= -half * half / ((m + 1) * (m + 1 + n)) as f64;
    }
    2.0 / n as f64 * sum
}

/// cos(theta) and sin(theta) of one steepness by column, between two rows of the table.
fn row(steepness: f64) -> Vec<[f32; 2]> {
    static TABLE: OnceLock<Vec<Vec<[f64; 2]>>> = OnceLock::new();
    let widest = (1.0 - FLATTEST).sqrt();
    let table = TABLE.get_or_init(|| {
        let exact = |row: usize| {
            let t = widest * row as f64 / (ROWS - 1) as f64;
            let angle = move |i: usize| kepler(1.0 - t * t, PI * fourth(i as f64 / COLUMNS as f64));
            (0..=COLUMNS).map(angle).map(|theta| [libm::cos(theta), libm::sin(theta)]).collect()
        };
        (0..ROWS).map(exact).collect()
    });
    let place = (1.0 - steepness).max(0.0).sqrt() / widest * (ROWS - 1) as f64;
    let low = (place as usize).min(ROWS - 2);
    let share = (place - low as f64).min(1.0);
    let between =
        |i: usize| [0, 1].map(|part| (table[low][i][part] * (1.0 - share) + table[low + 1][i][part] * share) as f32);
    // One more, for the column after the trough.
    (0..=COLUMNS).map(between).chain([between(COLUMNS)]).collect()
}

/// theta in [0, pi] of psi = theta - s sin(theta). Convex there: Newton's method comes from above and never steps
/// too far.
fn kepler(s: f64, psi: f64) -> f64 {
    if psi <= 0.0 {
        return 0.0;
    }
    // theta - sin(theta) >= theta^3 / pi^2.
    let mut theta = (psi + s).min(libm::cbrt(PI * PI * psi)).min(PI);
    for _ in 0..60 {
        let step = (theta - s * libm::sin(theta) - psi) / (1.0 - s * libm::cos(theta));
        theta -= step;
        if step.abs() < 1e-15 {
            break;
        }
    }
    theta
}

/// cos(theta) and sin(theta) at psi, in 2^-32 of a turn, out of a profile's table.
#[inline]
pub fn look_up(table: &[[f32; 2]], psi: u32) -> (f32, f32) {
    let signed = psi as i32;
    let share = signed.unsigned_abs() as f32 * (1.0 / 2_147_483_648.0);
    let place = share.sqrt().sqrt() * COLUMNS as f32;
    let column = (place as usize).min(COLUMNS);
    let (low, high, between) = (table[column], table[column + 1], place - column as f32);
    let sin = low[1] + between * (high[1] - low[1]);
    (low[0] + between * (high[0] - low[0]), if signed < 0 { -sin } else { sin })
}

/// d cos(theta) / d psi, blunted where the crest is a cusp.
#[inline]
pub fn slope(steepness: f32, cos: f32, sin: f32) -> f32 {
    -sin / (1.0 - steepness * cos).max(BLUNT)
}

fn fourth(x: f64) -> f64 {
    x * x * x * x
}
