//! What each way of normals errs and costs. `cargo bench --bench normals`; with `-- --write` it writes docs/normals.md.
//!
//! What is measured is what the server makes, in f32 before quantising, against the exact normal of the f64 reference.
//! Nothing is interpolated: the cascades of a sea have patches of no common measure, so that somewhere in the world any
//! sample of one lies over any sample of the others, and all such meetings are equally frequent.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::fmt::Write;
use std::time::Instant;

use swellcast::backend::{Backend, Cpu};
use swellcast::plan::{CascadePlan, Field, FieldSet, Plan, fields_of};
use swellcast::reference;
use swellcast::scene::{Effects, Normals, SceneFile};
use swellcast::sea::{Sea, Timeline};
use swellcast::wire::Group;

const SIDES: [usize; 4] = [128, 256, 512, 1024];
const ONE: [f64; 1] = [1000.0];
const THREE: [f64; 3] = [1000.0, 149.3, 21.7];
const WIND_MPS: f64 = 12.0;
/// From where it blows: along no axis of the grid.
const DIRECTION_DEG: f64 = 247.5;
const WAYS: [Normals; 5] =
    [Normals::Exact, Normals::Diagonal, Normals::DisplacedSlopes, Normals::CentralDifference, Normals::Sobel];
/// What the exact way is made of.
const SOURCES: [Field; 5] = [Field::SlopeX, Field::SlopeZ, Field::Dxx, Field::Dzz, Field::Dxz];
/// Meetings of samples that are looked at where there are several cascades.
const MEETINGS: usize = 100_000;
const ROUNDS: usize = 15;
/// Where the whole surface is squeezed to less than this it counts as folded: below it no slope stands for a normal.
const FOLDED: f64 = 0.1;

type Normal = [f64; 3];

fn main() {
    let write = std::env::args().any(|argument| argument == "--write");
    let begun = Instant::now();
    let told = |what: &str| eprintln!("{:4.0} s  {what}", begun.elapsed().as_secs_f64());
    let columns = |patches: &[f64], band_limit: &dyn Fn(usize) -> f64| {
        SIDES.map(|n| {
            told(&format!("{} of N = {n}, band limit {:.3}", patches.len(), band_limit(n)));
            Column::measure(&sea(n, band_limit(n), patches))
        })
    };
    let tables = Tables {
        sum: columns(&THREE, &|_| 1.0 / 3.0),
        one: columns(&ONE, &|_| 1.0 / 3.0),
        full: columns(&ONE, &|_| 1.0),
        finer: columns(&ONE, &|n| 0.99 * SIDES[0] as f64 / n as f64),
    };
    told("cost");
    let page = tables.page(&costs());
    println!("{page}");
    if write {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/normals.md");
        std::fs::write(path, page).expect("the docs can be written");
        told("wrote docs/normals.md");
    }
}

fn sea(n: usize, band_limit: f64, patches_m: &[f64]) -> Sea {
    let toml = format!(
        "name = \"normals\"\n[wind]\nspeed_mps = {WIND_MPS}\nfetch_m = 200e3\ndirection_from_deg = {DIRECTION_DEG}\n\
         [cascades]\nn = {n}\nband_limit = {band_limit}\npatches_m = {patches_m:?}\n[effects]\nfoam = false\n"
    );
    Timeline::new(&SceneFile::from_toml(&toml).expect("TOML").check(None).expect("a scene")).at(0)
}

/// The channels that a way streams, of every cascade.
fn channels(way: Normals) -> FieldSet {
    FieldSet::of(match way {
        Normals::Exact | Normals::Diagonal => fields_of(Group::Slopes),
        _ => fields_of(Group::Normals),
    })
    .union(FieldSet::of(match way {
        Normals::Exact => fields_of(Group::Derivatives),
        Normals::Diagonal => fields_of(Group::Stretch),
        _ => &[],
    }))
}

fn plan(way: Normals, fields: FieldSet, cascades: usize) -> Plan {
    let effects = Effects { normals: way, ..Effects::default() };
    Plan { cascades: vec![CascadePlan::new([(0, fields)], None, &effects); cascades] }
}

/// Errors on one sea.
struct Column {
    n: usize,
    /// Samples of the grid in its shortest wave.
    samples: f64,
    folded: f64,
    /// By way, and last of averaged unit normals: rms and 99th percentile of the angle, degrees.
    errors: Vec<[f64; 2]>,
}

