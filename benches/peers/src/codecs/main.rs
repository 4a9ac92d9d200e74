//! Swellcast's codec beside zfp, LERC, 16-bit floats and the plain way, within the same error on the same fields.
//!
//! `cargo run --release --manifest-path benches/peers/Cargo.toml --bin codecs -- [SECONDS] [PAGE]` (`just
//! codec-peers`); needs libzfp-dev and liblerc-dev. All contestants take each tick in turns, on one thread.
#![allow(clippy::disallowed_methods, reason = "a bench measures time")]

mod lerc;
mod lorenzo;
mod swell;
mod zfp;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use swellcast::backend::Cpu;
use swellcast::engine::{Stepper, interval_of_rate};
use swellcast::plan::Demand;
use swellcast::scene::SceneFile;
use swellcast::sea::Timeline;
use swellcast::wire::{Codec, ErrorClass, Group, SLOWEST_INTERVAL, TICKS_PER_SECOND, UnitName};

const N: usize = 256;
const GROUPS: [Group; 3] = [Group::Displacement, Group::Slopes, Group::Foam];
const CHANNELS: usize = 6;
const BEGIN: i64 = 100 * TICKS_PER_SECOND;

/// The channels of all groups, by tick.
type Sea = BTreeMap<i64, Vec<Vec<f32>>>;

/// Encodes each tick by itself.
trait Peer {
    /// Encodes a tick: how many bytes it takes.
    fn encode(&mut self, channels: &[Vec<f32>]) -> usize;
    /// Decodes what was encoded last.
    fn decode(&mut self, channels: &mut [Vec<f32>]);
}

/// What a contestant was found to take.
#[derive(Default)]
struct Score {
    bytes: usize,
    encode_ms: Vec<f64>,
    decode_ms: Vec<f64>,
    /// Largest error of any sample, as a share of its channel's bound.
    worst: f32,
}

/// What comes of some work, and its milliseconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = Instant::now();
    let made = work();
    (made, began.elapsed().as_secs_f64() * 1e3)
}

/// Largest error of a channel.
fn miss(got: &[f32], want: &[f32]) -> f32 {
    got.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

const HEADING: &str = "## Beside others";
const MARKERS: [&str; 2] = ["<!-- peers: just codec-peers -->\n", "<!-- end -->\n"];

const INTRODUCTION: &str = "\
The same six channels of `250m` and `20m`, and for each the same bound: what the headers of our frames promise. \
Everybody encodes and decodes every tick, in turns, on one thread. Bytes and times are of all six channels. The error \
is the largest of any sample, as a share of its channel's bound, of what was decoded against the field before anything \
was rounded.

- *rans* is what a follower takes; *rans, with keys* what a client takes that asked for a key frame each second, and \
its times include every frame that is made for joiners. Only these look at frames before; headers are counted.
- *zfp* is release 1.0 in fixed accuracy, in 2-D, without a header. It rounds its tolerance down to a power of two, \
and errs by less still. So it stands here twice: *told the bound*, which is what it can be trusted with, and \
*loosest*: for each channel the largest power of two with which just these fields, known beforehand, keep the bound.
- *LERC* is release 4.0, its largest error the bound.
- *Lorenzo, zstd 1*: counts of the same step as ours, predicted from three neighbours in the same frame, low bytes and \
high bytes apart, packed by zstd at level 1.
- *f16* is ours too, and promises no bound: its error goes with the largest sample.
";

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seconds: i64 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(2).max(1);
    let mut table = "| sea | class, rate | codec | Mb/s | times rans | times with keys | encode ms | decode ms | \
                     error |\n|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    // Of each contestant how many times as many bytes it takes as each of our streams.
    let mut ratios: BTreeMap<&str, [Vec<f64>; 2]> = BTreeMap::new();
    for metres in [250, 20] {
        let sea = sea(metres, seconds);
        for (class, rate) in [(ErrorClass::Millimetre, 30), (ErrorClass::FiveMillimetres, 15)] {
            let scores = compare(&sea, class, rate, seconds);
            let ours = [0, 1].map(|i| scores[i].1.bytes as f64);
            for (name, score) in scores {
                let bytes = score.bytes as f64;
                let times = ours.map(|ours| bytes / ours);
                ratios.entry(name).or_default().iter_mut().zip(times).for_each(|(all, one)| all.push(one));
                let row = format!(
                    "| {metres}m | {}, {rate} Hz | {name} | {:.2} | {:.2} | {:.2} | {} | {} | {:.3} |\n",
                    class.name(),
                    bytes * 8e-6 / seconds as f64,
                    times[0],
                    times[1],
                    spread(score.encode_ms),
                    spread(score.decode_ms),
                    score.worst,
                );
                eprint!("{row}");
                table += &row;
            }
        }
    }
    let told = |name: &str| {
        let ends = ratios[name].each_ref().map(|times| {
            let least = times.iter().copied().fold(f64::INFINITY, f64::min);
            let most = times.iter().copied().fold(0.0, f64::max);
            format!("{least:.1} to {most:.1}")
        });
        format!("{} ({})", ends[0], ends[1])
    };
    let section = format!(
        "{INTRODUCTION}\nTimes as many bytes as *rans* (as *rans, with keys*), from the sea that suits it best to the \
         one that suits it least: zfp {}, at its loosest {}, LERC {}.\n\nWritten by `just codec-peers`, {seconds} s of \
         each sea, on one of {} shared cores; times are median and 95th percentile over ticks.\n\n{table}",
        told(ZFP_TOLD),
        told(ZFP_LOOSEST),
        told(LERC),
        std::thread::available_parallelism().map_or(1, |cores| cores.get()),
    );
    println!("{section}");
    if let Some(path) = arguments.next() {
        let page = std::fs::read_to_string(&path).unwrap_or_default();
        std::fs::write(path, placed(&page, &section)).expect("the page can be written");
    }
}

