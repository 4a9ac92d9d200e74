//! Measures two backends on a scene: how far one is from the other, and which is the faster.

use super::clock::Clock;
use super::cost::demand_cost;
use super::timing::Times;
use crate::backend::{Backend, BackendError, Surface};
use crate::plan::{CascadePlan, Demand, Field, FieldSet, Plan};
use crate::sea::Timeline;
use crate::wire::{Codec, ErrorClass, Group, SLOWEST_INTERVAL, UnitName};

/// What a backend may differ from the CPU by, over a field's own scale: root mean square, and most.
const BOUND: [f64; 2] = [2e-6, 2e-5];

/// What a trial found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Of the backend that is tried.
    pub step: Times,
    /// Of the CPU, in the same run.
    pub cpu: Times,
    /// Largest of all fields' errors against the CPU, over their scales: root mean square, and most.
    pub error: [f64; 2],
}

impl Trial {
    /// Tries a backend beside the CPU, on every group of a scene; leaves the sea of `tick` loaded.
    ///
    /// # Errors
    /// [`BackendError`] of either.
    pub fn run(
        tried: &mut dyn Backend,
        cpu: &mut dyn Backend,
        timeline: &Timeline,
        tick: i64,
        clock: &Clock,
    ) -> Result<Self, BackendError> {
        let demand = everything(timeline);
        // Twice in turn, of which the quieter run counts.
        let mut times = [[Times::default(); 2]; 2];
        for times in &mut times {
            *times = [
                demand_cost(tried, timeline, &demand, tick, clock)?,
                demand_cost(cpu, timeline, &demand, tick, clock)?,
            ];
        }
        let quieter = |which: usize| {
            let [a, b] = times.map(|times| times[which]);
            if a.median_ms < b.median_ms { a } else { b }
        };
        let plan = CascadePlan::new([(0, FieldSet::SPECTRAL)], None, &timeline.scene().effects);
        let plan = Plan { cascades: vec![plan; timeline.layout().cascades.len()] };
        let error = errors(tried.step(tick, &plan)?, cpu.step(tick, &plan)?, timeline.hs_at(tick));
        Ok(Self { step: quieter(0), cpu: quieter(1), error })
    }

    /// Whether its fields are those of the CPU.
    pub fn is_true(&self) -> bool {
        self.error[0] <= BOUND[0] && self.error[1] <= BOUND[1]
    }

    /// Whether it is the faster.
    pub fn is_faster(&self) -> bool {
        self.step.median_ms < self.cpu.median_ms
    }

    /// For people.
    pub fn told(&self) -> String {
        let time = |t: &Times| format!("{:.2} ms a frame ({:.2} to {:.2})", t.median_ms, t.lower_ms, t.upper_ms);
        let [rms, max] = self.error;
        format!("{}, cpu {}; error {rms:.1e} rms, {max:.1e} most", time(&self.step), time(&self.cpu))
    }
}

/// Every group that a scene has, of every cascade.
fn everything(timeline: &Timeline) -> Demand {
    let effects = &timeline.scene().effects;
    let groups = || Group::ALL.into_iter().filter(|group| effects.has(*group));
    let unit =
        |cascade: u8, group| UnitName { cascade, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::I16 };
    let cascades = timeline.layout().cascades.iter().map(|cascade| cascade.index);
    cascades.flat_map(|index| groups().map(move |group| (unit(index, group), SLOWEST_INTERVAL))).collect()
}

/// The largest errors of a surface against another; a value that is no number is infinitely wrong.
fn errors(got: &Surface, want: &Surface, hs: f64) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    let whole = |field: Field| {
        let planes = want.cascades.iter().filter_map(|cascade| cascade.plane(field));
        let square = |plane: &[f32]| plane.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>() / plane.len() as f64;
        planes.map(square).sum::<f64>().sqrt()
    };
    for (got, want) in got.cascades.iter().zip(&want.cascades) {
        for field in Field::SPECTRAL {
            let (Some(got), Some(want)) = (got.plane(field), want.plane(field)) else { return [f64::INFINITY; 2] };
            let mean_square =
                |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>() / want.len() as f64;
            let scale = match field {
                Field::Height | Field::Dx | Field::Dz => hs,
                // A thousandth of the whole sea's is enough where a cascade holds next to nothing.
                _ => mean_square(&mut want.iter().map(|v| f64::from(*v))).sqrt().max(1e-3 * whole(field)),
            };
            let off = || got.iter().zip(want).map(|(got, want)| f64::from(got - want) / scale.max(f64::MIN_POSITIVE));
            let most = off().fold(0.0, |most: f64, e| if e.is_nan() { f64::INFINITY } else { most.max(e.abs()) });
            worst = [worst[0].max(mean_square(&mut off()).sqrt()), worst[1].max(most)];
        }
    }
    worst
}
