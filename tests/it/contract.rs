//! What every backend promises, whatever it runs on: one body, each backend there is.

use swellcast::backend::{Backend, BackendError, Cpu};
use swellcast::plan::{CascadePlan, Field, FieldSet, FoamWork, Plan};
use swellcast::scene::Effects;
use swellcast::sea::{Sea, Timeline};

use crate::support::{full, plan, wind_sea};

fn backends() -> Vec<Box<dyn Backend>> {
    let mut all: Vec<Box<dyn Backend>> = vec![Box::new(Cpu::new(Some(2)))];
    #[cfg(feature = "gpu")]
    all.extend(crate::gpu::gpu(swellcast::backend::Storage::F32).map(|gpu| -> Box<dyn Backend> { Box::new(gpu) }));
    all
}

fn sea(patches_m: &[f64]) -> Sea {
    Timeline::new(&wind_sea(15.0, 32, patches_m)).at(0)
}

const FOAM: FoamWork = FoamWork { restart: false, decay: 0.9, growth: 0.5, advance: true, breaks: true };

#[test]
fn a_plan_for_another_sea_is_refused_and_the_next_one_is_not() {
    let sea = sea(&[150.0]);
    for mut backend in backends() {
        backend.load(&sea).unwrap();
        let wrong = Plan { cascades: vec![CascadePlan::default(); 2] };
        let got = backend.step(0, &wrong).map(|surface| surface.tick);
        assert_eq!(got, Err(BackendError::PlanMismatch { plan: 2, sea: 1 }), "{}", backend.name());
        assert!(backend.step(0, &plan(&sea, &[Field::Height])).is_ok(), "{}", backend.name());
    }
}

#[test]
fn what_a_plan_doesnt_name_isnt_there_and_nothing_is_nothing() {
    let sea = sea(&[150.0, 40.0]);
    for mut backend in backends() {
        backend.load(&sea).unwrap();
        backend.step(0, &plan(&sea, &Field::SPECTRAL)).unwrap();
        let surface = backend.step(240, &plan(&sea, &[Field::Height])).unwrap();
        assert_eq!(surface.tick, 240);
        for cascade in &surface.cascades {
            assert_eq!(cascade.plane(Field::Height).map(<[f32]>::len), Some(32 * 32));
            assert!(cascade.plane(Field::SlopeX).is_none() && cascade.plane_at(1, Field::Height).is_none());
        }
        let nothing = backend.step(480, &Plan { cascades: vec![CascadePlan::default(); 2] }).unwrap();
        assert_eq!(nothing.tick, 480);
        assert!(nothing.cascades.iter().all(|cascade| Field::ALL.iter().all(|f| cascade.plane(*f).is_none())));
    }
}

#[test]
fn still_water_is_flat_and_doesnt_fold() {
    let sea = sea(&[150.0]);
    let waves = FieldSet::of(&Field::ALL).difference(FieldSet::of(&[Field::Foam]));
    for mut backend in backends() {
        backend.load(&sea).unwrap();
        // What moved before must not be seen again.
        backend.step(0, &plan(&sea, &Field::SPECTRAL)).unwrap();
        let surface = backend.step(240, &Plan { cascades: vec![full(waves, None, 1.0).still()] }).unwrap();
        for field in waves.iter() {
            let rest = if matches!(field, Field::Jacobian | Field::Eigenvalue) { 1.0 } else { 0.0 };
            let plane = surface.cascades[0].plane(field).unwrap();
            assert!(plane.iter().all(|v| *v == rest), "{field:?}");
        }
    }
}

#[test]
fn without_choppiness_nothing_moves_sideways() {
    let sea = Sea { choppiness: 0.0, ..sea(&[150.0]) };
    for mut backend in backends() {
        backend.load(&sea).unwrap();
        let surface = backend.step(0, &plan(&sea, &Field::SPECTRAL)).unwrap();
        let is_still = |field: Field| surface.cascades[0].plane(field).unwrap().iter().all(|v| *v == 0.0);
        assert!(FieldSet::SIDEWAYS.iter().all(is_still) && !is_still(Field::Height), "{}", backend.name());
    }
}

#[test]
fn foam_stays_with_its_cascade_through_a_load_and_fades_where_none_breaks() {
    let before = sea(&[150.0, 40.0]);
    // The shorter one stays, at another place.
    let after = Sea { cascades: before.cascades[1..].to_vec(), ..before.clone() };
    for mut backend in backends() {
        backend.load(&before).unwrap();
        let work = |foam: FoamWork| CascadePlan::new([], Some(foam), &Effects::default());
        for step in 0..30 {
            backend.step(step * 720, &Plan { cascades: vec![work(FOAM); 2] }).unwrap();
        }
        let most = |backend: &dyn Backend| {
            let plane = backend.surface().cascades.last().unwrap().plane(Field::Foam).unwrap();
            plane.iter().fold(0.0_f32, |most, foam| most.max(*foam))
        };
        let grown = most(&*backend);
        assert!(grown > 0.05, "{}: no foam in the first place", backend.name());
        backend.load(&after).unwrap();
        let still = FoamWork { breaks: false, decay: 0.5, ..FOAM };
        backend.step(21_600, &Plan { cascades: vec![work(still)] }).unwrap();
        assert_eq!(most(&*backend), 0.5 * grown, "{}", backend.name());
        backend.step(22_320, &Plan { cascades: vec![work(FoamWork { restart: true, ..still })] }).unwrap();
        assert_eq!(most(&*backend), 0.0, "{}", backend.name());
    }
}
