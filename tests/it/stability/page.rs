//! `docs/stability.md`, written from the table: `just stability` writes it anew.

use super::table::{CASES, Must};

const HEAD: &str = "# Hard cases

Written by `just stability` from `tests/it/stability/table.rs`; a test holds it to that. Every row is run by `cargo test` on
every backend, at tick 0, after a day, 30 days, ten years, and a second before the last tick there is (on a
GPU foam at the first of them alone: its memory takes software too long). All rows are run, and
so are scenes in which every two hard values of two fields meet (`every_pair_of_hard_values_holds`), scenes in which each
number is NaN, infinite, -0 or subnormal (`any_number_anywhere_is_refused_by_name_or_makes_a_sea_that_holds`), and random
ones (`tests/it/properties.rs`).

*Holds* means: every sample of every field is finite; foam is from 0 to 1; no water is higher than 3 significant heights; the
modes hold no more energy than is wanted; the sea is neither flat nor frozen; every frame can be sent. *Refused* means: before
anything runs, by an error that names the field, its value and its bound.

| case | scene | here | why it is hard, and what happens elsewhere |
|---|---|---|---|
";

/// Hard cases that are no scene, and the tests that hold them.
const ELSEWHERE: &[(&str, &str)] = &[
    (
        "calm to hurricane in 0 s, 1 s, 5 s and 60 s, and again before the first ends",
        "a_calm_becomes_a_hurricane_in_no_time_in_a_second_and_in_a_minute",
    ),
    ("any changes in any order", "no_changes_in_any_order_make_a_sea_higher_than_the_highest_it_is_between"),
    (
        "depth from 20 m to 19.9 m after a day, and another gravity",
        "a_change_of_depth_or_gravity_moves_no_point_more_than_a_frame_does",
    ),
    ("another layout of cascades under way", "a_change_of_layout_moves_no_point_faster_than_a_steady_sea_does"),
    (
        "ten years: phase against an f64 reference with the same integer frequencies",
        "cpu_agrees_with_the_reference_at_once_after_a_day_and_after_ten_years",
    ),
    ("a clock that jumps by hours, either way", "time_may_jump_by_hours_either_way"),
    ("a loop, foam included", "a_loop_closes_to_the_last_bit_foam_included"),
    ("frame rates and foam", "foam_is_the_same_bytes_at_any_frame_rate"),
    (
        "files of a buoy with gaps, 999, and lines that are broken",
        "records_with_gaps_are_read_and_broken_ones_are_refused_by_line",
    ),
    ("NaN, infinities, wrong types and sizes in every request", "every_wrong_request_is_refused_by_name"),
    ("wrong and random messages", "ten_thousand_random_messages_harm_nobody"),
    ("wrong frames, each field in turn", "every_bad_frame_is_refused_for_its_field"),
    ("samples beyond what a count holds, and such that are no number", "what_can_not_be_told_is_flagged_or_refused"),
    ("the program killed in the middle", "killed_and_started_again_it_streams_the_same_sea_byte_for_byte"),
];

fn elsewhere() -> String {
    let row = |(what, test): &(&str, &str)| format!("| {what} | `{test}` |\n");
    ELSEWHERE.iter().map(row).collect()
}

fn page() -> String {
    let row = |case: &super::table::Case| {
        let must = match &case.must {
            Must::Hold => "holds".to_owned(),
            Must::Refuse(field) => format!("refused: `{field}`"),
        };
        let scene = case.scene.split('\n').filter(|line| !line.is_empty()).collect::<Vec<_>>();
        // Long scenes are told by their row alone.
        let scene = if scene.len() > 12 { "many systems".to_owned() } else { format!("`{}`", scene.join(" ")) };
        let scene = if case.scene.is_empty() { "empty".to_owned() } else { scene };
        let why = case.why.split_whitespace().collect::<Vec<_>>().join(" ");
        format!("| {} | {scene} | {must} | {why} |\n", case.what)
    };
    let mut page = HEAD.to_owned();
    page.extend(CASES.iter().map(row));
    page + "\n## Cases that are no scene\n\n| case | held by |\n|---|---|\n" + &elsewhere()
}

#[test]
fn the_page_of_hard_cases_is_what_the_table_says() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/stability.md");
    if std::env::var("SWELLCAST_BLESS").is_ok() {
        std::fs::write(path, page()).unwrap();
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(written == page(), "docs/stability.md is not what the table says; `just stability` writes it");
}

#[test]
fn every_test_that_the_page_names_is_there() {
    let mut sources = String::new();
    let mut folders = vec![std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it"))];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                sources += &std::fs::read_to_string(path).unwrap();
            }
        }
    }
    for (_, test) in ELSEWHERE {
        assert!(sources.contains(&format!("fn {test}()")), "{test}");
    }
}
