//! What a sea's modes are and how they turn: dispersion, energy per cell, and time. Sums in f64, so that nothing else errs.

use std::f64::consts::PI;

use super::axis::{Draft, axis};
use super::errors::Errors;
use super::ground::{Ground, hs_m};
use super::model::stopped;
use super::report::{Axis, Cost, Measure};
use crate::scene::{CascadeRequest, DispersionLaw, Patch, Scene, Swell, Water};
use crate::sea::{
    Cascade, CascadeModes, Dispersion, EnergyTable, Layout, Mode, Sea, Spectrum, Timeline, cos_sin_q24,
    cycles_per_repeat, turn_of_tick,
};
use crate::wire::TICKS_PER_SECOND;

const MINUTE: i64 = 60 * TICKS_PER_SECOND;

fn errors(ground: &Ground, made: &Sea, truth: &Sea, tick: i64) -> Errors {
    Errors::of(&ground.particles(made, tick), &ground.particles(truth, tick), hs_m(truth))
}

/// The same sea with other modes.
fn with(sea: &Sea, of: impl Fn(&CascadeModes, f64, f64, &Mode) -> Mode) -> Sea {
    let cascade = |modes: &CascadeModes| {
        let changed = modes.with_wave_vectors().map(|(kx, kz, mode)| of(modes, kx, kz, mode)).collect();
        CascadeModes { modes: changed, ..modes.clone() }
    };
    Sea { cascades: sea.cascades.iter().map(cascade).collect(), ..sea.clone() }
}

/// Which law of dispersion the waves obey, over water that the longest feel.
pub fn dispersion(ground: &Ground) -> Axis {
    let spectrum = Spectrum::new(&ground.scene.sea);
    let shallow_m = spectrum.longest_peak_m().unwrap_or(10.0) / 8.0;
    let depth_m = ground.scene.sea.water.depth_m.min(shallow_m);
    let law = |dispersion| {
        let water = Water { depth_m, dispersion, ..ground.scene.sea.water };
        turning_by(&ground.sea, water)
    };
    let truth = law(DispersionLaw::Capillary);
    let laws = [
        ("deep: w^2 = g k", DispersionLaw::Deep),
        ("finite depth", DispersionLaw::Finite),
        ("finite depth and surface tension", DispersionLaw::Capillary),
    ];
    let draft =
        |(name, dispersion): (&str, DispersionLaw)| Draft::new(name, errors(ground, &law(dispersion), &truth, MINUTE));
    let about = format!(
        "The same waves over {depth_m:.1} m of water, a minute after they were in step, by laws that leave out more and \
         more. All cost the same: they are in the tables."
    );
    axis(ground, "dispersion", about, (Measure::Height, Cost::Time), laws.map(draft).into())
}

/// The same modes, turning as they would in this water.
pub fn turning_by(sea: &Sea, water: Water) -> Sea {
    let dispersion = Dispersion::new(water);
    with(sea, |_, kx, kz, mode| {
        let k = libm::hypot(kx, kz);
        let cycles = if k > 0.0 { cycles_per_repeat(dispersion.omega(k), sea.repeat) } else { 0 };
        Mode { cycles, offset: 0, ..*mode }
    })
}

/// The spectrum at the centre of each cell instead of its integral over the cell; in the scene's sea and in a narrow swell.
pub fn energy(ground: &Ground) -> Axis {
    let mut drafts = Vec::new();
    for (name, scene) in [("the scene", ground.scene.clone()), ("a narrow swell", narrow_swell(&ground.scene))] {
        let ByCell { integrated, centre } = by_cell(&scene, ground.tick);
        let told = |way: &str, (sea, hs_m): &(Sea, f64)| {
            let off = 100.0 * (hs_m / integrated.1 - 1.0);
            let errors = errors(ground, sea, &integrated.0, ground.tick);
            Draft::new(format!("{name}, {way}: Hs {off:+.2} %"), errors)
        };
        drafts.extend([told("at the centre", &centre), told("integrated", &integrated)]);
    }
    let about = "The energy of a mode as the spectrum at the centre of its cell, as most programs have it, beside its \
                 integral over the cell. It costs when the tables are made, not in a frame.";
    axis(ground, "energy per cell", about, (Measure::Height, Cost::Time), drafts)
}

