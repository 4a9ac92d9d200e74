//! What a running server spends on what its clients ask for, from its own counters; and how soon a joiner has frames.
//!
//! `cargo bench --bench demand` (`-- --write` also writes docs/effects.md, `just effects`). Demands are served in
//! turns, several rounds of all; what is printed is the median of the rounds and their range.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use swellcast::backend::Cpu;
use swellcast::client::{Connection, Event};
use swellcast::control::{Epoch, Store};
use swellcast::engine::{Clock, effect_costs};
use swellcast::scene::{Scene, SceneFile, preset};
use swellcast::server::{self, Ocean, Settings};
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

const ROUNDS: usize = 5;
const RATE: u32 = 30;
/// Three patches of 256 x 256, the band that is usual.
const SCENE: &str = "name = \"three\"\n[wind]\nspeed_mps = 9\n[cascades]\nn = 256\npatches_m = [1600, 230, 33]\n";

#[derive(Default)]
struct Row {
    transforms: Vec<f64>,
    samples: Vec<f64>,
    ms: Vec<f64>,
}

fn main() {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().expect("a runtime");
    let scene = SceneFile::from_toml(SCENE).and_then(|file| file.check(None)).expect("a scene");
    let mut page = String::new();
    let put = &mut page;
    writeln!(put, "# What effects cost\n").unwrap();
    writeln!(put, "`just effects` writes this page (`cargo bench --bench demand -- --write`), on {}.\n", machine())
        .unwrap();
    writeln!(put, "## What a frame costs by what is asked of it\n").unwrap();
    writeln!(
        put,
        "A server with three cascades of 256 x 256, one client at {RATE} Hz over loopback; from the server's counters, \
         encoding included, median and range of {ROUNDS} rounds in turns. A transform is one real field; two share a \
         complex one.\n"
    )
    .unwrap();
    runtime.block_on(demands(&scene, put));
    writeln!(put, "\n## How soon a joiner has frames\n").unwrap();
    writeln!(
        put,
        "The preset `beaufort-7` has rested; from sending `subscribe` (15 Hz, everything) to the first frame of waves, \
         and of foam, in milliseconds: median and range of {ROUNDS} rounds.\n"
    )
    .unwrap();
    runtime.block_on(joins(put));
    writeln!(put, "\n## What each effect costs alone\n").unwrap();
    writeln!(put, "`swellcast plan` and `GET /v1/scenes/{{name}}/plan` measure this on your machine. Preset `beaufort-5`: four cascades of 256 x 256, one thread, median and quartiles.\n").unwrap();
    alone(put);
    println!("{page}");
    if std::env::args().any(|argument| argument == "--write") {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/effects.md"), &page).expect("docs can be written");
    }
}

fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    format!("{cores} cores, {}", std::env::consts::ARCH)
}

async fn start(scene: &Scene) -> (Arc<Ocean>, String) {
    let store = Store::in_memory().expect("a store");
    let begun = store.begin(scene, Epoch::begin(Clock::unix_now_ns() - 3_600_000_000_000)).expect("an epoch");
    let ocean = Ocean::start(store, begun, Settings::default());
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.expect("a port");
    let url = format!("http://{}", listener.local_addr().expect("an address"));
    // Ends with the program.
    tokio::spawn(server::run(listener, Arc::clone(&ocean), std::future::pending()));
    (ocean, url)
}

fn units(cascades: &[u8], level: u8, groups: &[Group]) -> Vec<UnitName> {
    let unit = |cascade: u8, group: Group| UnitName {
        cascade,
        level,
        class: ErrorClass::Millimetre,
        group,
        codec: Codec::I16,
    };
    cascades.iter().flat_map(|cascade| groups.iter().map(move |group| unit(*cascade, *group))).collect()
}

