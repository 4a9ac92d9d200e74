//! `[measured]` of a scene file: a record of an NDBC station or its numbers, and records that follow it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::scene::bound::SceneError;
use crate::scene::{DirectionMethod, MeasuredBin, MeasuredSpectrum, NdbcStation, Replay, Spread};

/// `[measured]`: a record of an NDBC station, or its numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct MeasuredFile {
    /// Station whose files to read; `41010` without a directory is built in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<String>,
    /// Folder of the files, relative to the scene file. Only scene files may name one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<String>,
    /// `YYYY-MM-DDThh:mm` (UTC); absent: the newest record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// In place of a station: rows of frequency (Hz), density (m^2/Hz), and alpha1, alpha2 (degrees), r1, r2, or
    /// the first two numbers alone where the direction is missing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bins: Vec<Vec<f64>>,
    /// How directions are made of four numbers a frequency.
    pub directions: DirectionMethod,
    /// Records that follow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replay: Option<ReplayFile>,
}

/// `[measured.replay]`: the records of the station after `time`, one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ReplayFile {
    /// Time of the last record, as `measured.time`; absent: the newest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<String>,
    /// Seconds from one record to the next.
    pub record_s: f64,
    /// Seconds that the sea takes to follow.
    pub transition_s: f64,
    /// In place of a station's: the bins of each record.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub records: Vec<Vec<Vec<f64>>>,
}

impl Default for ReplayFile {
    fn default() -> Self {
        Self { until: None, record_s: 3600.0, transition_s: 600.0, records: Vec::new() }
    }
}

impl MeasuredFile {
    /// The first record, and those that follow it.
    ///
    /// # Errors
    /// [`SceneError`] for the first number out of bounds, or a file that can't be read.
    pub fn check(self, base: Option<&Path>) -> Result<(MeasuredSpectrum, Option<Replay>), SceneError> {
        let station = match (&self.station, &self.directory, self.bins.is_empty()) {
            (None, None, false) => None,
            (Some(station), Some(directory), true) => Some(read(base, directory, station)?),
            (Some(station), None, true) if station == "41010" => Some(NdbcStation::built_in()),
            (Some(station), None, true) => {
                return Err(SceneError::bound("measured.station", station, "41010, or name a directory"));
            }
            _ => return Err(SceneError::bound("measured", "neither or both", "either a station or bins")),
        };
        let Some(station) = station else {
            let first = spectrum(&self.bins, self.directions)?;
            let replay = self.replay.map(|file| file.of_numbers(self.directions)).transpose()?;
            return Ok((first, replay));
        };
        let first = station.spectrum(self.time.as_deref())?.with_directions(self.directions);
        let replay = self.replay.map(|file| file.of_station(&station, self.time.as_deref(), self.directions));
        Ok((first, replay.transpose()?))
    }
}

impl ReplayFile {
    fn of_numbers(self, directions: DirectionMethod) -> Result<Replay, SceneError> {
        if let Some(until) = self.until {
            return Err(SceneError::bound("measured.replay.until", until, "absent where records stand as numbers"));
        }
        let records = self.records.iter().map(|rows| spectrum(rows, directions)).collect::<Result<_, _>>()?;
        Replay::new(records, self.record_s, self.transition_s)
    }

    fn of_station(
        self,
        station: &NdbcStation,
        from: Option<&str>,
        directions: DirectionMethod,
    ) -> Result<Replay, SceneError> {
        if !self.records.is_empty() {
            return Err(SceneError::bound("measured.replay.records", "given", "absent where a station is named"));
        }
        let Some(from) = from else {
            return Err(SceneError::bound("measured.time", "absent", "there, where records follow"));
        };
        let mut times = station.times()?;
        // ISO times sort as they come.
        times.sort();
        times.dedup();
        times.retain(|time| time.as_str() > from && self.until.as_ref().is_none_or(|until| time <= until));
        let record = |time: &String| Ok(station.spectrum(Some(time))?.with_directions(directions));
        let records = times.iter().map(record).collect::<Result<_, SceneError>>()?;
        Replay::new(records, self.record_s, self.transition_s)
    }
}

fn read(base: Option<&Path>, directory: &str, station: &str) -> Result<NdbcStation, SceneError> {
    let Some(base) = base else {
        let bound = "absent here: only a scene file may name one";
        return Err(SceneError::bound("measured.directory", directory, bound));
    };
    if station.is_empty() || !station.bytes().all(|b| b.is_ascii_alphanumeric()) {
        return Err(SceneError::bound("measured.station", format!("{station:?}"), "letters and digits"));
    }
    Ok(NdbcStation::read(&base.join(directory), station)?)
}

fn spectrum(rows: &[Vec<f64>], directions: DirectionMethod) -> Result<MeasuredSpectrum, SceneError> {
    let bins = rows.iter().map(|row| bin(row)).collect::<Result<Vec<_>, _>>()?;
    Ok(MeasuredSpectrum::new(bins)?.with_directions(directions))
}

fn bin(row: &[f64]) -> Result<MeasuredBin, SceneError> {
    match *row {
        [frequency_hz, density] => Ok(MeasuredBin { frequency_hz, density, direction: None }),
        [frequency_hz, density, alpha1_deg, alpha2_deg, r1, r2] => {
            Ok(MeasuredBin { frequency_hz, density, direction: Some(Spread { alpha1_deg, alpha2_deg, r1, r2 }) })
        }
        _ => Err(SceneError::bound("measured.bins", format!("a row of {}", row.len()), "rows of 2 or 6 numbers")),
    }
}
