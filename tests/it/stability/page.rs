//! `docs/stability.md`, written from the table: `just stability` writes it anew.

use super::table::{CASES, Must};

const HEAD: &str = "# Hard cases

Written by `just stability` from `tests/it/stability/table.rs`; a test holds it to that. Every row is run by `cargo test` on
every backend, at tick 0, after a day, 30 days, ten years, and a second before the last tick there is. All rows are run, and
so are scenes in which every two hard values of two fields meet (`every_pair_of_hard_values_holds`), scenes in which each
number is NaN, infinite, -0 or subnormal (`any_number_anywhere_is_refused_by_name_or_makes_a_sea_that_holds`), and random
ones (`tests/it/properties.rs`).

*Holds* means: every sample of every field is finite; foam is from 0 to 1; no water is higher than 3 significant heights; the
modes hold no more energy than is wanted; the sea is neither flat nor frozen; every frame can be sent. *Refused* means: before
anything runs, by an error that names the field, its value and its bound.

| case | scene | here | why it is hard, and what happens elsewhere |
|---|---|---|---|
";

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
    page
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