/// The page with the section between its markers, or after everything else where it has none.
fn placed(page: &str, section: &str) -> String {
    let [begin, end] = MARKERS;
    let held = page.split_once(begin).and_then(|(before, rest)| Some((before, rest.split_once(end)?.1)));
    match held {
        Some((before, after)) => format!("{before}{begin}{section}{end}{after}"),
        None => format!("{page}\n{HEADING}\n\n{begin}{section}{end}"),
    }
}

/// Fields of one patch as they are computed, at 30 Hz: what the streams need before the seconds that count, those, and
/// a frame of the lowest rate after them, without which the last ones between do not leave.
fn sea(metres: u32, seconds: i64) -> Sea {
    let text = format!(
        "name = \"reference\"\n[wind]\nspeed_mps = 12.0\nfetch_m = 200e3\n\
         [cascades]\nn = {N}\nband_limit = 1.0\npatches_m = [{metres}]\n"
    );
    let scene = SceneFile::from_toml(&text).and_then(|file| file.check(None)).expect("a scene");
    let timeline = Arc::new(Timeline::new(&scene));
    let unit = |group| UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::F32 };
    let interval = interval_of_rate(30);
    let demand: Demand = GROUPS.into_iter().map(|group| (unit(group), interval)).collect();
    let mut stepper = Stepper::new(Box::new(Cpu::new(None)), timeline, 1);
    stepper.set_demand(&demand);
    let mut sea = Sea::new();
    let ticks = BEGIN - 4 * SLOWEST_INTERVAL..=BEGIN + seconds * TICKS_PER_SECOND + SLOWEST_INTERVAL;
    for tick in ticks.step_by(interval as usize) {
        while stepper.warm_foam(tick).expect("the CPU steps") {}
        let batch = stepper.frames(tick, &demand).expect("the CPU steps");
        let planes = |group| {
            let frame = batch.frames.iter().find(|frame| frame.unit.group == group).expect("a frame");
            swellcast::tile::decode(&frame.bytes).expect("a frame").planes
        };
        sea.insert(tick, GROUPS.into_iter().flat_map(planes).collect());
    }
    sea
}

const ZFP_TOLD: &str = "zfp, told the bound";
const ZFP_LOOSEST: &str = "zfp, loosest";
const LERC: &str = "LERC";

/// All contestants on one sea, ours first.
fn compare(sea: &Sea, class: ErrorClass, rate: u32, seconds: i64) -> Vec<(&'static str, Score)> {
    let interval = interval_of_rate(rate);
    let sea: Sea = sea.iter().filter(|(tick, _)| *tick % interval == 0).map(|(t, c)| (*t, c.clone())).collect();
    let counted = BEGIN..BEGIN + seconds * TICKS_PER_SECOND;
    let (bounds, steps) = swell::promises(class, &sea[&BEGIN]);
    let mut ours = swell::Swell::new(class);
    let mut peers: [(&str, Box<dyn Peer>); 5] = [
        (ZFP_TOLD, Box::new(zfp::Zfp::new(bounds.map(f64::from)))),
        (ZFP_LOOSEST, Box::new(zfp::Zfp::new(zfp::Zfp::loosest(&sea, bounds)))),
        (LERC, Box::new(lerc::Lerc::new(bounds))),
        ("Lorenzo, zstd 1", Box::new(lorenzo::Lorenzo::new(steps))),
        ("f16", Box::new(swell::Floats::new())),
    ];
    let mut scores: [Score; 5] = Default::default();
    let mut decoded = vec![vec![0.0; N * N]; CHANNELS];
    for (tick, channels) in &sea {
        ours.tick(*tick, &sea, bounds, &counted);
        for ((_, peer), score) in peers.iter_mut().zip(&mut scores) {
            let (bytes, encode_ms) = timed(|| peer.encode(channels));
            let ((), decode_ms) = timed(|| peer.decode(&mut decoded));
            if !counted.contains(tick) {
                continue;
            }
            score.bytes += bytes;
            score.encode_ms.push(encode_ms);
            score.decode_ms.push(decode_ms);
            for ((got, want), bound) in decoded.iter().zip(channels).zip(bounds) {
                score.worst = score.worst.max(miss(got, want) / bound);
            }
        }
    }
    let ours = [("rans", ours.followed), ("rans, with keys", ours.keyed)];
    let scores: Vec<_> = ours.into_iter().chain(peers.map(|(name, _)| name).into_iter().zip(scores)).collect();
    for (name, score) in &scores {
        // LERC rounds its sums to f32 after it has kept the bound.
        assert!(*name == "f16" || score.worst < 1.002, "{name} is off by {} of its bound", score.worst);
    }
    scores
}

fn spread(mut ms: Vec<f64>) -> String {
    ms.sort_by(f64::total_cmp);
    let at = |share: f64| ms.get((ms.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN);
    format!("{:.2}, {:.2}", at(0.5), at(0.95))
}