/// A scene of one long, narrow swell on one patch whose cells are wide beside its peak.
pub fn narrow_swell(scene: &Scene) -> Scene {
    let swell = Swell { hs_m: 1.0, tp_s: 12.0, gamma: 20.0, ..Swell::default() };
    let mut scene = scene.clone();
    (scene.sea.wind, scene.sea.measured, scene.replay, scene.wind_range_mps) = (None, None, None, None);
    scene.sea.swells = vec![swell];
    scene.cascades = CascadeRequest::Chosen { patches: vec![Patch { length_m: 1000.0, n: 128 }], band_limit: 1.0 };
    scene
}

/// A scene's sea, and its significant wave height on the mean over all draws, metres.
pub struct ByCell {
    /// With the energy of its modes integrated over their cells.
    pub integrated: (Sea, f64),
    /// With the spectrum at the centres of the cells in its place.
    pub centre: (Sea, f64),
}

/// The two at a tick.
pub fn by_cell(scene: &Scene, tick: i64) -> ByCell {
    let (integrated, layout) = (Timeline::new(scene).at(tick), Layout::of(scene));
    let (table, spectrum) = (EnergyTable::build(&scene.sea, &layout), Spectrum::new(&scene.sea));
    let of_centre = |cascade: &Cascade| {
        let density = |(kx, kz): (f64, f64)| {
            spectrum.density(kx, kz) * cascade.weight(libm::hypot(kx, kz)) * cascade.dk() * cascade.dk()
        };
        cascade.wave_vectors().map(density).collect()
    };
    let centres: Vec<Vec<f64>> = layout.cascades.iter().map(of_centre).collect();
    let ratio = |cascade: &Cascade, kx: f64, kz: f64| {
        let place = layout.cascades.iter().position(|known| known == cascade).unwrap_or(0);
        let (half, dk) = (cascade.half as f64, cascade.dk());
        let cell = ((kz / dk + half).round() * (2.0 * half + 1.0) + (kx / dk + half).round()) as usize;
        let integral = table.energy[place][cell];
        if integral > 0.0 { libm::sqrt(centres[place][cell] / integral) } else { 0.0 }
    };
    let centre = with(&integrated, |modes, kx, kz, mode| Mode {
        forward: mode.forward * ratio(&modes.cascade, kx, kz),
        backward: mode.backward * ratio(&modes.cascade, -kx, -kz),
        ..*mode
    });
    let hs_m = |energy: &[Vec<f64>]| 4.0 * energy.iter().flatten().sum::<f64>().sqrt();
    ByCell { integrated: (integrated, hs_m(&table.energy)), centre: (centre, hs_m(&centres)) }
}

/// Phases by seconds in f32, as most programs keep time, beside exact ones; after an hour, a day and 30 days.
pub fn time(ground: &Ground) -> Axis {
    let mut drafts = Vec::new();
    for (name, hours) in [("1 h", 1), ("1 day", 24), ("30 days", 720)] {
        let tick = hours * 3600 * TICKS_PER_SECOND + 77;
        let truth = ground.particles(&ground.sea, tick);
        let told = |made: &Sea| Errors::of(&ground.particles(made, 0), &truth, ground.hs_m);
        drafts.push(Draft::new(format!("exact phase, {name}"), told(&by_turns(&ground.sea, tick))));
        drafts.push(Draft::new(format!("f32 seconds, {name}"), told(&by_f32_seconds(&ground.sea, tick))));
    }
    let about = "Phases as wrapping products of integers, as Swellcast keeps them, and as a frequency times seconds in f32, \
                 so long after the beginning.";
    axis(ground, "time", about, (Measure::Height, Cost::Time), drafts)
}

/// The modes where the fast path has them at a tick: phases in 2^-32 of a turn.
pub fn by_turns(sea: &Sea, tick: i64) -> Sea {
    let turn = turn_of_tick(tick, sea.repeat);
    with(sea, |_, _, _, mode| {
        let (cos, sin) = cos_sin_q24(mode.cycles.wrapping_mul(turn).wrapping_add(mode.offset));
        stopped(mode, libm::atan2(f64::from(sin), f64::from(cos)))
    })
}

/// The modes where f32 seconds have them at a tick.
pub fn by_f32_seconds(sea: &Sea, tick: i64) -> Sea {
    let seconds = (tick as f64 / TICKS_PER_SECOND as f64) as f32;
    with(sea, |_, _, _, mode| {
        let offset = 2.0 * PI * f64::from(mode.offset) / 4_294_967_296.0;
        stopped(mode, f64::from(mode.omega(sea.repeat) as f32 * seconds) + offset)
    })
}
