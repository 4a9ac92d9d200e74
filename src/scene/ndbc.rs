//! Reading the five spectral wave files of the U.S. National Data Buoy Center.
//!
//! Form: a comment line, then a line per record, `YY MM DD hh mm`, in `.data_spec` a separation frequency, then
//! pairs `value (frequency)`. 999 stands for a missing value.

use thiserror::Error;

use super::{MeasuredBin, MeasuredSpectrum, SceneError, Spread};

/// The file of densities and the four of directions, in this order everywhere.
const EXTENSIONS: [&str; 5] = ["data_spec", "swdir", "swdir2", "swr1", "swr2"];
const MAX_FILE_BYTES: usize = 64 << 20;

/// Why a record can't be read: file, line and what is wrong there.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NdbcError {
    /// A file that can't be opened or is too large.
    #[error("{file}: {reason}")]
    File {
        /// File name.
        file: String,
        /// What the system says.
        reason: String,
    },
    /// A line that is not of the form.
    #[error("{file} line {line}: {reason}")]
    Line {
        /// File name.
        file: String,
        /// Counted from 1.
        line: usize,
        /// What was found and expected.
        reason: String,
    },
    /// No record of that time in a file.
    #[error("{file} has no record of {time}")]
    NoRecord {
        /// File name.
        file: String,
        /// The time asked for.
        time: String,
    },
}

/// The five files of one station, as text.
#[derive(Clone, Debug)]
pub struct NdbcStation {
    name: String,
    files: [String; 5],
}

/// A record of one file: its time and its values by frequency.
type Record = (String, Vec<(f64, f64)>);

impl NdbcStation {
    /// Station 41010, 60 hourly records of June 2020; built in.
    pub fn built_in() -> Self {
        Self {
            name: "41010".to_owned(),
            files: [
                include_str!("presets/ndbc/41010.data_spec").to_owned(),
                include_str!("presets/ndbc/41010.swdir").to_owned(),
                include_str!("presets/ndbc/41010.swdir2").to_owned(),
                include_str!("presets/ndbc/41010.swr1").to_owned(),
                include_str!("presets/ndbc/41010.swr2").to_owned(),
            ],
        }
    }

    /// Reads `<station>.data_spec` and its four companions from a folder.
    ///
    /// # Errors
    /// [`NdbcError::File`] for one that is not there or above 64 MiB.
    pub fn read(directory: &std::path::Path, station: &str) -> Result<Self, NdbcError> {
        let read = |extension: &str| {
            let file = format!("{station}.{extension}");
            let path = directory.join(&file);
            let refuse = |reason: String| NdbcError::File { file: file.clone(), reason };
            let size = std::fs::metadata(&path).map_err(|e| refuse(e.to_string()))?.len();
            if size > MAX_FILE_BYTES as u64 {
                return Err(refuse(format!("{size} bytes, must be at most {MAX_FILE_BYTES}")));
            }
            std::fs::read_to_string(&path).map_err(|e| refuse(e.to_string()))
        };
        let [a, b, c, d, e] = EXTENSIONS.map(read);
        Ok(Self { name: station.to_owned(), files: [a?, b?, c?, d?, e?] })
    }

    /// The files from their texts, in the order of `data_spec`, `swdir`, `swdir2`, `swr1`, `swr2`.
    pub fn from_texts(name: &str, files: [String; 5]) -> Self {
        Self { name: name.to_owned(), files }
    }

    /// Times of the records, `YYYY-MM-DDThh:mm` (UTC), in the order of the file (newest first).
    ///
    /// # Errors
    /// [`NdbcError::Line`] for a line that is not of the form.
    pub fn times(&self) -> Result<Vec<String>, NdbcError> {
        self.lines(0).map(|(line, text)| Ok(self.record(0, line, text)?.0)).collect()
    }

    /// The record of `time`, or the newest.
    ///
    /// # Errors
    /// [`NdbcError`] when a file lacks that record or can't be read, [`SceneError::Bound`] when its numbers
    /// are out of bounds.
    pub fn spectrum(&self, time: Option<&str>) -> Result<MeasuredSpectrum, SceneError> {
        let (time, density) = self.find(0, time)?;
        let mut directions = Vec::with_capacity(4);
        for file in 1..5 {
            directions.push(self.find(file, Some(&time))?.1);
        }
        // Directional files may lack a frequency; it is then missing, as 999 is.
        let at = |file: usize, frequency: f64| {
            directions[file].iter().find(|(f, _)| *f == frequency).map(|(_, v)| *v).filter(|v| *v < 999.0)
        };
        let bins = density.into_iter().filter(|(_, density)| *density < 999.0).map(|(frequency_hz, density)| {
            let spread = (|| {
                Some(Spread {
                    alpha1_deg: at(0, frequency_hz)?,
                    alpha2_deg: at(1, frequency_hz)?,
                    r1: at(2, frequency_hz)?,
                    r2: at(3, frequency_hz)?,
                })
            })();
            MeasuredBin { frequency_hz, density, direction: spread }
        });
        MeasuredSpectrum::new(bins.collect())
    }

    fn file_name(&self, file: usize) -> String {
        format!("{}.{}", self.name, EXTENSIONS[file])
    }

    fn lines(&self, file: usize) -> impl Iterator<Item = (usize, &str)> {
        let numbered = self.files[file].lines().enumerate().map(|(i, text)| (i + 1, text.trim()));
        numbered.filter(|(_, text)| !text.is_empty() && !text.starts_with('#'))
    }

    fn find(&self, file: usize, time: Option<&str>) -> Result<Record, NdbcError> {
        for (line, text) in self.lines(file) {
            let record = self.record(file, line, text)?;
            if time.is_none_or(|time| time == record.0) {
                return Ok(record);
            }
        }
        Err(NdbcError::NoRecord { file: self.file_name(file), time: time.unwrap_or("any time").to_owned() })
    }

    fn record(&self, file: usize, line: usize, text: &str) -> Result<Record, NdbcError> {
        let refuse = |reason: String| NdbcError::Line { file: self.file_name(file), line, reason };
        let mut words = text.split_ascii_whitespace();
        let mut stamp = [0_u32; 5];
        for (part, what) in stamp.iter_mut().zip(["year", "month", "day", "hour", "minute"]) {
            let word = words.next().unwrap_or_default();
            *part = word.parse().map_err(|_| refuse(format!("{what} is {word:?}, must be a whole number")))?;
        }
        let [year, month, day, hour, minute] = stamp;
        let time = format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}");
        if file == 0 {
            words.next();
        }
        let number = |word: &str, what: &str| {
            let value = word.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| refuse(format!("{what} is {word:?}, must be a finite number")))
        };
        let mut values = Vec::new();
        while let Some(word) = words.next() {
            let frequency = words.next().unwrap_or_default().trim_start_matches('(').trim_end_matches(')');
            values.push((number(frequency, "frequency")?, number(word, "value")?));
            if values.len() > MeasuredSpectrum::MAX_BINS {
                return Err(refuse(format!("more than {} frequencies", MeasuredSpectrum::MAX_BINS)));
            }
        }
        Ok((time, values))
    }
}
