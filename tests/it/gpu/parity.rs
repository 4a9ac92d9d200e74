//! Field by field, the GPU makes what the CPU makes; and a GPU that doesn't is found out.

use swellcast::backend::{Backend, Storage, Tap};
use swellcast::plan::{CascadePlan, Field, FieldSet, FoamWork, Plan};
use swellcast::scene::{Effects, Normals};
use swellcast::sea::Timeline;

use super::{Error, both, gpu, scale};
use crate::support::{DAY, TEN_YEARS, plan, wind_sea};

const WAVES: [Field; 15] = *Field::ALL.first_chunk().unwrap();

/// Worst errors of all fields of all cascades.
fn errors(surfaces: &[swellcast::backend::Surface; 2], fields: &[Field], level: u8, hs: f64) -> Vec<(Field, Error)> {
    let [got, want] = surfaces;
    let mut errors = Vec::new();
    for (got, want) in got.cascades.iter().zip(&want.cascades) {
        for field in fields {
            let (got, want) = (got.plane_at(level, *field).unwrap(), want.plane_at(level, *field).unwrap());
            assert!(got.iter().any(|v| *v != 0.0), "{field:?} came back all zero");
            errors.push((*field, Error::of(got, want, scale(*field, want, hs))));
        }
    }
    errors
}

#[test]
fn fields_are_those_of_the_cpu_today_tomorrow_and_in_ten_years() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(12.0, 128, &[400.0, 90.0, 20.0]));
    let (sea, hs) = (timeline.at(0), timeline.hs_at(0));
    for tick in [0, DAY, TEN_YEARS] {
        let surfaces = both(&mut gpu, &sea, tick, &plan(&sea, &WAVES));
        for (field, error) in errors(&surfaces, &WAVES, 0, hs) {
            assert!(error.is_parity(), "{field:?} at tick {tick}: {error:?}");
        }
    }
}

#[test]
fn every_grid_from_8_to_2048_is_the_cpus() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    // Levels of a small grid, then grids of their own.
    for (n, levels) in [(32, 0..3), (64, 0..1), (128, 0..1), (256, 0..1), (512, 0..1), (1024, 0..1), (2048, 0..1)] {
        let timeline = Timeline::new(&wind_sea(12.0, n, &[200.0]));
        let (sea, hs) = (timeline.at(0), timeline.hs_at(0));
        let fields = if n > 256 { &[Field::Height, Field::Dx][..] } else { &WAVES[..] };
        for level in levels {
            let work = CascadePlan::new([(level, FieldSet::of(fields))], None, &Effects::default());
            let plan = Plan { cascades: vec![work] };
            let surfaces = both(&mut gpu, &sea, 7200, &plan);
            let [got, _] = &surfaces;
            assert_eq!(got.cascades[0].plane_at(level, Field::Height).unwrap().len(), (n >> level) * (n >> level));
            for (field, error) in errors(&surfaces, fields, level, hs) {
                assert!(error.is_parity(), "{field:?} of {n} at level {level}: {error:?}");
            }
        }
    }
}

#[test]
fn evolve_and_foam_are_the_cpus_between_the_passes() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(20.0, 64, &[120.0]));
    let sea = timeline.at(0);
    let mut cpu = swellcast::backend::Cpu::new(Some(1));
    cpu.load(&sea).unwrap();
    gpu.load(&sea).unwrap();
    let mut most = 0.0_f32;
    for step in 0..20 {
        let work = FoamWork { restart: step == 0, decay: 0.97, growth: 0.2, advance: true, breaks: true };
        let cascade = CascadePlan::new([], Some(work), &Effects::default());
        let plan = Plan { cascades: vec![cascade] };
        let [got, want] = [gpu.step(step * 480, &plan).unwrap(), cpu.step(step * 480, &plan).unwrap()]
            .map(|surface| surface.cascades[0].plane(Field::Foam).unwrap().to_vec());
        // Where the water is at its threshold either may break.
        let apart = got.iter().zip(&want).filter(|(got, want)| (*got - *want).abs() > 1e-3).count();
        assert!(apart * 1000 <= got.len(), "{apart} of {} samples differ", got.len());
        most = want.iter().fold(most, |most, foam| most.max(*foam));
    }
    assert!(most > 0.1, "no foam was compared: {most}");
    let [got, want] = [gpu.tap(0, Tap::Heights).unwrap(), cpu.tap(0, Tap::Heights).unwrap()];
    let top = want.iter().fold(0.0_f32, |top, v| top.max(v.abs()));
    let error = Error::of(&got, &want, f64::from(top));
    assert!(error.max < 3e-7 && top > 0.0, "{error:?} of {top}");
    let [got, want] = [gpu.tap(0, Tap::HeldFoam).unwrap(), cpu.tap(0, Tap::HeldFoam).unwrap()];
    assert_eq!(got.len(), want.len());
    assert!(got.iter().zip(&want).filter(|(got, want)| (*got - *want).abs() > 1e-3).count() * 1000 <= got.len());
}

