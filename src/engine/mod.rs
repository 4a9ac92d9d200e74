//! Runs the sea: a thread that steps the backend on the integer tick and publishes frames ahead of time. No tokio.

mod clock;
mod cost;
mod foam_track;
mod run;
mod schedule;
mod step;

pub use clock::Clock;
pub use cost::{EffectCost, StepTime, demand_cost, effect_costs};
pub use run::{Counters, Engine, EngineSettings};
pub use schedule::{RATES_HZ, interval_of_rate, lead_ticks};
pub use step::{Batch, Stepper, Work};
