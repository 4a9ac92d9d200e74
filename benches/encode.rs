//! What the codec's frames cost: bytes, time on one core, and how far samples are off, on whole seconds of sea.
//!
//! `cargo bench --bench encode`; `-- --write` writes its part of docs/codec.md anew, `-- --dump FOLDER` keeps the predicted frames of
//! each sea, each after its length (u32, little-endian), in the order in which they are sent.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use swellcast::backend::Cpu;
use swellcast::engine::{Stepper, interval_of_rate};
use swellcast::plan::Demand;
use swellcast::scene::{Scene, SceneFile, preset};
use swellcast::sea::Timeline;
use swellcast::tile::{Decoder, Plane, Stamp, UnitEncoder, decode};
use swellcast::wire::{Codec, ErrorClass, Group, SLOWEST_INTERVAL, TICKS_PER_SECOND, UnitName};

const GROUPS: [Group; 3] = [Group::Displacement, Group::Slopes, Group::Foam];
const SECONDS: i64 = 2;
const BEGIN: i64 = 100 * TICKS_PER_SECOND;
const END: i64 = BEGIN + SECONDS * TICKS_PER_SECOND;

/// Planes of each group of a cascade, by tick.
type Seconds = BTreeMap<i64, Vec<Vec<Vec<f32>>>>;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let dump = arguments.iter().position(|argument| argument == "--dump").and_then(|at| arguments.get(at + 1));
    let mut page = PAGE.to_owned();
    for (name, scene) in scenes() {
        let timeline = Arc::new(Timeline::new(&scene));
        for cascade in 0..timeline.layout().cascades.len() {
            let n = timeline.layout().cascades[cascade].n;
            let sea = seconds(&timeline, cascade as u8);
            for (class, rate) in [(ErrorClass::Millimetre, 30), (ErrorClass::FiveMillimetres, 15)] {
                for codec in [Codec::Rans, Codec::Deflate, Codec::F16] {
                    let stream = format!("{name}.{cascade}");
                    let (row, frames) = measure(&stream, n, &sea, codec, class, rate);
                    print!("{row}");
                    page += &row;
                    if let Some(folder) = dump.filter(|_| codec == Codec::Rans) {
                        let path = format!("{folder}/{stream}-{}.frames", class.name());
                        std::fs::write(path, frames).expect("the folder can be written to");
                    }
                }
            }
        }
    }
    if arguments.iter().any(|argument| argument == "--write") {
        // What the bench of peers wrote stays.
        let held = std::fs::read_to_string("docs/codec.md").unwrap_or_default();
        let peers = held.find("\n## Beside others").map_or("", |at| &held[at..]);
        std::fs::write("docs/codec.md", page + peers).expect("docs can be written to");
    }
}

const PAGE: &str = "\
# What frames cost

Six channels of 256 x 256 samples: displacement, slopes and foam of one cascade. `250m` and `20m` are one patch each, wind 12 m/s over 200 km, full to Nyquist; `default` is the scene that is served when nothing is said, cascade by cascade. Two seconds of each. \"with keys\" is what a client takes that asked for a key frame each second; who joins otherwise costs nobody else anything. Times are of one core, median and 95th percentile over ticks, with nothing else running. The error is the largest of any sample, as a share of what its frame promises; what `f16` promises goes with the largest value.

Written by `cargo bench --bench encode -- --write` (`just codec`), on two shared cores.

| sea | class, rate | codec | Mb/s | with keys | encode ms | decode ms | error |
|---|---|---|---|---|---|---|---|
";

fn scenes() -> Vec<(&'static str, Scene)> {
    let patch = |metres: u32| {
        let text = format!(
            "name = \"reference\"\n[wind]\nspeed_mps = 12.0\nfetch_m = 200e3\n\
             [cascades]\nn = 256\nband_limit = 1.0\npatches_m = [{metres}]\n"
        );
        SceneFile::from_toml(&text).expect("a scene").check(None).expect("a scene")
    };
    vec![("250m", patch(250)), ("20m", patch(20)), ("default", preset("beaufort-5").expect("a preset"))]
}

