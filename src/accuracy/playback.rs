//! How often frames come and what is shown between them. Frames of the reference, so that nothing but time errs.

use super::axis::{Draft, axis};
use super::errors::{Errors, Particle};
use super::ground::{Fields, Ground, LOOKED_AT, fields, hs_m};
use super::report::{Axis, Cost, Measure};
use crate::plan::Field;
use crate::sea::Sea;
use crate::tile::lagrange;
use crate::wire::TICKS_PER_SECOND;

/// What is shown between two frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// The nearest frame.
    Nearest,
    /// The line between the two around.
    Linear,
    /// The cubic through two before and two after (Lagrange): what clients do.
    Cubic,
    /// The cubic that has the positions and velocities of the two around (Hermite); normals as `Cubic`.
    Hermite,
}

/// All of them.
pub const KERNELS: [Between; 4] = [Between::Nearest, Between::Linear, Between::Cubic, Between::Hermite];
const RATES_HZ: [i64; 4] = [10, 15, 30, 60];
/// Moments between two frames, as shares of the interval.
const MOMENTS: [f64; 4] = [0.125, 0.375, 0.625, 0.875];

impl Between {
    fn name(self) -> &'static str {
        ["nearest", "linear", "cubic", "Hermite"][self as usize]
    }

    /// Fields a share of the way between the second and the third of four frames, `seconds` apart.
    fn fields(self, frames: [&Fields; 4], share: f64, seconds: f64) -> Fields {
        let mix = |weights: [f64; 4]| {
            std::array::from_fn(|field| frames.iter().zip(weights).map(|(frame, w)| w * frame[field]).sum::<f64>())
        };
        let cubic = || {
            let weights = lagrange(&[-1.0, 0.0, 1.0, 2.0].map(|node| node - share));
            mix([weights[0], weights[1], weights[2], weights[3]])
        };
        match self {
            Self::Nearest => *if share < 0.5 { frames[1] } else { frames[2] },
            Self::Linear => mix([0.0, 1.0 - share, share, 0.0]),
            Self::Cubic => cubic(),
            Self::Hermite => {
                let (t, mut made) = (share, cubic());
                let (far, near_rate, far_rate) =
                    (t * t * (3.0 - 2.0 * t), t * (1.0 - t) * (1.0 - t), t * t * (t - 1.0));
                for (field, rate) in
                    [(Field::Dx, Field::VelocityX), (Field::Height, Field::VelocityY), (Field::Dz, Field::VelocityZ)]
                {
                    let [before, after] = [frames[1], frames[2]].map(|frame| frame[field as usize]);
                    let [leaving, coming] = [frames[1], frames[2]].map(|frame| frame[rate as usize] * seconds);
                    made[field as usize] = before * (1.0 - far) + after * far + leaving * near_rate + coming * far_rate;
                }
                made
            }
        }
    }
}

/// What each kernel errs between frames of a sea `interval` ticks apart, in the order of [`KERNELS`].
pub fn between_frames(sea: &Sea, spots: &[Vec<f64>; 2], tick: i64, interval: i64) -> [Errors; 4] {
    let frame = |step: i64| fields(sea, tick + step * interval, spots);
    let frames = [-1, 0, 1, 2].map(frame);
    let (mut made, mut truth) = (KERNELS.map(|_| Vec::new()), Vec::new());
    for share in MOMENTS {
        // Whole ticks, so that the reference is exact there.
        let past = (share * interval as f64).round() as i64;
        let share = past as f64 / interval as f64;
        truth.extend(fields(sea, tick + past, spots).iter().map(Particle::of));
        for (made, kernel) in made.iter_mut().zip(KERNELS) {
            let at = |i: usize| {
                let around = [0, 1, 2, 3].map(|frame: usize| &frames[frame][i]);
                Particle::of(&kernel.fields(around, share, interval as f64 / TICKS_PER_SECOND as f64))
            };
            made.extend((0..frames[0].len()).map(at));
        }
    }
    made.map(|made| Errors::of(&made, &truth, hs_m(sea)))
}

/// Rates and kernels.
pub fn playback(ground: &Ground) -> Axis {
    let samples: usize = ground.sea.cascades.iter().map(|modes| modes.cascade.n * modes.cascade.n).sum();
    let mut drafts = Vec::new();
    for rate in RATES_HZ {
        let errors = between_frames(&ground.sea, &ground.spots, ground.tick, TICKS_PER_SECOND / rate);
        for (kernel, errors) in KERNELS.into_iter().zip(errors) {
            // Velocities come besides.
            let channels = LOOKED_AT.len() + if kernel == Between::Hermite { 3 } else { 0 };
            let bytes = (rate as usize * samples * channels * 2) as f64;
            drafts.push(Draft::new(format!("{rate} Hz, {}", kernel.name()), errors).sending(bytes));
        }
    }
    let about = "Frames a second and what is shown between them. Bytes are those of 16-bit counts before coding; Hermite \
                 needs the velocities, too.";
    axis(ground, "rate and playback", about, (Measure::Height, Cost::Bytes), drafts)
}
