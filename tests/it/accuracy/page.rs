//! Laws of how a report is told: a page that is well formed, a table with a line for every point, pictures that are the
//! same each time.

use std::process::Command;

use swellcast::accuracy::{
    Axis, Cost, Errors, Image, Machine, Measure, Pictures, Point, Report, STAGES, StageRow, page, pictures, table,
};
use swellcast::engine::Times;

const AWKWARD: &str = "<b>&\"'";

fn times(median_ms: f64) -> Times {
    Times { median_ms, lower_ms: median_ms * 0.9, upper_ms: median_ms * 1.2, p95_ms: median_ms * 2.0 }
}

/// A point with an error of height and a cost: a time, or bytes a second.
fn point(setting: &str, height_rms: Option<f64>, ms: Option<f64>, bytes_per_s: Option<f64>) -> Point {
    let errors = Errors { height_rms, position_mm: height_rms.map(|error| error * 1e3), ..Errors::default() };
    Point { setting: setting.to_owned(), errors, time: ms.map(times), bytes_per_s, memory_bytes: None, front: false }
}

fn axis(name: &str, measure: Measure, points: Vec<Point>) -> Axis {
    let cost = if points.iter().any(|point| point.time.is_some()) { Cost::Time } else { Cost::Bytes };
    let mut axis = Axis { name: name.to_owned(), about: format!("about {name}"), measure, cost, points };
    axis.mark_front();
    axis
}

/// Awkward in every way that a report may be.
fn report() -> Report {
    let grids = vec![
        point("a", Some(1e-7), Some(8.3), None),
        point(AWKWARD, Some(0.02), Some(0.31), None),
        point("no time", Some(0.1), None, None),
        point("no error", None, Some(2.0), None),
        point("no time passes", Some(0.3), Some(0.0), None),
        Point { memory_bytes: Some(12_345_678), ..point("exact", Some(0.0), Some(40.0), Some(1.2e6)) },
    ];
    let classes = vec![point("fine", Some(1e-4), None, Some(3.2e6)), point("coarse", Some(1e-2), None, Some(81e3))];
    Report {
        scene: format!("scene {AWKWARD}"),
        hs_m: 2.71,
        seed: 7,
        tick: 36_000,
        machine: Machine { processor: format!("processor {AWKWARD}"), cores: 2, adapter: Some(AWKWARD.to_owned()) },
        quick: true,
        took_s: 1.5,
        axes: vec![
            axis(&format!("grids {AWKWARD}"), Measure::Height, grids),
            axis("classes", Measure::Position, classes),
            axis("one", Measure::Height, vec![point("only", Some(0.01), Some(1.0), None)]),
            axis("one, exact", Measure::Height, vec![point("only", Some(0.0), Some(1.0), None)]),
            axis("none", Measure::Foam, Vec::new()),
            axis("nothing known", Measure::Normal, vec![point("unknown", None, None, None)]),
        ],
        stages: [64, 128].map(|n| StageRow { n, times: [times(n as f64 / 1e3); STAGES.len()] }).into(),
        left_out: vec![format!("left {AWKWARD}")],
    }
}

fn no_pictures() -> Pictures {
    Pictures { side_m: 100.0, scale_mm: 50.0, pictures: Vec::new() }
}

/// Holds that every element that begins ends, in order.
fn holds_together(html: &str) {
    let mut open = Vec::new();
    for tag in html.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').unwrap_or_else(|| panic!("<{tag} has no end"));
        let name = tag.split([' ', '\n']).next().unwrap();
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "</{name}> ends what it did not begin"),
            None if tag.ends_with('/') || ["!doctype", "meta", "img", "br"].contains(&name) => {}
            None => open.push(name),
        }
    }
    assert_eq!(open, Vec::<&str>::new(), "all that begins ends");
}

