//! A sequence of measured records that follow one another.

use std::sync::Arc;

use super::bound::{SceneError, within};
use super::measured::MeasuredSpectrum;
use super::surface::CascadeRequest;
use crate::wire::TICKS_PER_SECOND;

/// Records after the first, which is the scene's own; the sea stays with the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// In the order they come; shared, since every state of the sea carries them along.
    pub records: Arc<[MeasuredSpectrum]>,
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
            let bound = format!("from 1 to {}", Self::MAX_RECORDS);
            return Err(SceneError::bound("measured.replay", format!("{} records that follow", records.len()), bound));
        }
        let ticks = |seconds: f64| (seconds * TICKS_PER_SECOND as f64).round() as i64;
        let record_s = within("measured.replay.record_s", record_s, 1.0, 86_400.0)?;
        let transition_s = within("measured.replay.transition_s", transition_s, 0.0, record_s)?;
        Ok(Self { records: records.into(), record_ticks: ticks(record_s), transition_ticks: ticks(transition_s) })
    }

    /// Checks that tables of all records fit into memory beside each other: 400 MB.
    ///
    /// # Errors
    /// [`SceneError::Bound`] when records and cascades together are too many.
    pub fn check_size(&self, cascades: &CascadeRequest) -> Result<(), SceneError> {
        const MOST: f64 = 5e7;
        let (patches, n, band_limit) = match cascades {
            CascadeRequest::Automatic { n, band_limit, .. } => (CascadeRequest::MAX_PATCHES, *n, *band_limit),
            CascadeRequest::Chosen { patches, band_limit } => {
                (patches.len(), patches.first().map(|p| p.n), *band_limit)
            }
        };
        let modes = patches as f64 * CascadeRequest::modes(n.unwrap_or(CascadeRequest::USUAL_N), band_limit);
        if modes * self.records.len() as f64 > MOST {
            let value = format!("{} records of {modes:.0} modes", self.records.len());
            return Err(SceneError::bound("measured.replay", value, format!("at most {MOST:.0} together")));
        }
        Ok(())
    }

    /// The ticks at which the records' transitions begin, in order.
    pub fn ticks(&self) -> impl Iterator<Item = i64> {
        (1..=self.records.len() as i64).map(|i| i * self.record_ticks)
    }
}
