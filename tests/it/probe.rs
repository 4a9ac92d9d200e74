//! Laws of point queries: grids say what the direct sum says, the particle found has come to the point, what was made
//! is not made again.

use std::sync::Arc;

use swellcast::backend::Cpu;
use swellcast::engine::{ProbeAnswer, ProbeFields, ProbeMethod, Prober};
use swellcast::reference;
use swellcast::scene::Scene;
use swellcast::sea::Timeline;

use crate::random::Random;
use crate::support::scene;

fn prober(scene: &Scene) -> (Prober, Arc<Timeline>) {
    let timeline = Arc::new(Timeline::new(scene));
    (Prober::new(Box::new(Cpu::new(Some(2))), Arc::clone(&timeline)), timeline)
}

fn points(random: &mut Random, n: usize, within_m: f64) -> Vec<[f64; 2]> {
    (0..n).map(|_| [(random.unit() - 0.5) * within_m, (random.unit() - 0.5) * within_m]).collect()
}

#[test]
fn grids_agree_with_the_direct_sum() {
    let mut random = Random(7);
    for (name, text) in [
        ("11 m/s", "[wind]\nspeed_mps = 11\n[cascades]\nn = 256\npatches_m = [500]"),
        ("20 m/s", "[wind]\nspeed_mps = 20\nfetch_m = 300e3\n[cascades]\nn = 256\npatches_m = [500]"),
        ("5 m/s", "[wind]\nspeed_mps = 5\n[cascades]\nn = 256\npatches_m = [500]"),
        ("bf5", "[wind]\nspeed_mps = 9\nfetch_m = 200e3"),
        ("bf5 one", "[wind]\nspeed_mps = 9\nfetch_m = 200e3\n[cascades]\nn = 256\npatches_m = [500, 90, 17]"),
    ] {
        let scene = scene(text);
        let (mut prober, timeline) = prober(&scene);
        let tick = 7200 * 31 + 240;
        let points = points(&mut random, 300, 2000.0);
        let probed = prober.probe(tick, &points, ProbeFields::ALL, ProbeMethod::Grid).unwrap();
        let direct = prober.probe(tick, &points, ProbeFields::ALL, ProbeMethod::Direct { share: 1.0 }).unwrap();
        let (mut h, mut n, mut v, mut j, mut it, mut res) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0, 0.0_f64);
        let mut hh = 0.0;
        let mut folded = 0;
        for (a, b) in probed.answers.iter().zip(&direct.answers) {
            if a.folded || b.folded {
                folded += 1;
                continue;
            }
            h = h.max((a.height - b.height).abs());
            hh += (a.height - b.height).powi(2);
            let (x, y) = (a.normal.unwrap(), b.normal.unwrap());
            n = n.max((0..3).map(|i| x[i] * y[i]).sum::<f64>().clamp(-1.0, 1.0).acos().to_degrees());
            v = v.max((0..3).map(|i| (a.velocity.unwrap()[i] - b.velocity.unwrap()[i]).powi(2)).sum::<f64>().sqrt());
            j = j.max((a.jacobian.unwrap() - b.jacobian.unwrap()).abs());
            it = it.max(a.iterations);
            res = res.max(a.residual);
        }
        let rms = (hh / 300.0_f64).sqrt();
        let hs = timeline.hs_at(tick);
        println!(
            "{name:8} hs {hs:.2} folded {folded} height max {:.2} mm rms {:.3} mm, normal {n:.3} deg, velocity {v:.4}, jacobian {j:.4}, iterations {it}, residual {res:e}",
            h * 1e3,
            rms * 1e3
        );
        let p = reference::probe(&timeline.at(tick), tick, points[0][0], points[0][1]);
        let q: &ProbeAnswer = &direct.answers[0];
        println!("   {} {} {:?} {:?}", p.height - q.height, p.jacobian - q.jacobian.unwrap(), p.velocity, q.velocity);
    }
}