async fn demands(scene: &Scene, page: &mut String) {
    use Group::{Derivatives, Displacement, Foam, Height, Slopes};
    let waves: Vec<Group> = Group::ALL.into_iter().filter(|group| *group != Foam).collect();
    let all = [0, 1, 2];
    let rows = [
        ("everything", units(&all, 0, &Group::ALL)),
        ("nobody", vec![]),
        ("height only", units(&all, 0, &[Height])),
        ("height and chop", units(&all, 0, &[Displacement])),
        ("displacement and exact normals", units(&all, 0, &[Displacement, Slopes, Derivatives])),
        ("everything at half resolution, without foam", units(&all, 1, &waves)),
        ("one cascade of three, everything", units(&[1], 0, &Group::ALL)),
    ];
    let (ocean, url) = start(scene).await;
    let clock = Clock::start(Clock::unix_now_ns());
    let mut client = Connection::open(&url, move || clock.now_us()).await.expect("the server is there");
    let mut found: Vec<Row> = rows.iter().map(|_| Row::default()).collect();
    for _ in 0..ROUNDS {
        for ((_, wanted), row) in rows.iter().zip(&mut found) {
            client.subscribe(RATE, wanted.clone(), false).await;
            // What was wanted before lingers for two seconds, and foam must be warm.
            listen(&mut client, Duration::from_secs(4)).await;
            let before = ocean.counters();
            listen(&mut client, Duration::from_secs(2)).await;
            let after = ocean.counters();
            // Where nobody asks, frames of the time that passed stand for those that were not made.
            let frames = (after.steps - before.steps).max(1) as f64;
            row.transforms.push((after.work.transforms - before.work.transforms) as f64 / frames);
            row.samples.push((after.work.samples - before.work.samples) as f64 / frames);
            row.ms.push((after.step_seconds - before.step_seconds) * 1e3 / frames);
        }
    }
    writeln!(page, "| asked for | transforms a frame | samples | ms a frame | of everything |").unwrap();
    writeln!(page, "|---|---|---|---|---|").unwrap();
    let ratios = |row: &Row| row.ms.iter().zip(&found[0].ms).map(|(ms, all)| ms / all).collect::<Vec<_>>();
    for ((name, _), row) in rows.iter().zip(&found) {
        let [low, ms, high] = range(&row.ms);
        let [least, share, most] = range(&ratios(row));
        writeln!(
            page,
            "| {name} | {:.1} | {:.0} | {ms:.2} ({low:.2} to {high:.2}) | {share:.2} ({least:.2} to {most:.2}) |",
            range(&row.transforms)[1],
            range(&row.samples)[1],
        )
        .unwrap();
    }
}

/// Reads what comes for a while.
async fn listen(client: &mut Connection<impl Fn() -> i64>, time: Duration) {
    let _ = tokio::time::timeout(time, async { while !matches!(client.next().await, Event::Closed(_)) {} }).await;
}

async fn joins(page: &mut String) {
    let scene = preset("beaufort-7").expect("a preset");
    let (_ocean, url) = start(&scene).await;
    let (mut waves, mut foam) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        // Longer than a wish lingers, and than foam remembers.
        tokio::time::sleep(Duration::from_secs(4)).await;
        let clock = Clock::start(Clock::unix_now_ns());
        let mut client = Connection::open(&url, move || clock.now_us()).await.expect("the server is there");
        let Event::Hello(hello) = client.next().await else { panic!("hello comes first") };
        let cascades: Vec<u8> = hello.layout.cascades.iter().map(|cascade| cascade.index).collect();
        let begun = Instant::now();
        client.subscribe(15, units(&cascades, 0, &Group::ALL), false).await;
        let (mut first, mut first_foam) = (None, None);
        while first_foam.is_none() {
            let Event::Frame(frame, _) = client.next().await else { continue };
            let group = frame.header.group;
            let ms = begun.elapsed().as_secs_f64() * 1e3;
            first.get_or_insert(ms);
            if group == Group::Foam.id() {
                first_foam = Some(ms);
            }
        }
        waves.extend(first);
        foam.extend(first_foam);
    }
    writeln!(page, "| first frame of | ms |\n|---|---|").unwrap();
    for (name, times) in [("waves", waves), ("foam", foam)] {
        let [low, median, high] = range(&times);
        writeln!(page, "| {name} | {median:.0} ({low:.0} to {high:.0}) |").unwrap();
    }
}

fn alone(page: &mut String) {
    let scene = preset("beaufort-5").expect("a preset");
    let timeline = swellcast::sea::Timeline::new(&scene);
    let clock = Clock::start(Clock::unix_now_ns());
    let costs = effect_costs(&mut Cpu::new(Some(1)), &timeline, 0, &clock).expect("the CPU steps");
    writeln!(page, "| effect | transforms | ms |\n|---|---|---|").unwrap();
    for cost in costs {
        let step = cost.step;
        writeln!(
            page,
            "| {} | {} | {:.2} ({:.2} to {:.2}) |",
            cost.effect, cost.transforms, step.median_ms, step.lower_ms, step.upper_ms
        )
        .unwrap();
    }
}

/// Least, median and most.
fn range(values: &[f64]) -> [f64; 3] {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    [values[0], values[values.len() / 2], values[values.len() - 1]]
}
