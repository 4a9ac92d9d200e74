//! A report as one page: plots, tables and pictures; no script, nothing fetched.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::image::Image;
use super::picture::{Picture, Pictures};
use super::plot;
use super::report::{Axis, Report};
use super::table;
use super::text::{escape, significant};

const STYLE: &str = "\
:root { color-scheme: light dark; --grid: #8884; --wash: #8882 }\n\
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 84rem; padding: 0 1rem }\n\
h1 { font-size: 1.5rem; margin: 0 0 .25rem } h2 { font-size: 1.15rem; margin: 2.5rem 0 .25rem }\n\
p { margin: .25rem 0 1rem; max-width: 48rem } figure { margin: 0 }\n\
svg { display: block; max-width: 100%; height: auto; border-radius: 6px } circle:hover { stroke: #262a30; stroke-width: 1.5 }\n\
.scroll { overflow-x: auto } table { border-collapse: collapse; margin: 1rem 0 }\n\
td, th { padding: .2rem 0 .2rem 1.25rem; border-bottom: 1px solid var(--grid); text-align: right; white-space: nowrap; \
font-variant-numeric: tabular-nums } :is(td, th):first-child { padding-left: 0; text-align: left } td.words { text-align: left; \
white-space: normal } .front td { font-weight: 650; background: var(--wash) }\n\
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(15rem, 1fr)); gap: 1rem }\n\
img { outline: 1px solid var(--grid); width: 100%; height: auto; display: block; margin-bottom: .5rem } figcaption { font-size: 13px }\n";

const HOW: &str = "Heights, displaced positions and normals of the same particles are compared with those of the same sea \
summed in double precision. Times are medians of rounds in which all settings take turns, with their quartiles. A setting \
is on the front (bold, joined by a line) when no other is both more accurate and cheaper. Point at a dot to read its \
setting; its number is that of the row below.";

/// The page of a report.
pub fn page(report: &Report, pictures: &Pictures) -> String {
    let title = escape(&format!("What accuracy costs in {}", report.scene));
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n\
         </head>\n<body>\n<h1>{title}</h1>\n<p>{HOW}</p>\n"
    );
    html += "<table>\n";
    for [what, value] in table::notes(report) {
        // Writing to a string can't fail.
        let _ = writeln!(html, "<tr><th>{}</th><td class=\"words\">{}</td></tr>", escape(&what), escape(&value));
    }
    html += "</table>\n";
    html += &plot::of_everything(&report.axes).map(figure).unwrap_or_default();
    report.axes.iter().for_each(|axis| html += &section(axis));
    if !report.stages.is_empty() {
        html += "<h2>stages</h2>\n<p>Where a step's time goes: milliseconds (quartiles) of each stage of the CPU, for one \
                 cascade, on one thread, by samples a side.</p>\n";
        html += &rows(&table::stage_rows(report), |_| false);
    }
    html += &side_by_side(pictures);
    html += "</body>\n</html>\n";
    html
}

/// One axis: what it is, its plot, its table.
fn section(axis: &Axis) -> String {
    let plot = plot::of_axis(axis).map(figure).unwrap_or_default();
    let mut cells = table::rows(axis);
    for (number, row) in cells.iter_mut().enumerate() {
        if number > 0 {
            row[0] = format!("{number}. {}", row[0]);
        }
        // Bold says as much as the star.
        row.pop();
    }
    let table = rows(&cells, |row| axis.points.get(row).is_some_and(|point| point.front));
    format!("<h2>{}</h2>\n<p>{}</p>\n{plot}{table}", escape(&axis.name), escape(&axis.about))
}

fn figure(svg: String) -> String {
    format!("<figure>\n{svg}</figure>\n")
}

/// A table; the first row has its headings, `front` says which of the others stand out.
fn rows(cells: &[Vec<String>], front: impl Fn(usize) -> bool) -> String {
    let mut html = "<div class=\"scroll\"><table>\n".to_owned();
    for (number, row) in cells.iter().enumerate() {
        let cell = if number == 0 { "th" } else { "td" };
        html += if number > 0 && front(number - 1) { "<tr class=\"front\">" } else { "<tr>" };
        row.iter().for_each(|text| html += &format!("<{cell}>{}</{cell}>", escape(text)));
        html += "</tr>\n";
    }
    html + "</table></div>\n"
}

fn side_by_side(pictures: &Pictures) -> String {
    let Pictures { side_m, scale_mm, pictures } = pictures;
    let figure = |Picture { setting, water, difference, off_mm: [rms, most] }: &Picture| {
        let (water, difference) = (img(water, setting), img(difference, "difference of height"));
        let off = format!("heights off by {} mm rms, {} mm at most", significant(*rms), significant(*most));
        format!("<figure>{water}{difference}<figcaption>{}<br>{off}</figcaption></figure>\n", escape(setting))
    };
    let figures: String = pictures.iter().map(figure).collect();
    format!(
        "<h2>pictures</h2>\n<p>The same sea at the same tick, {} m across, seen from above. Below each, how far its heights \
         are from those of the first: white is none, red {scale_mm} mm too high or more, blue {scale_mm} mm too low or \
         more; half as deep a colour is a quarter of that.</p>\n<div class=\"pictures\">\n{figures}</div>\n",
        significant(*side_m)
    )
}

fn img(image: &Image, what: &str) -> String {
    let Image { width, height, .. } = image;
    let (data, what) = (STANDARD.encode(image.png()), escape(what));
    format!("<img src=\"data:image/png;base64,{data}\" width=\"{width}\" height=\"{height}\" alt=\"{what}\">")
}
