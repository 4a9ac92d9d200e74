//! What a run of `swellcast accuracy` found, as it is written down and drawn.

use serde::{Deserialize, Serialize};

use super::errors::Errors;
use crate::engine::Times;

/// Share of a budget that a frame may take: the rest is for what else the machine does.
const SAFE_SHARE: f64 = 0.8;

/// Everything that was found. Errors and bytes are the same on every run; times are this machine's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Name of the scene.
    pub scene: String,
    /// Its significant wave height, metres.
    pub hs_m: f64,
    /// Decides the random draw.
    pub seed: u64,
    /// The tick that is looked at.
    pub tick: i64,
    /// What was measured on.
    pub machine: Machine,
    /// Fewer settings and rounds.
    pub quick: bool,
    /// How long it took, seconds.
    pub took_s: f64,
    /// One choice each, in the order in which they are told; the last are the combinations that a server can be run at.
    pub axes: Vec<Axis>,
    /// Where a step's time goes, by samples a side.
    pub stages: Vec<StageRow>,
    /// What was not measured, and why.
    pub left_out: Vec<String>,
}

/// A machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Name of the processor.
    pub processor: String,
    /// Processors that this process may use.
    pub cores: usize,
    /// Name, kind and driver of the GPU, where one was measured.
    pub adapter: Option<String>,
}

/// One choice that trades truth for time or bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Short name.
    pub name: String,
    /// What is compared with what, in a sentence or two.
    pub about: String,
    /// By which error its front is drawn ...
    pub measure: Measure,
    /// ... and by which cost.
    pub cost: Cost,
    /// Its settings.
    pub points: Vec<Point>,
}

/// An error that a front is drawn by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// [`Errors::height_rms`].
    Height,
    /// [`Errors::position_mm`].
    Position,
    /// [`Errors::normal_deg`].
    Normal,
    /// [`Errors::foam`].
    Foam,
}

/// A cost that a front is drawn by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cost {
    /// [`Point::time`].
    Time,
    /// [`Point::bytes_per_s`].
    Bytes,
}

/// One setting, what it errs and what it costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The setting.
    pub setting: String,
    /// How far it is off.
    pub errors: Errors,
    /// Time of a frame, unless the axis says otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<Times>,
    /// Bytes a second that a client receives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes_per_s: Option<f64>,
    /// Memory of its fields and tables, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory_bytes: Option<u64>,
    /// No other setting of the axis is both more accurate and cheaper.
    pub front: bool,
}

/// Milliseconds of each stage of the CPU, for one cascade of a grid, on one thread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageRow {
    /// Samples a side.
    pub n: usize,
    /// By stage, in the order of [`STAGES`].
    pub times: [Times; STAGES.len()],
}

/// The axis of the combinations that a server can be run at.
pub const SERVING: &str = "serving";

/// The stages of the CPU: spectra of every mode; turning them to a tick; transforms of eight fields; the Jacobian;
/// normals; foam; and encoding six channels.
pub const STAGES: [&str; 7] = ["initialise", "evolve", "transform", "assemble", "normals", "foam", "encode"];

impl Measure {
    /// Its error, where it was measured.
    pub fn of(self, errors: &Errors) -> Option<f64> {
        match self {
            Self::Height => errors.height_rms,
            Self::Position => errors.position_mm,
            Self::Normal => errors.normal_deg,
            Self::Foam => errors.foam,
        }
    }

    /// What it is, and its unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Height => "height, rms of Hs",
            Self::Position => "position, rms mm",
            Self::Normal => "normal, rms degrees",
            Self::Foam => "foam, rms",
        }
    }
}

impl Axis {
    /// Marks the points that no other beats: none is as accurate and surely cheaper, or more accurate and not surely
    /// dearer. Times are surely different where their quartiles don't meet, so that a noisy machine marks the same
    /// points again. A point without an error or a cost is never marked.
    pub fn mark_front(&mut self) {
        let known = |point: &Point| Some((self.measure.of(&point.errors)?, self.cost.of(point)?));
        let points: Vec<Option<(f64, [f64; 2])>> = self.points.iter().map(known).collect();
        let beaten = |(error, [low, high]): (f64, [f64; 2])| {
            points.iter().flatten().any(|(other, [least, most])| {
                (*other <= error && *most < low) || (*other < error && *least <= high && *most <= high)
            })
        };
        let front: Vec<bool> = points.iter().map(|point| point.is_some_and(|point| !beaten(point))).collect();
        self.points.iter_mut().zip(front).for_each(|(point, front)| point.front = front);
    }

    /// The most accurate point of the front that is safe in a budget: 95 of 100 of its frames take at most four fifths
    /// of it. Of equally accurate ones, the quickest.
    pub fn best_within(&self, budget_ms: f64) -> Option<&Point> {
        let front = self.points.iter().filter(|point| point.front);
        let front = front.filter_map(|point| Some((self.measure.of(&point.errors)?, point.time?.p95_ms, point)));
        let fits = front.filter(|(_, p95_ms, _)| *p95_ms <= SAFE_SHARE * budget_ms);
        fits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(.., point)| point)
    }
}

impl Cost {
    /// That of a point where it was measured, milliseconds between its quartiles or bytes a second.
    pub fn of(self, point: &Point) -> Option<[f64; 2]> {
        match self {
            Self::Time => point.time.map(|time| [time.lower_ms, time.upper_ms]),
            Self::Bytes => point.bytes_per_s.map(|bytes| [bytes, bytes]),
        }
    }
}

impl Machine {
    /// This one.
    pub fn here(adapter: Option<String>) -> Self {
        let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name =
            told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": ").map(|(_, name)| name));
        let processor = name.unwrap_or(std::env::consts::ARCH).trim().to_owned();
        Self { processor, cores: std::thread::available_parallelism().map_or(1, usize::from), adapter }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(setting: &str, error: f64, p95_ms: Option<f64>, front: bool) -> Point {
        let errors = Errors { height_rms: Some(error), ..Errors::default() };
        let time = p95_ms.map(|p95_ms| Times { p95_ms, ..Times::default() });
        Point { setting: setting.to_owned(), errors, time, bytes_per_s: None, memory_bytes: None, front }
    }

    #[test]
    fn the_most_accurate_of_the_front_that_is_safe_in_the_budget_is_chosen() {
        let points = vec![
            point("exact", 0.0, Some(20.0), true),
            point("fine", 0.1, Some(8.0), true),
            point("as fine, slower", 0.1, Some(8.5), true),
            point("beaten", 0.05, Some(7.0), false),
            point("coarse", 0.5, Some(1.0), true),
            point("never timed", 0.0, None, true),
        ];
        let axis =
            Axis { name: SERVING.to_owned(), about: String::new(), measure: Measure::Height, cost: Cost::Time, points };
        let within = |budget_ms| axis.best_within(budget_ms).map(|point| point.setting.as_str());
        assert_eq!(within(25.0), Some("exact"), "a frame takes at most four fifths");
        assert_eq!(within(24.9), Some("fine"));
        assert_eq!(within(9.9), Some("coarse"));
        assert_eq!(within(1.2), None);
        assert_eq!(within(f64::NAN), None);
    }
}
