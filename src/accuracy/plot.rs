//! Error against cost as a picture in SVG, on paper of its own: dots with names under the pointer, and the front.

use std::io;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::prelude::*;

use super::report::{Axis, Cost, Measure, Point, SERVING};
use super::text::{escape, significant};

const SIZE: (u32, u32) = (900, 460);
/// Width of the list of names.
const LIST: u32 = 190;
const PAPER: RGBColor = RGBColor(250, 250, 247);
const INK: RGBColor = RGBColor(38, 42, 48);
/// Of axes in turn; told apart by most who don't see all colours.
const COLOURS: [RGBColor; 9] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 138, 101),
    RGBColor(180, 82, 140),
    RGBColor(196, 132, 0),
    RGBColor(62, 152, 208),
    RGBColor(110, 110, 110),
    RGBColor(116, 60, 160),
    RGBColor(140, 86, 75),
];
/// Nothing beyond these is drawn.
const DRAWN: Range<f64> = 1e-30..1e30;

type Drawn<T> = Result<T, DrawingAreaErrorKind<io::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A setting.
struct Dot {
    cost: f64,
    /// Quartiles of the cost.
    spread: [f64; 2],
    error: f64,
    front: bool,
    /// Number of its name in the list.
    group: usize,
    /// What is written beside it.
    label: String,
    /// What it says under the pointer.
    name: String,
}

struct Plot<'a> {
    title: String,
    cost: &'a str,
    error: &'a str,
    /// Names of the groups, listed where there are several.
    groups: Vec<&'a str>,
    dots: Vec<Dot>,
}

/// One axis: its error against its cost. Numbers are those of its points,
/// from 1. `None` without points that have both.
pub(super) fn of_axis(axis: &Axis) -> Option<String> {
    let timed = axis.cost == Cost::Time;
    let dot = |(number, point): (usize, &Point)| {
        let mut dot = dot(point, axis.measure, timed)?;
        dot.label = (number + 1).to_string();
        Some(dot)
    };
    let dots = axis.points.iter().enumerate().filter_map(dot).collect();
    let (cost, error) = (if timed { "ms" } else { "kB/s" }, shown(axis.measure).1);
    Plot { title: axis.name.clone(), cost, error, groups: vec![&axis.name], dots }.svg()
}

