//! How many samples, cascades and waves: what a coarser sea leaves out, and what lies between its samples.

use super::axis::{Draft, axis};
use super::errors::Errors;
use super::ground::{Fields, Ground, LOOKED_AT, Made, hs_m, particles, with_grid, with_modes};
use super::report::{Axis, Cost, Measure};
use crate::backend::Surface;
use crate::plan::Field;
use crate::scene::{CascadeRequest, Effects, Patch};
use crate::sea::Sea;

/// Ticks between the frames of a time.
const INTERVAL: i64 = 240;

/// Samples a side of every cascade.
pub fn grid(ground: &Ground) -> Axis {
    let sides: &[usize] = if ground.quick { &[32, 64, 128, 256, 512] } else { &[32, 64, 128, 256, 512, 1024, 2048] };
    let draft = |n: &usize| {
        let mut made = Made::new(with_grid(&ground.sea, *n), LOOKED_AT, &ground.scene.effects);
        let errors = ground.errors(&particles(&made.between(ground.tick, &ground.spots)));
        let (memory, tick) = (made.memory_bytes(), ground.tick);
        let step = move |round: i64| {
            made.step(tick + round * INTERVAL);
        };
        Draft::new(format!("N = {n}"), errors).holding(memory).costing(step)
    };
    let about = "Samples a side of every cascade, with the same modes; those that a grid can't hold are left out. Read \
                 bicubically, as clients do. The time is that of eight fields on the CPU.";
    axis(ground, "grid", about, (Measure::Height, Cost::Time), sides.iter().map(draft).collect())
}

/// How many cascades, out of five that hold all.
pub fn cascades(ground: &Ground) -> Axis {
    const N: usize = 128;
    let own: Vec<f64> = ground.sea.cascades.iter().map(|modes| modes.cascade.patch_m).collect();
    let (first, last) = (own[0], own[own.len() - 1]);
    let ratio = (first / last).powf(0.25).clamp(2.0, 7.0);
    let patches = (0..5).map(|i| Patch { length_m: first / ratio.powi(i), n: N }).collect();
    let five = ground.with_patches(patches, 1.0 / 3.0);
    let (truth, hs_m) = (ground.particles(&five, ground.tick), hs_m(&five));
    let draft = |count: usize| {
        let sea = Sea { cascades: five.cascades[..count].to_vec(), ..five.clone() };
        let finest = sea.cascades[count - 1].cascade.shortest_m();
        let mut made = Made::new(sea, LOOKED_AT, &ground.scene.effects);
        let errors = Errors::of(&particles(&made.between(ground.tick, &ground.spots)), &truth, hs_m);
        let (memory, tick) = (made.memory_bytes(), ground.tick);
        let step = move |round: i64| {
            made.step(tick + round * INTERVAL);
        };
        Draft::new(format!("{count}, waves down to {finest:.2} m"), errors).holding(memory).costing(step)
    };
    let about = format!(
        "The longest cascades of five of {N} x {N} samples, {first:.0} m to {:.1} m, beside all five.",
        first / ratio.powi(4)
    );
    axis(ground, "cascades", about, (Measure::Normal, Cost::Time), (1..=5).map(draft).collect())
}

/// Where the band of a grid ends, and how it is read between its samples.
pub fn band(ground: &Ground) -> Axis {
    let n = if ground.quick { 128 } else { CascadeRequest::USUAL_N };
    let patch = Patch { length_m: ground.sea.cascades[0].cascade.patch_m, n };
    let full = ground.with_patches(vec![patch], 1.0);
    let (truth, hs_m) = (ground.particles(&full, ground.tick), hs_m(&full));
    let mut drafts = Vec::new();
    for (name, share) in [("a third", 1.0 / 3.0), ("half", 0.5), ("all", 1.0)] {
        for (reader, bicubic) in [("bilinear", false), ("bicubic", true)] {
            let half = ((share * n as f64 / 2.0) as usize).min(n / 2 - 1);
            let mut made = Made::new(with_modes(&full, |_| (n, half)), LOOKED_AT, &Effects::default());
            let read = move |made: &mut Made, tick: i64, spots: &[Vec<f64>; 2]| match bicubic {
                true => made.between(tick, spots),
                false => bilinear(made.step(tick), patch.length_m, spots),
            };
            let errors = Errors::of(&particles(&read(&mut made, ground.tick, &ground.spots)), &truth, hs_m);
            let (tick, spots) = (ground.tick, &ground.spots);
            let work = move |round: i64| drop(read(&mut made, tick + round * INTERVAL, spots));
            drafts.push(Draft::new(format!("{name} of Nyquist, {reader}"), errors).costing(work));
        }
    }
    let about = format!(
        "Modes up to a share of the Nyquist wavenumber of one cascade of {n} x {n} samples, beside all of them. Waves that \
         are left out can't be read; short ones that are there are read badly. The time includes reading {} points.",
        ground.truth.len()
    );
    axis(ground, "band limit", about, (Measure::Height, Cost::Time), drafts)
}

/// Fields of a surface of one cascade between its samples, by the four around each position.
fn bilinear(surface: &Surface, patch_m: f64, [xs, zs]: &[Vec<f64>; 2]) -> Vec<Fields> {
    let (cascade, n) = (&surface.cascades[0], surface.cascades[0].n);
    let split = |metres: f64| {
        let samples = (metres / patch_m).rem_euclid(1.0) * n as f64;
        (samples as usize % n, (samples as usize + 1) % n, samples.fract())
    };
    let at = |x: f64, z: f64| {
        let ((left, right, tx), (above, below, tz)) = (split(x), split(z));
        Field::SPECTRAL.map(|field| {
            let Some(plane) = cascade.plane(field) else { return 0.0 };
            let row = |z: usize| (1.0 - tx) * f64::from(plane[z * n + left]) + tx * f64::from(plane[z * n + right]);
            (1.0 - tz) * row(above) + tz * row(below)
        })
    };
    zs.iter().flat_map(|z| xs.iter().map(|x| at(*x, *z))).collect()
}