/// Fields as they are computed, at 60 Hz.
fn seconds(timeline: &Arc<Timeline>, cascade: u8) -> Seconds {
    let class = ErrorClass::HalfMillimetre;
    let unit = |group| UnitName { cascade, level: 0, class, group, codec: Codec::F32 };
    let mut stepper = Stepper::new(Box::new(Cpu::new(None)), Arc::clone(timeline), 1);
    let demand: Demand = GROUPS.into_iter().map(|group| (unit(group), interval_of_rate(60))).collect();
    stepper.set_demand(&demand);
    let mut sea = Seconds::new();
    let ahead = 4 * SLOWEST_INTERVAL;
    for tick in (BEGIN - ahead..END + ahead).step_by(120) {
        while stepper.warm_foam(tick).expect("the CPU steps") {}
        let batch = stepper.frames(tick, &demand).expect("the CPU steps");
        let planes = |group| {
            let frame = batch.frames.iter().find(|frame| frame.unit.group == group).expect("a frame");
            decode(&frame.bytes).expect("a frame").planes
        };
        sea.insert(tick, GROUPS.map(planes).into());
    }
    sea
}

/// A row of the table, and all frames.
fn measure(name: &str, n: usize, sea: &Seconds, codec: Codec, class: ErrorClass, rate: u32) -> (String, Vec<u8>) {
    let mut sent = Vec::new();
    let units = GROUPS.map(|group| UnitName { cascade: 0, level: 0, class, group, codec });
    let mut encoders = units.map(UnitEncoder::new);
    let mut decoder = Decoder::new(1 << 20);
    let (mut encode_ms, mut decode_ms, mut followed, mut keys, mut worst) = (vec![], vec![], 0, 0, 0.0f32);
    let interval = interval_of_rate(rate);
    for (tick, groups) in sea.iter().filter(|(tick, _)| *tick % interval == 0) {
        let key = tick % TICKS_PER_SECOND == 0;
        let mut frames = Vec::new();
        let (mut encoding, mut decoding) = (0.0, 0.0);
        for (encoder, planes) in encoders.iter_mut().zip(groups) {
            if key {
                encoder.join();
            }
            let planes: Vec<Plane> = planes.iter().map(|plane| Plane::Samples(plane)).collect();
            let stamp = Stamp { tick: *tick, epoch: 1, sequence: 0, layout: 0 };
            let began = Instant::now();
            frames.extend(encoder.take(n, &planes, stamp).expect("finite"));
            encoding += began.elapsed().as_secs_f64() * 1e3;
        }
        let deepest = frames.iter().map(|frame| frame.depth).max().unwrap_or(0);
        for frame in frames {
            let counts = (BEGIN..END).contains(&frame.tick);
            if frame.depth < deepest && codec.predicts() {
                keys += if counts && frame.depth == 0 { frame.bytes.len() } else { 0 };
                continue;
            }
            followed += if counts { frame.bytes.len() } else { 0 };
            sent.extend((frame.bytes.len() as u32).to_le_bytes());
            sent.extend(&frame.bytes);
            let began = Instant::now();
            let decoded = decoder.decode(&frame.bytes).expect("a frame");
            decoding += began.elapsed().as_secs_f64() * 1e3;
            let group = GROUPS.iter().position(|group| *group == frame.unit.group).expect("of ours");
            let promised = decoded.header.max_error;
            for ((got, want), promised) in decoded.planes.iter().zip(&sea[&frame.tick][group]).zip(promised) {
                let miss = got.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                worst = worst.max(miss / promised);
            }
        }
        if *tick >= BEGIN {
            // Frames in which others are made besides are not those of a quiet stream.
            if !key && tick % TICKS_PER_SECOND > 2 * SLOWEST_INTERVAL {
                encode_ms.push(encoding);
            }
            decode_ms.push(decoding);
        }
    }
    let rate_of = |bytes: usize| bytes as f64 * 8e-6 / SECONDS as f64;
    let row = format!(
        "| {name} | {}, {rate} Hz | {} | {:.2} | {:.2} | {} | {} | {:.3} |\n",
        class.name(),
        codec.name(),
        rate_of(followed),
        rate_of(followed + keys),
        spread(encode_ms),
        spread(decode_ms),
        worst,
    );
    (row, sent)
}

fn spread(mut ms: Vec<f64>) -> String {
    ms.sort_by(f64::total_cmp);
    let at = |share: f64| ms.get((ms.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN);
    format!("{:.2}, {:.2}", at(0.5), at(0.95))
}
