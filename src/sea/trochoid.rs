//! Which waves of a cascade are kept as trochoids, and what orbit each of them has.

use std::f64::consts::{PI, SQRT_2};

use super::modes::{CascadeModes, Sea};
use crate::scene::{Model, Trochoid};

/// How sharply a wave fades out as the next weaker one, which is left out, comes near in energy: its amplitude is
/// multiplied by 1 - (e' / e)^6. The wave at the edge has none, so that nothing pops where two change places. Of a wind
/// sea's 64 strongest this takes 10 to 14 % of the energy, by draw, which noise makes up for; a power of 8 takes 8 to 10 %
/// and moves more across a change of wind, one of 4 takes 16 to 20 %.
fn fade(next: f64, energy: f64) -> f64 {
    let cube = (next / energy) * (next / energy) * (next / energy);
    1.0 - cube * cube
}

/// One travelling wave whose surface is a trochoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrochoidWave {
    /// Whole waves along x in a patch, not negative.
    pub n: i32,
    /// Whole waves along z in a patch.
    pub m: i32,
    /// Amplitude of the cosine of the same variance, metres.
    pub amplitude: f64,
    /// Vertical radius of the orbit, metres.
    pub radius: f64,
    /// k times the horizontal radius, 0 to 1: at 1 the crest is a cusp.
    pub steepness: f64,
    /// 1 for a wave that travels along +k, -1 for one along -k.
    pub along: f64,
    /// Whole cycles per repeat period.
    pub cycles: u32,
    /// Phase at turn 0 at the origin, in 2^-32 of a turn.
    pub phase: u32,
    /// Angular frequency, rad/s.
    pub omega: f64,
}

/// The settings of a sea's trochoids: the usual ones where its model is another.
pub fn trochoid_settings(sea: &Sea) -> Trochoid {
    match sea.model {
        Model::Trochoid(settings) => settings,
        Model::Fft => Trochoid::default(),
    }
}

/// Every travelling wave of a cascade: its place among the modes, whether it goes along +k, and its energy, m^2.
///
/// h0(k) is the real wave 2 |h0| cos(k.x - w t + arg h0). Of the modes with n = 0, those with m < 0 repeat the others.
pub(super) fn travelling(modes: &CascadeModes) -> impl Iterator<Item = (usize, i32, i32, bool, f64)> {
    let (rows, half) = (modes.rows(), modes.cascade.half as i32);
    modes.modes.iter().enumerate().flat_map(move |(i, mode)| {
        let (n, m) = ((i / rows) as i32, (i % rows) as i32 - half);
        let there = n > 0 || m > 0;
        let wave = move |forward: bool, energy: f64| there.then_some((i, n, m, forward, 2.0 * energy));
        [wave(true, mode.forward.norm_sqr()), wave(false, mode.backward.norm_sqr())].into_iter().flatten()
    })
}

/// The strongest waves of a cascade, in the order of its modes: those with |n|, |m| < grid / 2, at most `components`
/// (Thon, Dischler & Ghazanfarpour 2000, section 3).
pub fn kept_waves(modes: &CascadeModes, sea: &Sea) -> Vec<TrochoidWave> {
    let settings = trochoid_settings(sea);
    let (reach, count) = ((settings.grid / 2) as i32, settings.components);
    let inside = |n: i32, m: i32| n < reach && m.abs() < reach;
    let mut waves: Vec<_> = travelling(modes).filter(|(_, n, m, _, energy)| inside(*n, *m) && *energy > 0.0).collect();
    let mut next = 0.0;
    if waves.len() > count {
        let stronger = |a: &(usize, i32, i32, bool, f64), b: &(usize, i32, i32, bool, f64)| {
            b.4.total_cmp(&a.4).then(a.0.cmp(&b.0)).then(b.3.cmp(&a.3))
        };
        waves.select_nth_unstable_by(count, stronger);
        next = waves[count].4;
        waves.truncate(count);
        waves.sort_unstable_by_key(|(place, _, _, forward, _)| (*place, !forward));
    }
    let dk = modes.cascade.dk();
    let wave = |(place, n, m, forward, energy): (usize, i32, i32, bool, f64)| {
        let mode = &modes.modes[place];
        let (h0, along) = if forward { (mode.forward, 1.0) } else { (mode.backward, -1.0) };
        let amplitude = libm::sqrt(2.0 * energy) * fade(next, energy);
        let k = libm::hypot(f64::from(n), f64::from(m)) * dk;
        let (radius, steepness) = orbit(amplitude, sea.choppiness * mode.widening * k);
        let turns = libm::atan2(h0.im, h0.re) / (2.0 * PI);
        let phase = (libm::round(turns * 4_294_967_296.0) as i64) as u32;
        let offset = if forward { mode.offset.wrapping_neg() } else { mode.offset };
        TrochoidWave {
            n,
            m,
            amplitude,
            radius,
            steepness,
            along,
            cycles: mode.cycles,
            phase: phase.wrapping_add(offset),
            omega: mode.omega(sea.repeat),
        }
    };
    waves.into_iter().map(wave).collect()
}

/// Radius (metres) and steepness of the orbit whose trochoid has the variance of a cosine of `amplitude`; `chop_k` is
/// choppiness times widening times wavenumber.
///
/// Over the world, a trochoid of radius r and steepness s = chop_k r has the mean -r s / 2 and the mean square r^2 / 2,
/// for the water moves together under the crests less than it spreads in the troughs: the variance is
/// r^2 / 2 (1 - s^2 / 2). Set equal to a^2 / 2, that is a quadratic in s^2. The steepest has s = 1, r = a sqrt 2.
pub fn orbit(amplitude: f64, chop_k: f64) -> (f64, f64) {
    let steep = chop_k * amplitude;
    let square = steep * steep;
    if square >= 0.5 {
        return (amplitude * SQRT_2, 1.0);
    }
    let s2 = 2.0 * square / (1.0 + libm::sqrt(1.0 - 2.0 * square));
    (amplitude / libm::sqrt(1.0 - 0.5 * s2), libm::sqrt(s2))
}
