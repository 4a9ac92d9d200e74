//! From single settings to an axis: their times in interleaved rounds, and the front among them.

use super::errors::Errors;
use super::ground::Ground;
use super::report::{Axis, Cost, Measure, Point};
use crate::engine::{Timed, Times, interleaved};

/// A setting before its time is known.
pub struct Draft<'a> {
    point: Point,
    work: Option<Timed<'a>>,
}

impl<'a> Draft<'a> {
    /// A setting and what it errs.
    pub fn new(setting: impl Into<String>, errors: Errors) -> Self {
        let point =
            Point { setting: setting.into(), errors, time: None, bytes_per_s: None, memory_bytes: None, front: false };
        Self { point, work: None }
    }

    /// Work whose time is its cost; it is told which round it is.
    pub fn costing(self, work: impl FnMut(i64) + 'a) -> Self {
        Self { work: Some(Box::new(work)), ..self }
    }

    /// Times that are known already.
    pub fn timed(mut self, times: Times) -> Self {
        self.point.time = Some(times);
        self
    }

    /// Bytes that a client receives a second.
    pub fn sending(mut self, bytes_per_s: f64) -> Self {
        self.point.bytes_per_s = Some(bytes_per_s);
        self
    }

    /// Bytes of fields and tables.
    pub fn holding(mut self, memory_bytes: u64) -> Self {
        self.point.memory_bytes = Some(memory_bytes);
        self
    }
}

/// Measures what is left to measure.
pub fn axis(ground: &Ground, name: &str, about: impl Into<String>, by: (Measure, Cost), drafts: Vec<Draft>) -> Axis {
    let (mut points, mut works, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for (place, Draft { point, work }) in drafts.into_iter().enumerate() {
        points.push(point);
        places.extend(work.is_some().then_some(place));
        works.extend(work);
    }
    let times = interleaved(ground.clock, ground.rounds, &mut works);
    for (place, times) in places.into_iter().zip(times) {
        points[place].time = Some(times);
    }
    let mut axis = Axis { name: name.to_owned(), about: about.into(), measure: by.0, cost: by.1, points };
    axis.mark_front();
    axis
}
