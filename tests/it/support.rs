//! Scenes and steps that several test modules use.

use swellcast::backend::{Backend, Cpu};
use swellcast::plan::{CascadePlan, Field, FieldSet, FoamWork, Plan};
use swellcast::scene::{Effects, Scene, SceneFile};
use swellcast::sea::{Sea, Timeline};

/// One day and ten years, in ticks.
pub const DAY: i64 = 86_400 * 7200;
pub const TEN_YEARS: i64 = 3_652 * DAY;

/// A scene from the text of its file.
pub fn scene(toml: &str) -> Scene {
    SceneFile::from_toml(toml).unwrap().check(None).unwrap()
}

/// A wind sea on hand-made patches.
pub fn wind_sea(speed: f64, n: usize, patches_m: &[f64]) -> Scene {
    scene(&format!(
        "name = \"test\"\n[wind]\nspeed_mps = {speed}\nfetch_m = 200e3\nrange_mps = [0.0, 100.0]\n\
         [cascades]\nn = {n}\npatches_m = {patches_m:?}\n"
    ))
}

/// A plan for these fields of every cascade, without foam.
pub fn plan(sea: &Sea, fields: &[Field]) -> Plan {
    let cascade = full(FieldSet::of(fields), None, sea.choppiness);
    Plan { cascades: vec![cascade; sea.cascades.len()] }
}

/// Work for these fields of the full grid.
pub fn full(fields: FieldSet, foam: Option<FoamWork>, choppiness: f64) -> CascadePlan {
    CascadePlan::new([(0, fields)], foam, &Effects { choppiness, ..Effects::default() })
}

/// Fields of one cascade at a tick, by the CPU backend.
pub fn cpu_fields(timeline: &Timeline, tick: i64, cascade: usize, fields: &[Field]) -> Vec<Vec<f32>> {
    let sea = timeline.at(tick);
    let mut cpu = Cpu::new(Some(2));
    cpu.load(&sea).unwrap();
    let surface = cpu.step(tick, &plan(&sea, fields)).unwrap();
    fields.iter().map(|field| surface.cascades[cascade].plane(*field).unwrap().to_vec()).collect()
}

/// Holds a number to another, within a share of it.
pub fn close(got: f64, want: f64, relative: f64) {
    assert!((got - want).abs() <= relative * want.abs(), "got {got}, want {want} within {relative}");
}

/// Largest difference of two fields.
pub fn max_error(a: &[f32], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max)
}
