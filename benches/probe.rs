//! Cost of a point query on one thread: from grids, of all fields and of the height alone, and from the modes; and what
//! points that clients follow add to a tick of the engine.
//!
//! `cargo bench --bench probe`. The surface is made once a tick, whatever the number of points; its cost stands apart.
#![allow(clippy::disallowed_methods, missing_docs, reason = "a bench measures time")]

use std::sync::Arc;
use std::time::Instant;

use swellcast::backend::Cpu;
use swellcast::engine::{PointsWish, ProbeAnswer, ProbeFields, ProbeMethod, Prober, Stepper};
use swellcast::plan::Demand;
use swellcast::scene::preset;
use swellcast::sea::Timeline;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

const POINTS: usize = 10_000;
const COMPARED: usize = 200;
const ROUNDS: usize = 20;
const ALL_MODES: ProbeMethod = ProbeMethod::Direct { share: 1.0 };

fn main() {
    let scene = preset("beaufort-5").expect("a preset");
    let timeline = Arc::new(Timeline::new(&scene));
    let mut prober = Prober::new(Box::new(Cpu::new(Some(1))), Arc::clone(&timeline));
    let grids: Vec<String> =
        timeline.layout().cascades.iter().map(|c| format!("{} of {:.1} m", c.n, c.patch_m)).collect();
    println!("{POINTS} random points within 4 km, one thread, grids {}", grids.join(", "));
    println!("{:<34}{:>10}{:>18}{:>12}", "", "median ms", "quartiles", "ns a point");
    let points = points(POINTS, 4000.0);
    for (name, wanted) in [("height alone", ProbeFields::HEIGHT), ("all fields", ProbeFields::ALL)] {
        let mut tick = 0;
        let mut transforms = 0;
        row(&format!("surface, {name}"), 0, || {
            tick += 240;
            transforms = probe(&mut prober, tick, &points[..1], wanted, ProbeMethod::Grid).1;
        });
        row(&format!("{POINTS} points, {name}"), POINTS, || {
            drop(probe(&mut prober, tick, &points, wanted, ProbeMethod::Grid))
        });
        println!("  {transforms} transforms a tick");
    }
    let few = &points[..COMPARED];
    row("200 points from all modes", COMPARED, || drop(probe(&mut prober, 0, few, ProbeFields::ALL, ALL_MODES)));
    let strongest = ProbeMethod::Direct { share: 0.99 };
    row("200 points from 99 % of the energy", COMPARED, || {
        drop(probe(&mut prober, 0, few, ProbeFields::ALL, strongest));
    });

    for name in ["beaufort-5", "beaufort-9", "trochoid"] {
        let timeline = Arc::new(Timeline::new(&preset(name).expect("a preset")));
        for clients in [1, 5] {
            follow(name, &timeline, &points, clients);
        }
    }

    let (grid, _) = probe(&mut prober, 0, &points, ProbeFields::ALL, ProbeMethod::Grid);
    let mean = grid.iter().map(|a| f64::from(a.iterations)).sum::<f64>() / POINTS as f64;
    let most = grid.iter().map(|a| a.iterations).max().unwrap_or(0);
    let residual = grid.iter().map(|a| a.residual).fold(0.0, f64::max);
    let folded = grid.iter().filter(|a| a.folded).count();
    println!("steps: {mean:.2} on average, {most} at most; largest residual {:.4} mm; {folded} folded", residual * 1e3);
    let (direct, _) = probe(&mut prober, 0, few, ProbeFields::ALL, ALL_MODES);
    let errors: Vec<f64> = grid.iter().zip(&direct).map(|(a, b)| (a.height - b.height).abs() * 1e3).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / COMPARED as f64).sqrt();
    let largest = errors.iter().copied().fold(0.0, f64::max);
    println!("height against all modes, {COMPARED} points: rms {rms:.3} mm, at most {largest:.3} mm");
}

/// Ticks in which every unit of the full grids is wanted, without points and with them, in turn.
fn follow(name: &str, timeline: &Arc<Timeline>, points: &[[f64; 2]], clients: usize) {
    let mut stepper = Stepper::new(Box::new(Cpu::new(None)), Arc::clone(timeline), 1);
    let unit = |cascade, group| UnitName { cascade, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::I16 };
    let numbers: Vec<u8> = timeline.lives().map(|life| life.cascade.index).collect();
    let wanted = [Group::Displacement, Group::Slopes, Group::Derivatives, Group::Velocity, Group::Jacobian];
    let demand: Demand = numbers.iter().flat_map(|number| wanted.map(|group| (unit(*number, group), 240))).collect();
    stepper.set_demand(&demand);
    let share = points.len() / clients;
    let wish = |(client, points): (usize, &[[f64; 2]])| PointsWish {
        client: client as u64,
        id: 1,
        interval: 240,
        points: points.into(),
    };
    let wishes: Vec<PointsWish> = points.chunks(share).enumerate().map(wish).collect();
    let mut times = [Vec::new(), Vec::new()];
    for round in 0..2 * (ROUNDS as i64 + 2) {
        let with = round % 2;
        stepper.set_points(if with == 1 { wishes.clone() } else { Vec::new() });
        if with == 1 {
            // What a change of the sea alone takes is none of a tick's cost.
            stepper.frames(240 * round, &demand).expect("the CPU steps");
        }
        let start = Instant::now();
        let batch = stepper.frames(240 * (round + 1), &demand).expect("the CPU steps");
        times[with as usize].push(start.elapsed().as_secs_f64() * 1e3);
        assert_eq!(batch.points.len(), if with == 1 { clients } else { 0 });
    }
    let [without, with] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    let n = points.len();
    println!("{name}: a tick {without:.2} ms, and with {n} points of {clients} clients {with:.2} ms");
}

fn probe(
    prober: &mut Prober,
    tick: i64,
    points: &[[f64; 2]],
    wanted: ProbeFields,
    method: ProbeMethod,
) -> (Vec<ProbeAnswer>, u64) {
    let probed = prober.probe(tick, points, wanted, method).expect("the CPU probes");
    (probed.answers, probed.transforms)
}

/// Median and quartiles of some rounds.
fn row(name: &str, points: usize, mut work: impl FnMut()) {
    let mut times = Vec::with_capacity(ROUNDS);
    for round in 0..ROUNDS + 2 {
        let start = Instant::now();
        work();
        if round >= 2 {
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    times.sort_by(f64::total_cmp);
    let at = |share: usize| times[times.len() * share / 4];
    let each = if points > 0 { format!("{:.0}", at(2) * 1e6 / points as f64) } else { String::new() };
    println!("{name:<34}{:>10.3}{:>9.3}{:>9.3}{each:>12}", at(2), at(1), at(3));
}

/// Random points around the origin, the same every time.
fn points(n: usize, within_m: f64) -> Vec<[f64; 2]> {
    let mut state = 1_u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..n).map(|_| [within_m * unit(), within_m * unit()]).collect()
}