/// Every point that has an error of height and a time, and the front of the settings that a server can be run at: axes
/// leave out different things, so that there is no one front over all. `None` where there is no such point.
pub(super) fn of_everything(axes: &[Axis]) -> Option<String> {
    let timed = |point: &&Point| point.time.is_some() && point.errors.height_rms.is_some();
    let (mut points, mut groups, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for axis in axes.iter().filter(|axis| axis.points.iter().any(|point| timed(&point))) {
        let named = |point: &Point| Point {
            setting: format!("{}, {}", axis.name, point.setting),
            front: point.front && axis.name == SERVING,
            ..point.clone()
        };
        points.extend(axis.points.iter().filter(timed).map(named));
        groups.resize(points.len(), names.len());
        names.push(axis.name.as_str());
    }
    let dot = |(point, group): (&Point, usize)| Some(Dot { group, ..dot(point, Measure::Height, true)? });
    let dots = points.iter().zip(groups).filter_map(dot).collect();
    let title = "error against time of everything, and the front of what a server can be run at".to_owned();
    Plot { title, cost: "ms", error: shown(Measure::Height).1, groups: names, dots }.svg()
}

/// Factor on an error as it is shown, and what it is then.
fn shown(measure: Measure) -> (f64, &'static str) {
    match measure {
        Measure::Height => (1e2, "height, rms % of Hs"),
        other => (1.0, other.name()),
    }
}

fn dot(point: &Point, measure: Measure, timed: bool) -> Option<Dot> {
    let (factor, what) = shown(measure);
    let error = measure.of(&point.errors)? * factor;
    let (cost, spread, unit) = match timed {
        true => point.time.map(|time| (time.median_ms, [time.lower_ms, time.upper_ms], "ms"))?,
        false => point.bytes_per_s.map(|bytes| (bytes / 1e3, [bytes / 1e3; 2], "kB/s"))?,
    };
    let spread = spread.map(|end| if DRAWN.contains(&end) { end } else { cost });
    let name = format!("{}: {} {what}, {} {unit}", point.setting, significant(error), significant(cost));
    let drawn = DRAWN.contains(&cost) && (error == 0.0 || DRAWN.contains(&error));
    drawn.then(|| Dot { cost, spread, error, front: point.front, group: 0, label: String::new(), name })
}

impl Plot<'_> {
    fn svg(&self) -> Option<String> {
        if self.dots.is_empty() {
            return None;
        }
        let mut svg = String::new();
        let places = self.draw(&mut svg).ok()?;
        let names = places.iter().zip(&self.dots).map(|((x, y), dot)| {
            let title = escape(&dot.name);
            format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"9\" fill=\"transparent\"><title>{title}</title></circle>\n")
        });
        let names: String = names.collect();
        svg.insert_str(svg.rfind("</svg>")?, &names);
        Some(svg)
    }

    /// Draws everything; tells where the dots are, in pixels.
    fn draw(&self, svg: &mut String) -> Drawn<Vec<(i32, i32)>> {
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        root.fill(&PAPER)?;
        let listed = if self.groups.len() > 1 { LIST } else { 0 };
        let (area, list) = root.split_horizontally(SIZE.0 - listed);
        if listed > 0 {
            self.list(&list)?;
        }
        let positive = || self.dots.iter().map(|dot| dot.error).filter(|error| *error > 0.0);
        let exact = self.dots.iter().any(|dot| dot.error == 0.0);
        // Room for what has no place on a logarithmic axis.
        let below = positive().reduce(f64::min).map(|least| if exact { least / 4.0 } else { least });
        let ((x, x_marks), (y, y_marks)) =
            (scale(self.dots.iter().flat_map(|dot| dot.spread)), scale(positive().chain(below)));
        let place = |dot: &Dot| (dot.cost, dot.error.max(y.start));
        let title = if exact { format!("{} (exact ones at the bottom edge)", self.title) } else { self.title.clone() };
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 18).into_font().color(&INK))
            .margin(14)
            .margin_right(34)
            .x_label_area_size(46)
            .y_label_area_size(76)
            .build_cartesian_2d(
                x.log_scale().with_key_points(x_marks),
                y.clone().log_scale().with_key_points(y_marks),
            )?;
        chart
            .configure_mesh()
            .x_desc(self.cost)
            .y_desc(self.error)
            .x_label_formatter(&mark)
            .y_label_formatter(&mark)
            .label_style(("sans-serif", 15).into_font().color(&INK))
            .bold_line_style(INK.mix(0.12))
            .axis_style(INK.mix(0.6))
            .draw()?;
        let mut front: Vec<&Dot> = self.dots.iter().filter(|dot| dot.front).collect();
        front.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        chart.draw_series(LineSeries::new(front.into_iter().map(place), INK.mix(0.5).stroke_width(2)))?;
        let spread = |dot: &Dot| {
            let ends = dot.spread.map(|end| (end, place(dot).1));
            PathElement::new(ends.to_vec(), colour(dot.group).mix(0.6).stroke_width(2))
        };
        chart.draw_series(self.dots.iter().map(spread))?;
        let ring = |dot: &Dot| {
            let (size, style) = match dot.front {
                true => (6, colour(dot.group).filled()),
                false => (4, colour(dot.group).mix(0.7).stroke_width(2)),
            };
            EmptyElement::at(place(dot))
                + Circle::new((0, 0), size, style)
                + Text::new(dot.label.clone(), (8, -15), ("sans-serif", 15).into_font().color(&INK))
        };
        chart.draw_series(self.dots.iter().map(ring))?;
        let places = self.dots.iter().map(|dot| chart.backend_coord(&place(dot))).collect();
        root.present()?;
        Ok(places)
    }

    fn list(&self, area: &Area) -> Drawn<()> {
        for (group, name) in self.groups.iter().enumerate() {
            let y = 50 + 22 * group as i32;
            area.draw(&Circle::new((10, y), 6, colour(group).filled()))?;
            area.draw(&Text::new(*name, (24, y - 8), ("sans-serif", 15).into_font().color(&INK)))?;
        }
        Ok(())
    }
}

fn colour(group: usize) -> RGBColor {
    COLOURS[group % COLOURS.len()]
}

/// A logarithmic range around values, from a round number to a round number, and where it is marked.
fn scale(values: impl Iterator<Item = f64>) -> (Range<f64>, Vec<f64>) {
    let (low, high) = values.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), v| (low.min(v), high.max(v)));
    let (low, high) = if low <= high { (low * 0.9, high * 1.1) } else { (0.1, 1.0) };
    let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let rounds = powers.flat_map(|power| [1, 2, 5].map(|digit| (digit, power)));
    let value = |(digit, power): (i32, i32)| format!("{digit}e{power}").parse().unwrap_or(f64::NAN);
    let rounds: Vec<((i32, i32), f64)> = rounds.map(|round| (round, value(round))).collect();
    let start = rounds.iter().rfind(|(_, value)| *value <= low).map_or(low, |(_, value)| *value);
    let end = rounds.iter().find(|(_, value)| *value >= high).map_or(high, |(_, value)| *value);
    let decades = (end / start).log10();
    let every = (decades / 10.0).ceil() as i32;
    let marked = |(digit, power): (i32, i32)| decades < 4.0 || digit == 1 && power % every == 0;
    let marks = rounds.into_iter().filter(|(round, value)| marked(*round) && (start..=end).contains(value));
    (start..end, marks.map(|(_, value)| value).collect())
}

fn mark(value: &f64) -> String {
    if (1e-3..1e5).contains(value) { value.to_string() } else { format!("{value:e}") }
}
