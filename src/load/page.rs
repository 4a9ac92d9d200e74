//! A report as one page with plots: no script, nothing fetched.

use std::fmt::Write;

use super::report::{Findings, Report, ReportRow};

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 240.0;
/// Room for what stands beside the axes.
const LEFT: f64 = 64.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 10.0;
const BOTTOM: f64 = 40.0;
/// Most points of a line.
const MOST_POINTS: usize = 1000;

const STYLE: &str = "\
:root { color-scheme: light dark; --a: #0b6e99; --b: #c2410c; --c: #6b7280; --grid: #8884; --wash: #8882 }\n\
@media (prefers-color-scheme: dark) { :root { --a: #5cc3ee; --b: #fb923c; --c: #9ca3af } }\n\
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 84rem; padding: 0 1rem }\n\
h1 { font-size: 1.5rem; margin: 0 0 .25rem } h2 { font-size: 1rem; margin: 0 0 .25rem }\n\
p { margin: .25rem 0 1rem } table { border-collapse: collapse; margin: 1rem 0 2rem }\n\
td, th { padding: .2rem 1rem .2rem 0; border-bottom: 1px solid var(--grid); text-align: left; \
font-variant-numeric: tabular-nums }\n\
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(28rem, 1fr)); gap: 2rem }\n\
figure { margin: 0 } svg { width: 100%; height: auto; overflow: visible } text { font-size: 12px; fill: currentColor }\n\
.grid { stroke: var(--grid) } .wash { fill: var(--wash) } path { fill: none; stroke-width: 1.8 }\n\
.a { stroke: var(--a) } .b { stroke: var(--b) } .c { stroke: var(--c); stroke-dasharray: 5 4 }\n\
.key { display: flex; gap: 1.25rem; font-size: 13px; margin: 0 0 .25rem } .key svg { width: 1.5rem; height: .6rem }\n";

/// A line of a plot: its style, its name, its points.
struct Line {
    style: &'static str,
    name: &'static str,
    points: Vec<(f64, f64)>,
}

/// A plot to be.
struct Plot {
    title: &'static str,
    x: &'static str,
    /// The x axis is by powers of ten.
    log_x: bool,
    lines: Vec<Line>,
    /// A stretch of x that is shaded.
    shade: Option<(f64, f64)>,
}

/// The page of a report.
pub fn page(report: &Report) -> String {
    let mut html = String::new();
    let title = format!("{} clients of {}", report.load.steady.clients, report.scene);
    let verdict =
        if report.holds { "It holds.".to_owned() } else { format!("It does not hold: {}.", report.why.join("; ")) };
    // Writing to a string can't fail.
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n<h1>{title}</h1>\n\
         <p>{} at {}, measured for {:.0} s. <strong>{}</strong></p>\n",
        escape(&report.server),
        escape(&report.url),
        report.seconds,
        escape(&verdict),
        title = escape(&title),
    );
    html += "<div class=\"plots\">\n";
    plots(report).iter().for_each(|plot| html += &plot.figure());
    html += "</div>\n<table>\n";
    if report.calibration.is_some() {
        html += "<tr><th></th><th>server</th><th>calibrator</th></tr>\n";
    }
    for [what, here, there] in report.lines() {
        let _ =
            writeln!(html, "<tr><th>{}</th><td>{}</td><td>{}</td></tr>", escape(&what), escape(&here), escape(&there));
    }
    html += "</table>\n</html>\n";
    html
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn plots(report: &Report) -> Vec<Plot> {
    let load = &report.load;
    let shade = Some((load.window_from_s, load.window_from_s + load.seconds));
    let over_time = |title, lines| Plot { title, x: "seconds", log_x: false, lines, shade };
    let line = |style, name, value: fn(&ReportRow) -> Option<f64>| {
        let points = load.rows.iter().filter_map(|row| Some((row.at_s, value(row)?))).collect();
        Line { style, name, points }
    };
    let shares =
        |findings: &Findings| findings.age_shares.iter().map(|(ms, share)| (ms.max(0.01), share * 1e2)).collect();
    let each = |findings: &Findings| {
        let count = findings.client_mbps.len().max(1) as f64;
        findings.client_mbps.iter().enumerate().map(|(at, mbps)| ((at + 1) as f64 * 1e2 / count, *mbps)).collect()
    };
    let mut ages = vec![Line { style: "a", name: "server", points: shares(load) }];
    let mut clients = vec![Line { style: "a", name: "server", points: each(load) }];
    if let Some(calibration) = &report.calibration {
        ages.push(Line { style: "c", name: "calibrator", points: shares(&calibration.findings) });
        clients.push(Line { style: "c", name: "calibrator", points: each(&calibration.findings) });
    }
    vec![
        over_time(
            "Age of frames, ms",
            vec![line("a", "p50", |row| row.age_p50_ms), line("b", "p99", |row| row.age_p99_ms)],
        ),
        over_time("Received by all clients, Mb/s", vec![line("a", "Mb/s", |row| Some(row.mbps))]),
        Plot { title: "Frames at most so old, %", x: "ms", log_x: true, lines: ages, shade: None },
        Plot {
            title: "Received by a client, Mb/s",
            x: "% of clients, lowest first",
            log_x: false,
            lines: clients,
            shade: None,
        },
        over_time(
            "Processor, cores",
            vec![
                line("a", "server", |row| row.server_cpu),
                line("b", "load test", |row| row.own_cpu),
                line("c", "this machine", |row| row.machine_cpu),
            ],
        ),
        over_time("Memory of the server, MiB", vec![line("a", "resident", |row| row.server_mib)]),
    ]
}

