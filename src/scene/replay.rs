//! A sequence of measured records that follow one another.

use super::bound::{SceneError, within};
use super::measured::MeasuredSpectrum;
use crate::wire::TICKS_PER_SECOND;

/// Records after the first, which is the scene's own; the sea stays with the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// In the order they come.
    pub records: Vec<MeasuredSpectrum>,
    /// Ticks from the beginning of one transition to that of the next; the first begins then.
    pub record_ticks: i64,
    /// Ticks that the sea takes to follow.
    pub transition_ticks: i64,
}

impl Replay {
    /// Most records of a sequence: a week of them, hour by hour.
    pub const MAX_RECORDS: usize = 168;

    /// Checks a sequence.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for too many records or a number out of bounds.
    pub fn new(records: Vec<MeasuredSpectrum>, record_s: f64, transition_s: f64) -> Result<Self, SceneError> {
        if !(1..=Self::MAX_RECORDS).contains(&records.len()) {
            let bound = format!("from 2 to {} with the first", Self::MAX_RECORDS + 1);
            return Err(SceneError::bound("measured.replay", format!("{} records", records.len() + 1), bound));
        }
        let ticks = |seconds: f64| (seconds * TICKS_PER_SECOND as f64).round() as i64;
        let record_s = within("measured.replay.record_s", record_s, 1.0, 86_400.0)?;
        let transition_s = within("measured.replay.transition_s", transition_s, 0.0, record_s)?;
        Ok(Self { records, record_ticks: ticks(record_s), transition_ticks: ticks(transition_s) })
    }
}
