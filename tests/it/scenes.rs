//! Scene files: what is refused names its field, its value and its bound.

use std::path::Path;

use swellcast::scene::{NdbcStation, SceneError, SceneFile};

#[test]
fn every_number_out_of_bounds_is_refused_by_name() {
    let wind = |line: &str| format!("[wind]\n{line}\n");
    let cascades = |line: &str| format!("[cascades]\n{line}\n");
    for (text, field) in [
        ("name = \"Not Plain\"".to_owned(), "name"),
        ("loop_s = 0.5".to_owned(), "loop_s"),
        ("loop_s = 1.00001".to_owned(), "loop_s"),
        ("[water]\ndepth_m = 0".to_owned(), "water.depth_m"),
        ("[water]\ndepth_m = nan".to_owned(), "water.depth_m"),
        ("[water]\ngravity = inf".to_owned(), "water.gravity"),
        (wind("speed_mps = -1"), "wind.speed_mps"),
        (wind("speed_mps = 21"), "wind.speed_mps"),
        (wind("speed_mps = nan"), "wind.speed_mps"),
        (wind("fetch_m = 1e9"), "wind.fetch_m"),
        (wind("gamma = 0.9"), "wind.gamma"),
        (wind("swell = 1.1"), "wind.swell"),
        (wind("range_mps = [9.0, 3.0]"), "wind.range_mps"),
        (wind("direction_from_deg = 1e300"), "wind.direction_from_deg"),
        ("[[swell]]\n[[swell]]\nhs_m = 31".to_owned(), "swell[1].hs_m"),
        ("[measured]".to_owned(), "measured"),
        ("[measured]\nbins = [[0.1, 1.0], [0.1, 1.0]]".to_owned(), "measured.bins[1].frequency_hz"),
        ("[measured]\nbins = [[0.1, 1.0], [0.2, 1.0, 3.0]]".to_owned(), "measured.bins"),
        ("[measured]\nstation = \"41010\"\ndirectory = \"/etc\"".to_owned(), "measured.directory"),
        (cascades("n = 100"), "cascades.n"),
        (cascades("n = 4096"), "cascades.n"),
        (cascades("n = 2048\nband_limit = 1.0"), "cascades.n"),
        (cascades("patches_m = [100.0, 100.0]"), "cascades.patches_m"),
        (cascades("patches_m = [1000.0, 1.0]"), "cascades.patches_m"),
        (cascades("patches_m = [1e6]"), "cascades.patches_m"),
        ("[effects]\nchoppiness = 5.1".to_owned(), "effects.choppiness"),
        ("[effects]\nfoam_decay_s = 4".to_owned(), "effects.foam_decay_s"),
    ] {
        let refused = SceneFile::from_toml(&text).and_then(|file| file.check(None)).unwrap_err();
        assert_eq!(refused.field(), Some(field), "{text}: {refused}");
    }
}

#[test]
fn a_misspelt_field_is_an_error_and_not_a_default() {
    for text in ["[wind]\nspeed = 3", "winds = 1", "[effects]\nfoam = 3", "name = 7", "[[swell]\n"] {
        assert!(matches!(SceneFile::from_toml(text), Err(SceneError::Form(_))), "{text}");
    }
}

#[test]
fn a_record_is_read_from_the_folder_a_scene_file_names() {
    let base = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src/scene/presets"));
    let text = "[measured]\nstation = \"41010\"\ndirectory = \"ndbc\"\ntime = \"2020-06-08T02:50\"";
    let scene = SceneFile::from_toml(text).unwrap().check(Some(base)).unwrap();
    let built_in = NdbcStation::built_in();
    assert_eq!(scene.sea.measured.unwrap(), built_in.spectrum(Some("2020-06-08T02:50")).unwrap());
    assert_eq!(built_in.times().unwrap().len(), 60);
    assert!(built_in.spectrum(Some("1999-01-01T00:00")).unwrap_err().to_string().contains("1999-01-01T00:00"));
}

#[test]
fn records_with_gaps_are_read_and_broken_ones_are_refused_by_line() {
    let files = |density: &str, rest: &str| {
        NdbcStation::from_texts(
            "X",
            [density.to_owned(), rest.to_owned(), rest.to_owned(), rest.to_owned(), rest.to_owned()],
        )
    };
    let stamp = "2020 06 08 03 50";
    let rest = format!("{stamp} 0.5 (0.100) 999.0 (0.200)");
    let gap = files(&format!("# head\n{stamp} 9.999 1.0 (0.100) 2.0 (0.200) 999.0 (0.300)"), &rest);
    let spectrum = gap.spectrum(None).unwrap();
    assert_eq!(spectrum.bins().len(), 2, "a missing density is no bin");
    assert!(spectrum.bins()[0].direction.is_some() && spectrum.bins()[1].direction.is_none());
    for (density, says) in [
        (String::new(), "no record"),
        ("2020 06 x 03 50 9.999".to_owned(), "line 1: day"),
        (format!("{stamp} 9.999 1.0 (0.1) nonsense (0.2)"), "line 1: value"),
        (format!("{stamp} 9.999 1.0 (0.1) 1.0"), "line 1: frequency"),
        (format!("{stamp} 9.999 1.0 (0.2) 1.0 (0.1)"), "bins[1].frequency_hz"),
        (format!("{stamp} 9.999 -1.0 (0.1) 1.0 (0.2)"), "bins[0].density"),
    ] {
        let refused = files(&density, &rest).spectrum(None).unwrap_err().to_string();
        assert!(refused.contains(says), "{density}: {refused}");
    }
}