impl Plot {
    fn figure(&self) -> String {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let place = |x: f64| if self.log_x { x.log10() } else { x };
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        points().for_each(|(x, _)| (from, to) = (from.min(place(*x)), to.max(place(*x))));
        (from, to) = if self.log_x { (from.floor(), to.ceil()) } else { (from.min(0.0), to) };
        if to.partial_cmp(&from) != Some(std::cmp::Ordering::Greater) {
            (from, to) = (0.0, 1.0);
        }
        let highest = points().map(|(_, y)| *y).fold(0.0, f64::max);
        let step = step_of(highest);
        let top = ((highest / step).ceil() * step).max(step);
        let x_at = |x: f64| LEFT + (place(x) - from) / (to - from) * (WIDTH - LEFT - RIGHT);
        let y_at = |y: f64| HEIGHT - BOTTOM - y / top * (HEIGHT - TOP - BOTTOM);
        let mut svg = format!("<figure>\n<h2>{}</h2>\n<div class=\"key\">", self.title);
        for Line { style, name, .. } in self.lines.iter().filter(|_| self.lines.len() > 1) {
            // Writing to a string can't fail.
            let _ = write!(
                svg,
                "<span><svg viewBox=\"0 0 24 10\"><path class=\"{style}\" d=\"M0 5H24\"/></svg> {name}</span>"
            );
        }
        let _ =
            write!(svg, "</div>\n<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\n", self.title);
        if let Some((begin, end)) = self.shade {
            let (left, right) = (x_at(begin.max(from)), x_at(end.min(to)));
            let (width, height) = ((right - left).max(0.0), HEIGHT - TOP - BOTTOM);
            let _ = writeln!(
                svg,
                "<rect class=\"wash\" x=\"{left:.1}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height}\">\
                 <title>the measured window</title></rect>"
            );
        }
        for number in 0..=(top / step).round() as usize {
            let (value, y) = (number as f64 * step, y_at(number as f64 * step));
            let _ = writeln!(
                svg,
                "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{}\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                WIDTH - RIGHT,
                LEFT - 8.0,
                y + 4.0,
                short(value, step)
            );
        }
        for (x, label) in self.marks(from, to) {
            let (x, y) = (x_at(x), HEIGHT - BOTTOM + 18.0);
            let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"middle\">{label}</text>");
        }
        let (middle, y) = ((WIDTH + LEFT - RIGHT) / 2.0, HEIGHT - 4.0);
        let _ = writeln!(svg, "<text x=\"{middle}\" y=\"{y}\" text-anchor=\"middle\">{}</text>", self.x);
        for Line { style, points, .. } in &self.lines {
            let each = points.len().div_ceil(MOST_POINTS).max(1);
            let mut path = String::new();
            for (number, (x, y)) in points.iter().enumerate().filter(|(n, _)| n % each == 0 || n + 1 == points.len()) {
                let _ = write!(path, "{}{:.1} {:.1}", if number == 0 { 'M' } else { 'L' }, x_at(*x), y_at(*y));
            }
            let _ = writeln!(svg, "<path class=\"{style}\" d=\"{path}\"/>");
        }
        svg += "</svg>\n</figure>\n";
        svg
    }

    /// Where the x axis is marked, and how.
    fn marks(&self, from: f64, to: f64) -> Vec<(f64, String)> {
        if self.log_x {
            return (from as i32..=to as i32)
                .map(|power| (10f64.powi(power), format!("{}", 10f64.powi(power))))
                .collect();
        }
        let step = step_of(to - from);
        let (first, last) = ((from / step).ceil() as i64, (to / step).floor() as i64);
        (first..=last).map(|number| (number as f64 * step, short(number as f64 * step, step))).collect()
    }
}

/// A round step that cuts a range into four to ten.
fn step_of(range: f64) -> f64 {
    let rough = (range / 5.0).max(1e-6);
    let power = 10f64.powf(rough.log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0].into_iter().find(|round| round * power >= rough * 0.999);
    round.unwrap_or(10.0) * power
}

/// A number with the digits that its step needs.
fn short(value: f64, step: f64) -> String {
    let digits = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}