impl Column {
    fn measure(sea: &Sea) -> Self {
        let (first, cascades) = (sea.cascades[0].cascade, sea.cascades.len());
        let picks = picks(first.n, cascades);
        let (mut totals, mut averaged) = (vec![[0.0; 5]; picks[0].len()], vec![[0.0; 3]; picks[0].len()]);
        for (cascade, picks) in picks.iter().enumerate() {
            let fields = reference::fields(sea, cascade, 0, &SOURCES);
            for ((total, averaged), pick) in totals.iter_mut().zip(&mut averaged).zip(picks) {
                let own: [f64; 5] = std::array::from_fn(|field| fields[field][*pick]);
                total.iter_mut().zip(own).for_each(|(total, own)| *total += own);
                averaged.iter_mut().zip(unit(normal(own))).for_each(|(sum, own)| *sum += own);
            }
        }
        let exact: Vec<Normal> = totals.into_iter().map(normal).collect();
        let mut errors: Vec<[f64; 2]> = WAYS.map(|way| shares(&exact, &made(sea, way, &picks))).to_vec();
        errors.push(shares(&exact, &averaged));
        let folded = exact.iter().filter(|normal| normal[1] < FOLDED).count() as f64 / exact.len() as f64;
        let samples = first.shortest_m() * first.n as f64 / first.patch_m;
        Self { n: first.n, samples, folded, errors }
    }
}

/// Samples of each cascade that meet: all of one alone, and random ones of several.
fn picks(n: usize, cascades: usize) -> Vec<Vec<usize>> {
    if cascades == 1 {
        return vec![(0..n * n).collect()];
    }
    let mut state = 0_u64;
    let mut pick = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed ^ (mixed >> 31)) as usize % (n * n)
    };
    (0..cascades).map(|_| (0..MEETINGS).map(|_| pick()).collect()).collect()
}

/// Normals that a client makes of what a way streams.
fn made(sea: &Sea, way: Normals, picks: &[Vec<usize>]) -> Vec<Normal> {
    let mut cpu = Cpu::new(None);
    cpu.load(sea).expect("the CPU loads");
    let fields: Vec<Field> = channels(way).iter().collect();
    let surface = cpu.step(0, &plan(way, channels(way), picks.len())).expect("the plan fits");
    let mut sums = vec![vec![0.0_f32; picks[0].len()]; fields.len()];
    for (cascade, picks) in surface.cascades.iter().zip(picks) {
        for (sums, field) in sums.iter_mut().zip(&fields) {
            let plane = cascade.plane(*field).expect("it was asked for");
            sums.iter_mut().zip(picks).for_each(|(sum, pick)| *sum += plane[*pick]);
        }
    }
    let sum = |field: usize, i: usize| f64::from(sums[field][i]);
    (0..picks[0].len())
        .map(|i| match way {
            Normals::Exact => normal(std::array::from_fn(|field| sum(field, i))),
            Normals::Diagonal => [-sum(0, i) / (1.0 + sum(2, i)), 1.0, -sum(1, i) / (1.0 + sum(3, i))],
            _ => [-sum(0, i), 1.0, -sum(1, i)],
        })
        .collect()
}

/// The normal of the displaced surface, as long as its Jacobian is high.
fn normal([hx, hz, dxx, dzz, dxz]: [f64; 5]) -> Normal {
    [-(hx * (1.0 + dzz) - hz * dxz), (1.0 + dxx) * (1.0 + dzz) - dxz * dxz, -(hz * (1.0 + dxx) - hx * dxz)]
}

fn unit(normal: Normal) -> Normal {
    let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
    normal.map(|v| v / length)
}

/// Angle between two directions, degrees.
fn angle(a: Normal, b: Normal) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    cross.iter().map(|v| v * v).sum::<f64>().sqrt().atan2(dot).to_degrees()
}

/// Rms and 99th percentile of the angle, where nothing folds.
fn shares(exact: &[Normal], made: &[Normal]) -> [f64; 2] {
    let smooth = exact.iter().zip(made).filter(|(exact, _)| exact[1] >= FOLDED);
    let mut angles: Vec<f64> = smooth.map(|(exact, made)| angle(*exact, *made)).collect();
    angles.sort_by(f64::total_cmp);
    let square = angles.iter().map(|a| a * a).sum::<f64>() / angles.len() as f64;
    [square.sqrt(), angles[angles.len() * 99 / 100]]
}

fn name(way: usize) -> &'static str {
    WAYS.get(way).map_or("average of unit normals, no way of Swellcast", |way| way.name())
}

fn cells(table: &mut String, first: &str, cells: impl Iterator<Item = String>) {
    writeln!(table, "| {first} | {} |", cells.collect::<Vec<_>>().join(" | ")).expect("a string");
}

/// Errors of some ways, a column a sea.
fn errors(columns: &[Column], heads: impl Iterator<Item = String>, ways: &[usize]) -> String {
    let mut table = String::new();
    cells(&mut table, "way", heads);
    cells(&mut table, "---", columns.iter().map(|_| "---".to_owned()));
    for way in ways {
        let cell = |column: &Column| {
            let told = |degrees: f64| if degrees < 0.005 { "0".to_owned() } else { format!("{degrees:.2}") };
            let [rms, most] = column.errors[*way].map(told);
            format!("{rms} ({most})")
        };
        cells(&mut table, name(*way), columns.iter().map(cell));
    }
    table
}

