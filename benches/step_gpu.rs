//! The GPU's step by pass, beside the bytes that it must move and what the same device copies in a second.
//!
//! `cargo bench --bench step_gpu`; `-- --json` prints JSON, `-- --write` puts the table into docs/performance.md. Times of
//! passes are the device's own timestamps; those of frames are the wall's, read-back included, one at a time and with
//! four under way. Median and quartiles of all rounds.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::fmt::Write;
use std::time::Instant;

use swellcast::backend::{Backend, Gpu, GpuSettings, Storage, traffic};
use swellcast::pass::quantise::quantiser_step;
use swellcast::plan::{CascadePlan, Counted, FieldSet, FoamWork, Plan, Wanted, fields_of};
use swellcast::scene::{Scene, SceneFile};
use swellcast::sea::Timeline;
use swellcast::wire::{ErrorClass, Group};

const ROUNDS: usize = 30;
const WARM_UP: usize = 3;
const UNDER_WAY: usize = 4;
/// Bytes of the copies that tell the bandwidth, and how many.
const COPY: u64 = 64 << 20;
const COPIES: usize = 16;
const PAGE: &str = "docs/performance.md";
const TITLE: &str = "# The GPU step";

fn main() {
    let asked = |flag: &str| std::env::args().any(|argument| argument == flag);
    let settings = GpuSettings { adapter: std::env::var("SWELLCAST_GPU").ok(), software: true, storage: Storage::F32 };
    let mut gpu = match Gpu::open(&settings) {
        Ok(gpu) => gpu,
        Err(error) => {
            println!("no GPU step was measured: {error}");
            return;
        }
    };
    let adapter = gpu.adapter().to_owned();
    if !asked("--json") {
        println!("{adapter}");
    }
    let timed = gpu.time_passes();
    gpu.copy(COPY, 2).expect("the device copies");
    let copies: Vec<f64> = (0..5).map(|_| seconds(|| gpu.copy(COPY, COPIES).expect("the device copies"))).collect();
    // Read and written.
    let bandwidth = 2.0 * COPY as f64 * COPIES as f64 / quartiles(copies)[1];

    let mut rows = Vec::new();
    for (count, n) in [(1, 256), (3, 256), (4, 512), (4, 1024)] {
        let timeline = Timeline::new(&scene(count, n));
        let sea = timeline.at(0);
        for everything in [true, false] {
            gpu.load(&sea).expect("the sea fits");
            let plan = plan(&timeline, everything);
            let bytes = traffic(&plan, timeline.layout(), Storage::F32).total() as f64;
            let floor = bytes / bandwidth * 1e3;
            let (mut alone, mut compute, mut passes) = (Vec::new(), Vec::new(), Vec::new());
            for round in 0..WARM_UP + ROUNDS {
                let ms = 1e3 * seconds(|| assert!(gpu.step(round as i64 * 240, &plan).is_ok()));
                if round >= WARM_UP {
                    alone.push(ms);
                    compute.push(gpu.pass_times().iter().map(|(_, ms)| ms).sum());
                    passes.push(gpu.pass_times());
                }
            }
            let mut together = Vec::new();
            for round in 0..ROUNDS.div_ceil(UNDER_WAY) {
                together.push(
                    1e3 / UNDER_WAY as f64
                        * seconds(|| {
                            (0..UNDER_WAY).for_each(|i| gpu.submit((round + i) as i64 * 240, &plan).expect("it steps"));
                            (0..UNDER_WAY).for_each(|_| assert!(gpu.collect().is_ok()));
                        }),
                );
            }
            let by_pass: Vec<(&str, f64)> = passes[0]
                .iter()
                .enumerate()
                .map(|(i, (label, _))| (*label, quartiles(passes.iter().map(|passes| passes[i].1).collect())[1]))
                .collect();
            let [lower, compute, upper] = quartiles(compute);
            rows.push(serde_json::json!({
                "cascades": count, "n": n, "wanted": if everything { "everything" } else { "height" },
                "bytes": bytes, "floor_ms": floor,
                "compute_ms": timed.then_some([compute, lower, upper]),
                "compute_over_floor": timed.then_some(compute / floor),
                "frame_ms": quartiles(alone), "frame_under_way_ms": quartiles(together),
                "passes_ms": by_pass.iter().map(|(label, ms)| serde_json::json!({ "pass": label, "ms": ms })).collect::<Vec<_>>(),
            }));
        }
    }
    let all = serde_json::json!({ "adapter": adapter, "copy_bytes_per_second": bandwidth, "rows": rows });
    if asked("--json") {
        println!("{all:#}");
        return;
    }
    let table = table(&all);
    println!("{table}");
    if asked("--write") {
        let held = std::fs::read_to_string(PAGE).unwrap_or_default();
        let cpu = held.find(TITLE).map_or(held.as_str(), |at| &held[..at]);
        let page = format!("{}\n\n{table}", cpu.trim_end());
        std::fs::write(PAGE, page).expect("the page can be written");
    }
}

