//! The model behind the backend and the probes.

use std::sync::Arc;

use super::*;
use swellcast::engine::{ProbeFields, ProbeMethod, Prober, Stepper, Work};
use swellcast::plan::{Demand, fields_of};
use swellcast::tile::{SentFrame, decode};
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

#[test]
fn the_backend_serves_the_model_foam_included_and_without_a_transform() {
    let scene = preset("trochoid").unwrap();
    let timeline = Arc::new(Timeline::new(&scene));
    let unit = |level, group| UnitName { cascade: 0, level, class: ErrorClass::Millimetre, group, codec: Codec::I16 };
    let demand: Demand =
        Group::ALL.into_iter().flat_map(|group| [(unit(0, group), 240), (unit(2, group), 240)]).collect();
    let mut stepper = Stepper::new(Box::new(Cpu::new(Some(2))), Arc::clone(&timeline), 1);
    stepper.set_demand(&demand);
    let tick = 7200;
    while stepper.warm_foam(tick).unwrap() {}
    let batch = stepper.frames(tick, &demand).unwrap();
    assert_eq!((batch.frames.len(), batch.refused, batch.work), (demand.len(), 0, Work::default()));
    let sea = timeline.at(tick);
    let trochoids = Trochoids::new(&sea.cascades[0], &sea);
    for SentFrame { unit, bytes: frame, .. } in &batch.frames {
        if unit.group == Group::Foam {
            continue;
        }
        let n = sea.cascades[0].cascade.level(unit.level).0;
        let mut planes: [Vec<f32>; 16] = Default::default();
        trochoids.fill(tick, n, FieldSet::of(&Field::ALL), &mut planes);
        let decoded = decode(frame).unwrap();
        for (field, (plane, bound)) in
            fields_of(unit.group).iter().zip(decoded.planes.iter().zip(decoded.header.max_error))
        {
            let error = plane.iter().zip(&planes[*field as usize]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(error <= bound, "{field:?} of level {} errs {error}", unit.level);
        }
    }
}

#[test]
fn probes_read_the_model_where_they_are_asked() {
    let timeline = Arc::new(Timeline::new(&preset("trochoid").unwrap()));
    let (tick, sea) = (12_345, timeline.at(12_345));
    let trochoids = Trochoids::new(&sea.cascades[0], &sea);
    let mut prober = Prober::new(Box::new(Cpu::new(Some(1))), Arc::clone(&timeline));
    let points = [[0.0, 0.0], [13.7, -912.0], [1e6, 3.0]];
    for method in [ProbeMethod::Grid, ProbeMethod::Direct { share: 1.0 }] {
        let probed = prober.probe(tick, &points, ProbeFields::ALL, method).unwrap();
        assert_eq!(probed.transforms, 0);
        for (answer, [x, z]) in probed.answers.iter().zip(points) {
            let at = trochoids.at(tick, x, z, 0.0).map(f64::from);
            let of = |field: Field| at[field as usize];
            let (hx, hz) = (of(Field::SlopeX), of(Field::SlopeZ));
            let length = (hx * hx + hz * hz + 1.0).sqrt();
            assert_eq!((answer.height, answer.residual, answer.folded), (of(Field::Height), 0.0, false));
            let normal = [-hx / length, 1.0 / length, -hz / length];
            assert!(answer.normal.unwrap().iter().zip(normal).all(|(a, b)| (a - b).abs() < 1e-9));
            assert_eq!(answer.velocity, Some([Field::VelocityX, Field::VelocityY, Field::VelocityZ].map(of)));
        }
    }
}