fn costs() -> String {
    let displacement = FieldSet::of(fields_of(Group::Displacement));
    let mut table = String::from("| way | N | channels | fields transformed | ms alone | ms with displacement |\n");
    table += "|---|---|---|---|---|---|\n";
    for n in SIDES {
        let sea = sea(n, 1.0 / 3.0, &ONE);
        let mut cpu = Cpu::new(Some(1));
        cpu.load(&sea).expect("the CPU loads");
        let alone = WAYS.map(|way| plan(way, channels(way), 1));
        let beside = WAYS.map(|way| plan(way, channels(way).union(displacement), 1));
        let plans: Vec<Plan> = alone.into_iter().chain(beside).chain([plan(Normals::None, displacement, 1)]).collect();
        let mut times = vec![Vec::with_capacity(ROUNDS); plans.len()];
        for round in 0..ROUNDS + 2 {
            for (plan, times) in plans.iter().zip(&mut times) {
                let start = Instant::now();
                cpu.step(240 * round as i64, plan).expect("the plan fits");
                if round >= 2 {
                    times.push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
        let told: Vec<String> = times.iter_mut().map(|times| quartiles(times)).collect();
        for (i, way) in WAYS.into_iter().enumerate() {
            let (streamed, transformed) = (channels(way).len(), plans[i].cascades[0].transforms());
            let (alone, beside) = (&told[i], &told[WAYS.len() + i]);
            let name = way.name();
            writeln!(table, "| {name} | {n} | {streamed} | {transformed} | {alone} | {beside} |").expect("a string");
        }
        writeln!(table, "| none | {n} | 0 | 0 | | {} |", told[2 * WAYS.len()]).expect("a string");
    }
    table
}

/// Median and quartiles.
fn quartiles(times: &mut [f64]) -> String {
    times.sort_by(f64::total_cmp);
    let at = |quarter: usize| times[times.len() * quarter / 4];
    format!("{:.2} ({:.2}, {:.2})", at(2), at(1), at(3))
}

struct Tables {
    sum: [Column; 4],
    one: [Column; 4],
    full: [Column; 4],
    finer: [Column; 4],
}

impl Tables {
    fn page(&self, costs: &str) -> String {
        let sides = || SIDES.iter().map(|n| format!("N = {n}"));
        let samples = || self.finer.iter().map(|c| format!("N = {}, {:.0} samples a wave", c.n, c.samples));
        let of_one = |columns: &[Column]| errors(columns, sides(), &[0, 1, 2, 3, 4]);
        let folded = self.sum.iter().chain(&self.full).map(|column| column.folded).fold(0.0, f64::max);
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let [sum, one, full] = [errors(&self.sum, sides(), &[0, 1, 2, 3, 4, 5]), of_one(&self.one), of_one(&self.full)];
        let finer = errors(&self.finer, samples(), &[3, 4]);
        format!(
            "# Ways of normals

Written by `just normals` (`cargo bench --bench normals -- --write`) on a machine of {threads} cores.

`effects.normals` of a scene says what clients make normals of:

- `exact`, the default: they add up slopes and derivatives of all cascades, five channels. It has no error but rounding.
- `diagonal`: the same without the mixed derivative, four channels. Choose it where one channel less matters and two
  channels err too much; of one cascade `displaced-slopes` is better and smaller.
- `displaced-slopes`: each cascade's own slopes as seen from the world, two channels. Exact where there is one cascade; of
  several, each ignores how the others squeeze the water. Choose it where bandwidth is short.
- `central-difference`: the same from differences of the displaced points, two channels, and no transforms but those of
  displacement, so that it costs the server least where displacement is made anyway; alone it saves nothing. It blunts
  short waves. Choose it where bandwidth and the server's time are both short and bands end well below the grid's own
  limit.
- `sobel`: the mean of central differences over three lines, weighted 1, 2, 1. It blunts more and costs as much; choose
  it only to look like a renderer that does so.

## Errors

Angle between a way's normal and the exact one of the f64 reference, degrees: rms, and in brackets the 99th percentile; 0
is below .005. Wind {WIND_MPS} m/s over 200 km, from {DIRECTION_DEG} degrees. Before quantising.
Where the surface folds (its Jacobian is below {FOLDED}) it is left out: at most {:.2} % of it. With N waves get finer,
too: the band ends at a share of the grid's own limit.

Three cascades ({} m), the default band limit 1/3:

{sum}
One cascade ({} m), band limit 1/3, six samples in its shortest wave:

{one}
The same, the full band, two samples:

{full}
The same waves on finer grids: differences err with the square of the spacing.

{finer}
## Costs

Of one cascade a frame, band limit 1/3, on one thread, in ms: median (quartiles) of {ROUNDS} interleaved rounds. *Alone*
makes what the way streams; *with displacement* makes `displacement`, too, which shares its transforms with differences.
Two fields share a transform. A channel is two bytes a sample.

{costs}",
            100.0 * folded,
            THREE.map(|metres| metres.to_string()).join(", "),
            ONE[0],
        )
    }
}