#[test]
fn a_page_is_well_formed_whatever_was_found() {
    let report = report();
    let html = page(&report, &no_pictures());
    holds_together(&html);
    assert!(!html.contains("<b>") && !html.contains("&\""), "names are escaped");
    assert!(html.contains("&lt;b&gt;&amp;&quot;"));
    for axis in &report.axes {
        let name = axis.name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
        assert!(html.contains(&format!("<h2>{name}</h2>")), "{name}");
    }
    assert!(!html.contains("<script") && !html.contains("src=\"http"), "nothing is fetched");

    let plots: Vec<&str> = html.split("<svg").skip(1).map(|rest| rest.split_once("</svg>").unwrap().0).collect();
    let names: Vec<usize> = plots.iter().map(|plot| plot.matches("<title>").count()).collect();
    // Of everything with a time, then axis by axis; those without a point that can be drawn have no plot.
    assert_eq!(names, [5, 3, 2, 1, 1]);
    for plot in plots {
        let text = plot.to_lowercase();
        assert!(!text.contains("nan") && !text.contains("inf"), "{plot}");
    }
}

#[test]
fn a_report_of_nothing_has_a_page_and_a_table() {
    let report = Report { axes: Vec::new(), stages: Vec::new(), left_out: Vec::new(), ..report() };
    let html = page(&report, &no_pictures());
    holds_together(&html);
    assert!(!html.contains("<svg"));
    assert_eq!(table(&report).lines().count(), 3, "{}", table(&report));
}

#[test]
fn a_table_has_a_line_for_every_point() {
    let report = report();
    let text = table(&report);
    for axis in &report.axes {
        let (_, block) = text.split_once(&format!("{}: {}\n", axis.name, axis.about)).unwrap();
        let block: Vec<&str> = block.split("\n\n").next().unwrap().lines().collect();
        assert_eq!(block.len(), 1 + axis.points.len(), "{block:#?}");
        for (line, point) in block[1..].iter().zip(&axis.points) {
            assert!(line.trim_start().starts_with(&point.setting), "{line}");
            assert_eq!(line.ends_with('*'), point.front, "{line}");
        }
    }
    let grids = text.lines().find(|line| line.contains("exact")).unwrap();
    let cells: Vec<&str> = grids.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
    assert_eq!(cells, ["exact", "0", "0", "40.0 (36.0 to 48.0)", "1.20 MB/s", "12.3", "*"]);
    assert!(!text.contains("foam rms"), "no point has an error of foam");
    assert!(text.contains("left out: left"));
}

#[test]
fn a_report_reads_back_equal() {
    let report = report();
    let text = serde_json::to_string(&report).unwrap();
    assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report);
}

fn white(image: &Image) -> bool {
    image.pixels.iter().all(|byte| *byte == 255)
}

#[test]
fn pictures_are_the_same_each_time_and_show_what_is_lost() {
    let scene = swellcast::scene::preset("beaufort-5").unwrap();
    let side = 48;
    let seen = pictures(&scene, 72_000, side).unwrap();
    assert_eq!(seen, pictures(&scene, 72_000, side).unwrap());
    assert_eq!(seen.pictures.len(), 4);
    let (best, others) = seen.pictures.split_first().unwrap();
    assert!(white(&best.difference) && best.off_mm == [0.0, 0.0], "the best is itself");
    for picture in others {
        let [rms, most] = picture.off_mm;
        assert!(!white(&picture.difference) && 0.0 < rms && rms < most, "{}: {rms}, {most}", picture.setting);
        assert_ne!(picture.water, best.water, "{}", picture.setting);
    }
    // What is cut off is more than what is rounded; counts of 20 mm err by no more than that in each cascade.
    let [coarse, longest, counted] = [0, 1, 2].map(|at| others[at].off_mm[0]);
    assert!(counted < coarse && coarse < longest, "{counted}, {coarse}, {longest}");

    let png = best.water.png();
    let mut decoder = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
    let info = decoder.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (side as u32, side as u32));
    assert_eq!(pixels, best.water.pixels);

    let still = seen.still();
    assert_eq!((still.width, still.height, still.pixels.len()), (1200, 500, 1200 * 500 * 3));
    let html = page(&report(), &seen);
    holds_together(&html);
    assert_eq!(html.matches("data:image/png;base64,").count(), 8);
}

fn program(arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_swellcast")).arg("accuracy").args(arguments).output().unwrap()
}

#[test]
fn a_file_that_cannot_be_written_is_told_before_anything_is_measured() {
    for option in ["--json", "--html", "--still"] {
        let output = program(&[option, "/nowhere/at/all"]);
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && told.contains("can't write /nowhere/at/all"), "{told}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(program(&["--budget-ms", "0"]).status.code(), Some(2));
}
