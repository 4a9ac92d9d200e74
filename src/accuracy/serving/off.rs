//! How far off a scene is at a setting: what the layout leaves out, and what is lost between its samples.

use super::Setting;
use super::waves::{Missing, Waves};
use crate::accuracy::errors::Errors;
use crate::accuracy::ground::{LOOKED_AT, Made, fields, particles, spots};
use crate::scene::{Normals, Scene};
use crate::sea::Timeline;

/// Particles are looked at at so many places along either axis of the first patch.
const PLACES: usize = 24;
/// How far off a scene is at a setting, at a tick: waves that the layout leaves out, and what a client that reads between
/// the samples of its grids makes of those that it holds, as if independent. The same on every run.
pub fn errors(scene: &Scene, setting: &Setting, tick: i64) -> Errors {
    // Foam moves no particle.
    errors_at(&Timeline::uncalibrated(&setting.of(scene)), setting.finest_m, tick)
}

/// The same of a timeline as it stands, where slopes of waves down to `finest_m` metres are wanted.
pub fn errors_at(timeline: &Timeline, finest_m: f64, tick: i64) -> Errors {
    let (left_out, between) = (left_out(timeline, finest_m, tick), between(timeline, tick));
    let both = |error: fn(&Errors) -> Option<f64>| match (error(&left_out), error(&between)) {
        (Some(a), Some(b)) => Some(a.hypot(b)),
        (a, b) => a.or(b),
    };
    let seen = timeline.scene().effects.normals != Normals::None;
    Errors {
        height_rms: both(|errors| errors.height_rms),
        position_mm: both(|errors| errors.position_mm),
        normal_deg: both(|errors| errors.normal_deg).filter(|_| seen),
        normal_p99_deg: both(|errors| errors.normal_p99_deg).filter(|_| seen),
        ..Errors::default()
    }
}

/// What waves would add that the layout doesn't hold: energy of any length, slopes down to the finest wanted.
fn left_out(timeline: &Timeline, finest_m: f64, tick: i64) -> Errors {
    let waves = Waves::new(timeline.state_at(tick));
    let Missing { m0, slope } = waves.left_out(timeline.layout(), finest_m);
    let chop = timeline.scene().effects.choppiness;
    // Slopes of many waves along two axes: their length has Rayleigh's distribution.
    let p99 = slope * 100_f64.ln();
    Errors {
        height_rms: Some(if m0 > 0.0 { 0.25 * (m0 / waves.m0()).sqrt() } else { 0.0 }),
        position_mm: Some((m0 * (1.0 + chop * chop)).sqrt() * 1e3),
        normal_deg: Some(slope.sqrt().atan().to_degrees()),
        normal_p99_deg: Some(p99.sqrt().atan().to_degrees()),
        ..Errors::default()
    }
}

/// Particles as they are read bicubically from the CPU's grids, beside those of the layout's own waves.
fn between(timeline: &Timeline, tick: i64) -> Errors {
    let mut made = Made::new(timeline.at(tick), LOOKED_AT, &timeline.scene().effects);
    let spots = spots(made.sea().cascades[0].cascade.patch_m, PLACES);
    let truth = particles(&fields(made.sea(), tick, &spots));
    Errors::of(&particles(&made.between(tick, &spots)), &truth, timeline.wanted_hs_at(tick))
}
