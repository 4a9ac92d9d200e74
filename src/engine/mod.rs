//! Runs the sea: a thread that steps the backend on the integer tick and publishes frames ahead of time. No tokio.

mod answer;
mod backends;
mod channels;
mod clock;
mod cost;
mod direct;
mod foam_track;
mod point_feed;
mod probe;
mod run;
mod sample;
mod schedule;
mod step;
mod timing;
mod trial;

pub use answer::{ProbeAnswer, ProbeFields};
pub use backends::{BackendChoice, Opener};
pub use clock::Clock;
pub use cost::{EffectCost, demand_cost, effect_costs};
pub use point_feed::{PointsMessage, PointsWish, fields_of_points};
pub use probe::{ProbeError, ProbeMethod, Probed, Prober};
pub use run::{Counters, Engine, EngineSettings, Publish};
pub use sample::{Sampler, lost_between};
pub use schedule::{HEADSTART, interval_of_rate, lead_ticks};
pub use step::{Batch, Stepper, Work};
pub use timing::{Timed, Times, interleaved};
pub use trial::Trial;