fn table(all: &serde_json::Value) -> String {
    let number = |value: &serde_json::Value| value.as_f64().map_or("-".to_owned(), |v| format!("{v:.3}"));
    let mut text = format!(
        "{TITLE}\n\n`just bench-gpu` writes this part. Adapter: {}. It copies {:.1} GB/s (read and written). *floor*: bytes \
         that the plan must move over that. *compute*: all passes by the device's timestamps, and its quartiles. *frame*: \
         wall time of a step with its read-back; *under way*: of one of {UNDER_WAY} that are submitted together. All in \
         milliseconds, medians of {ROUNDS} rounds.\n\n",
        all["adapter"].as_str().unwrap_or_default(),
        all["copy_bytes_per_second"].as_f64().unwrap_or_default() / 1e9,
    );
    if all["adapter"].as_str().is_some_and(|adapter| adapter.contains("(Cpu,")) {
        text += "No GPU was at hand when this was written: the adapter is a software renderer. Its times say nothing of \
                 hardware.\n\n";
    }
    text += "| cascades | wanted | MB | floor | compute | compute / floor | frame | under way | passes |\n";
    text += "|---|---|---|---|---|---|---|---|---|\n";
    for row in all["rows"].as_array().into_iter().flatten() {
        let passes: Vec<String> = row["passes_ms"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|pass| {
                format!(
                    "{} {}",
                    pass["pass"].as_str().unwrap_or_default().trim_start_matches("swellcast."),
                    number(&pass["ms"])
                )
            })
            .collect();
        let compute = &row["compute_ms"];
        let _ = writeln!(
            text,
            "| {} x {}^2 | {} | {:.2} | {} | {} ({} to {}) | {} | {} | {} | {} |",
            row["cascades"],
            row["n"],
            row["wanted"].as_str().unwrap_or_default(),
            row["bytes"].as_f64().unwrap_or_default() / 1e6,
            number(&row["floor_ms"]),
            number(&compute[0]),
            number(&compute[1]),
            number(&compute[2]),
            number(&row["compute_over_floor"]),
            number(&row["frame_ms"][1]),
            number(&row["frame_under_way_ms"][1]),
            passes.join(", "),
        );
    }
    text
}

fn scene(cascades: usize, n: usize) -> Scene {
    let patches: Vec<f64> = (0..cascades).map(|i| 1000.0 / 4.2_f64.powi(i as i32)).collect();
    let text = format!(
        "name = \"bench\"\n[wind]\nspeed_mps = 12.0\nfetch_m = 200e3\n[cascades]\nn = {n}\npatches_m = {patches:?}\n"
    );
    SceneFile::from_toml(&text).and_then(|file| file.check(None)).expect("a scene")
}

/// Every group as counts of the 1 mm class, foam on its step; or the height alone.
fn plan(timeline: &Timeline, everything: bool) -> Plan {
    let groups = if everything { &Group::ALL[..] } else { &[Group::Height][..] };
    let fields: FieldSet = groups.iter().fold(FieldSet::NONE, |set, group| set.union(FieldSet::of(fields_of(*group))));
    let foam = FoamWork { restart: false, decay: 0.97, growth: 0.2, advance: true, breaks: true };
    let class = ErrorClass::Millimetre;
    let mut counts: Vec<Counted> = Vec::new();
    for (group, field) in groups.iter().flat_map(|group| fields_of(*group).iter().map(move |field| (group, field))) {
        let counted = Counted { level: 0, field: *field, step: quantiser_step(class, *group), share: 1.0 };
        if !counts.contains(&counted) {
            counts.push(counted);
        }
    }
    let cascade = CascadePlan::new([(0, fields)], everything.then_some(foam), &timeline.scene().effects)
        .leaving(Wanted { counts, samples: FieldSet::NONE });
    Plan { cascades: vec![cascade; timeline.layout().cascades.len()] }
}

fn seconds(work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    started.elapsed().as_secs_f64()
}

/// Lower quartile, median, upper quartile.
fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| values[values.len() * quarter / 4])
}
