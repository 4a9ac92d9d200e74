//! A report as tables of text: one for each axis, and one of the stages.

use super::report::{Axis, Point, Report, STAGES};
use super::text::significant;
use crate::engine::Times;
use crate::wire::TICKS_PER_SECOND;

/// What stands in place of a number that was not measured.
const UNKNOWN: &str = "-";

/// A column of an axis: its heading, and what it shows of a point.
type Column = (&'static str, fn(&Point) -> Option<String>);

const COLUMNS: [Column; 8] = [
    ("height rms, % of Hs", |point| Some(significant(point.errors.height_rms? * 1e2))),
    ("max, %", |point| Some(significant(point.errors.height_max? * 1e2))),
    ("position rms, mm", |point| point.errors.position_mm.map(significant)),
    ("normal rms (p99), deg", |point| {
        let p99 = point.errors.normal_p99_deg.map(|p99| format!(" ({})", significant(p99)));
        Some(significant(point.errors.normal_deg?) + &p99.unwrap_or_default())
    }),
    ("foam rms / coverage", |point| {
        let known = [point.errors.foam, point.errors.foam_coverage];
        let shown = known.map(|error| error.map_or(UNKNOWN.to_owned(), significant));
        known.iter().any(Option::is_some).then(|| shown.join(" / "))
    }),
    ("time (quartiles), ms", |point| point.time.map(time)),
    ("bandwidth", |point| point.bytes_per_s.map(bandwidth)),
    ("memory, MB", |point| point.memory_bytes.map(|bytes| significant(bytes as f64 / 1e6))),
];

/// The whole report for a terminal.
pub fn table(report: &Report) -> String {
    let mut text = String::new();
    for axis in &report.axes {
        text += &format!("{}: {}\n{}\n", axis.name, axis.about, aligned(&rows(axis)));
    }
    if !report.stages.is_empty() {
        text += &format!("stages, ms (quartiles)\n{}\n", aligned(&stage_rows(report)));
    }
    notes(report).iter().for_each(|[what, value]| text += &format!("{what}: {value}\n"));
    text
}

/// Cells of an axis, headings first: the setting, what any of its points has, and a star on the front.
pub(super) fn rows(axis: &Axis) -> Vec<Vec<String>> {
    let known = |(_, show): &&Column| axis.points.iter().any(|point| show(point).is_some());
    let columns: Vec<&Column> = COLUMNS.iter().filter(known).collect();
    let headings = columns.iter().map(|(heading, _)| (*heading).to_owned());
    let row = |point: &Point| {
        let cells = columns.iter().map(|(_, show)| show(point).unwrap_or(UNKNOWN.to_owned()));
        let star = if point.front { "*" } else { "" };
        [point.setting.clone()].into_iter().chain(cells).chain([star.to_owned()]).collect()
    };
    let headings = ["setting".to_owned()].into_iter().chain(headings).chain([String::new()]).collect();
    [headings].into_iter().chain(axis.points.iter().map(row)).collect()
}

/// Cells of the stages, headings first.
pub(super) fn stage_rows(report: &Report) -> Vec<Vec<String>> {
    let headings = ["N"].iter().chain(&STAGES).map(|heading| (*heading).to_owned()).collect();
    let rows = report.stages.iter().map(|row| [row.n.to_string()].into_iter().chain(row.times.map(time)).collect());
    [headings].into_iter().chain(rows).collect()
}

/// What was measured, and on what: names and values.
pub(super) fn notes(report: &Report) -> Vec<[String; 2]> {
    let Report { scene, hs_m, seed, tick, machine, took_s, .. } = report;
    let seconds = significant(*tick as f64 / TICKS_PER_SECOND as f64);
    let adapter = machine.adapter.as_ref().map(|adapter| format!("; GPU {adapter}")).unwrap_or_default();
    let quick = if report.quick { ", quick: fewer settings and rounds" } else { "" };
    let mut notes = vec![
        ["machine".to_owned(), format!("{}, {} cores{adapter}", machine.processor, machine.cores)],
        ["scene".to_owned(), format!("{scene}, Hs {} m, seed {seed}, tick {tick} ({seconds} s)", significant(*hs_m))],
        ["took".to_owned(), format!("{took_s:.0} s{quick}")],
    ];
    notes.extend(report.left_out.iter().map(|what| ["left out".to_owned(), what.clone()]));
    notes
}

/// Milliseconds.
pub(super) fn time(Times { median_ms, lower_ms, upper_ms, .. }: Times) -> String {
    format!("{} ({} to {})", significant(median_ms), significant(lower_ms), significant(upper_ms))
}

/// Bytes a second, with the unit.
pub(super) fn bandwidth(bytes_per_s: f64) -> String {
    let (unit, name) = if bytes_per_s < 1e6 { (1e3, "kB/s") } else { (1e6, "MB/s") };
    format!("{} {name}", significant(bytes_per_s / unit))
}

/// Rows under each other: the first column begins at the left, the others end at the right.
fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let wide = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| wide(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(column, (cell, width))| match column {
            0 => format!("{cell:width$}"),
            _ => format!("{cell:>width$}"),
        });
        format!("  {}", cells.collect::<Vec<_>>().join("  ")).trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}
