//! The five files of a buoy: they are refused, or every record in them is a sea of finite energy.
#![no_main]

use std::f64::consts::TAU;

use libfuzzer_sys::fuzz_target;
use swellcast::scene::{MeasuredSpectrum, NdbcStation};
use swellcast::sea::MeasuredSea;

/// Stands between the files of an input: a form feed, which no file of a station holds.
const BETWEEN: char = '\u{c}';
/// Records looked at; each is looked for from the top of every file.
const RECORDS: usize = 16;

fuzz_target!(|text: &str| {
    let mut parts = text.split(BETWEEN);
    let files = std::array::from_fn(|_| parts.next().unwrap_or_default().to_owned());
    let station = NdbcStation::from_texts("X", files);
    let newest = station.spectrum(None);
    if let Ok(record) = &newest {
        holds(record);
    }
    let Ok(times) = station.times() else { return };
    if times.is_empty() {
        assert!(newest.is_err(), "a record out of no records");
    }
    for (i, time) in times.iter().take(RECORDS).enumerate() {
        let record = station.spectrum(Some(time));
        if i == 0 {
            assert_eq!(record, newest, "the first of the file is the newest");
        }
        if let Ok(record) = &record {
            holds(record);
        }
    }
});

/// What every record that is accepted must be.
fn holds(record: &MeasuredSpectrum) {
    let bins = record.bins();
    assert!(record.m0().is_finite() && record.m0() >= 0.0, "m0 is {}", record.m0());
    assert!(record.peak_hz() > 0.0 && record.peak_hz() <= 100.0, "peak is {}", record.peak_hz());
    assert!(bins.is_sorted_by(|a, b| a.frequency_hz < b.frequency_hz));
    let sea = MeasuredSea::new(record);
    let (first, last) = sea.range();
    assert!(first > 0.0 && first < last && last.is_finite(), "from {first} to {last} rad/s");
    assert!(sea.infeasible() <= bins.len() && sea.missing() <= bins.len());
    // At some bins, between them, at the ends and beyond.
    let at_bins = bins.iter().step_by(1 + bins.len() / 16).map(|bin| TAU * bin.frequency_hz);
    let across = (0..=16).map(|i| first + (last - first) * f64::from(i) / 16.0);
    for omega in at_bins.chain(across).chain([0.0, 0.5 * first, 2.0 * last, f64::INFINITY]) {
        for direction in 0..7 {
            let angle = TAU * f64::from(direction) / 7.0;
            let density = sea.density(omega, (angle.cos(), angle.sin()));
            assert!(density.is_finite() && density >= 0.0, "density {density} at {omega} rad/s, {angle} rad");
        }
    }
}