#[test]
fn normals_of_every_way_are_the_cpus() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(9.0, 64, &[150.0, 30.0]));
    let (sea, hs) = (timeline.at(0), timeline.hs_at(0));
    let fields = [Field::NormalX, Field::NormalZ];
    for normals in
        [Normals::Exact, Normals::Diagonal, Normals::DisplacedSlopes, Normals::CentralDifference, Normals::Sobel]
    {
        let effects = Effects { normals, ..Effects::default() };
        let work = CascadePlan::new([(0, FieldSet::of(&fields))], None, &effects);
        let plan = Plan { cascades: vec![work; 2] };
        for (field, error) in errors(&both(&mut gpu, &sea, 99, &plan), &fields, 0, hs) {
            // One over a Jacobian, and differences of neighbours, lose digits.
            assert!(error.rms <= 1e-5 && error.max <= 1e-3, "{normals:?} {field:?}: {error:?}");
        }
    }
}

#[test]
fn a_fields_bits_depend_on_no_other_demand() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(9.0, 64, &[150.0, 30.0]));
    let sea = timeline.at(0);
    gpu.load(&sea).unwrap();
    let all = gpu.step(4711, &plan(&sea, &WAVES)).unwrap().clone();
    for field in WAVES {
        let alone = gpu.step(4711, &plan(&sea, &[field])).unwrap();
        for (alone, all) in alone.cascades.iter().zip(&all.cascades) {
            assert!(alone.plane(field) == all.plane(field), "{field:?}");
        }
    }
}

#[test]
fn frames_under_way_come_back_in_order_with_their_ticks() {
    let Some(mut gpu) = gpu(Storage::F32) else { return };
    let timeline = Timeline::new(&wind_sea(9.0, 32, &[150.0]));
    let sea = timeline.at(0);
    gpu.load(&sea).unwrap();
    let plan = plan(&sea, &[Field::Height]);
    let ticks = [0, 240, 480, 720, 960, 1200];
    for tick in ticks {
        gpu.submit(tick, &plan).unwrap();
    }
    let collected: Vec<_> = ticks.iter().map(|_| gpu.collect().unwrap().clone()).collect();
    for (tick, surface) in ticks.into_iter().zip(collected) {
        assert_eq!(surface.tick, tick);
        let alone = gpu.step(tick, &plan).unwrap();
        assert!(surface.cascades[0].plane(Field::Height) == alone.cascades[0].plane(Field::Height), "tick {tick}");
    }
}

#[test]
fn half_storage_errs_by_a_thousandth_and_never_overflows() {
    let Some(mut gpu) = gpu(Storage::F16) else { return };
    // A breath of wind, and the worst that there is.
    for speed in [5.0, 12.0, 70.0] {
        let timeline = Timeline::new(&wind_sea(speed, 64, &[300.0, 40.0]));
        let (sea, hs) = (timeline.at(0), timeline.hs_at(0));
        let fields = [Field::Height, Field::Dx, Field::SlopeX, Field::Dxx, Field::Dxz, Field::VelocityY];
        let mut worst = 0.0_f64;
        for (field, error) in errors(&both(&mut gpu, &sea, 99, &plan(&sea, &fields)), &fields, 0, hs) {
            assert!(error.rms <= 1e-3 && error.max <= 1e-2, "{field:?} at {speed} m/s: {error:?}");
            worst = worst.max(error.rms);
        }
        assert!(worst > 2e-6, "this was no 16-bit storage");
    }
}

#[test]
fn a_backend_that_errs_is_found_out() {
    let timeline = Timeline::new(&wind_sea(12.0, 64, &[150.0]));
    let (sea, hs) = (timeline.at(0), timeline.hs_at(0));
    let plane = crate::support::cpu_fields(&timeline, 7, 0, &[Field::Height]).remove(0);
    let is_parity = |got: &[f32]| Error::of(got, &plane, hs).is_parity();
    assert!(is_parity(&plane));
    assert!(!is_parity(&plane.iter().map(|v| -v).collect::<Vec<_>>()), "a sign");
    assert!(!is_parity(&vec![0.0; plane.len()]), "nothing");
    assert!(!is_parity(&vec![f32::NAN; plane.len()]), "no numbers");
    let mut moved = plane.clone();
    moved.rotate_right(1);
    assert!(!is_parity(&moved), "a sample to the side");
    // One bin to the side in the spectrum: every mode one place on.
    let mut shifted = sea.clone();
    shifted.cascades[0].modes.rotate_right(1);
    let mut cpu = swellcast::backend::Cpu::new(Some(1));
    cpu.load(&shifted).unwrap();
    let got = cpu.step(7, &plan(&sea, &[Field::Height])).unwrap();
    assert!(!is_parity(got.cascades[0].plane(Field::Height).unwrap()), "a bin to the side");
}
