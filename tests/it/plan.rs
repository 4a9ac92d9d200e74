//! Plans: the fewest transforms for a demand, the same bits whatever else is wanted, and levels that fold nothing back.

use swellcast::backend::{Backend, CascadeSurface, Cpu};
use swellcast::plan::{CascadePlan, Field, FieldSet, FoamWork, Packing, Plan};
use swellcast::reference;
use swellcast::scene::{Effects, Normals};
use swellcast::sea::{CascadeModes, Mode, Sea, Timeline};

use crate::support::{DAY, full, max_error, wind_sea};

const FOAM: FoamWork = FoamWork { restart: false, decay: 0.9, growth: 0.5, advance: true, breaks: true };

fn transforms(fields: &[Field], effects: &Effects) -> usize {
    CascadePlan::new([(0, FieldSet::of(fields))], None, effects).transforms()
}

#[test]
fn work_is_what_is_wanted_and_no_more() {
    use Field::{
        Dx, Dxx, Dxz, Dz, Dzz, Eigenvalue, Foam, Height, Jacobian, NormalX, NormalZ, SlopeX, SlopeZ, VelocityY,
    };
    let all = Effects::default();
    let flat = Effects { choppiness: 0.0, ..all };
    for (fields, want, without_chop) in [
        (&[][..], 0, 0),
        (&[Height], 1, 1),
        (&[Dx, Height, Dz], 3, 1),
        (&[SlopeX, SlopeZ], 2, 2),
        (&[Dxx, Dzz, Dxz], 3, 0),
        (&[Jacobian], 3, 0),
        (&[Jacobian, Eigenvalue, Dxx, Dzz], 3, 0),
        (&[VelocityY], 1, 1),
        // Foam that nobody runs is none.
        (&[Foam], 0, 0),
        (&Field::ALL, 11, 4),
    ] {
        assert_eq!(transforms(fields, &all), want, "{fields:?}");
        assert_eq!(transforms(fields, &flat), without_chop, "{fields:?} without choppiness");
    }
    for (normals, want) in Normals::ALL.into_iter().zip([0, 5, 4, 5, 3, 3]) {
        assert_eq!(transforms(&[NormalX, NormalZ], &Effects { normals, ..all }), want, "{normals:?}");
    }
    assert_eq!(full(FieldSet::NONE, Some(FOAM), 1.0).transforms(), 3);
    assert_eq!(full(FieldSet::of(&[Jacobian]), Some(FOAM), 1.0).transforms(), 3, "foam shares what is there");
    // Foam is of the full grid whatever level is wanted, and a still cascade needs no transform.
    let coarse = CascadePlan::new([(2, FieldSet::of(&[Height])), (2, FieldSet::of(&[Dx]))], Some(FOAM), &all);
    let levels: Vec<(u8, usize)> = coarse.levels.iter().map(|level| (level.level, level.transforms())).collect();
    assert_eq!(levels, [(0, 3), (2, 3)]);
    assert_eq!(coarse.still().transforms(), 0);
}

#[test]
fn every_plan_makes_all_that_is_wanted_and_each_field_once() {
    for bits in 0..1_u32 << 11 {
        let wanted: Vec<Field> = Field::SPECTRAL.into_iter().filter(|field| bits >> *field as u8 & 1 == 1).collect();
        let plan = CascadePlan::new([(1, FieldSet::of(&wanted))], None, &Effects::default());
        let made: Vec<Field> =
            plan.levels.iter().flat_map(|level| &level.transforms).fold(vec![], |mut all, packing| {
                all.extend(packing.fields().iter());
                all
            });
        assert!(wanted.iter().all(|field| made.contains(field)), "{wanted:?}");
        assert_eq!(made.len(), FieldSet::of(&made).len(), "{wanted:?}: a field is made twice");
        // Nothing but the partners of what is wanted.
        assert!(Packing::of(FieldSet::of(&made)).all(|p| wanted.iter().any(|field| p.fields().contains(*field))));
    }
}

fn step(sea: &Sea, tick: i64, cascade: CascadePlan) -> Vec<CascadeSurface> {
    let mut cpu = Cpu::new(Some(2));
    cpu.load(sea).unwrap();
    let plan = Plan { cascades: vec![cascade; sea.cascades.len()] };
    cpu.step(tick, &plan).unwrap().cascades.clone()
}

fn bits(surface: &CascadeSurface, level: u8, field: Field) -> Vec<u32> {
    surface.plane_at(level, field).unwrap().iter().map(|value| value.to_bits()).collect()
}

#[test]
fn a_field_is_the_same_bits_whatever_else_is_wanted() {
    let sea = Timeline::new(&wind_sea(12.0, 64, &[300.0, 40.0])).at(DAY);
    let everything = FieldSet::of(&Field::ALL);
    let all =
        step(&sea, DAY, CascadePlan::new((0..4).map(|level| (level, everything)), Some(FOAM), &Effects::default()));
    for level in 0..4 {
        for field in Field::ALL.into_iter().filter(|field| *field != Field::Foam) {
            let alone = step(&sea, DAY, CascadePlan::new([(level, FieldSet::of(&[field]))], None, &Effects::default()));
            for (all, alone) in all.iter().zip(&alone) {
                assert!(bits(all, level, field) == bits(alone, level, field), "{field:?} of level {level}");
            }
        }
    }
}

/// The same modes on a grid whose band reaches to Nyquist: nothing can be skipped.
fn unpruned(modes: &CascadeModes) -> CascadeModes {
    let mut cascade = modes.cascade;
    cascade.half = cascade.n / 2 - 1;
    let none = Mode { forward: Default::default(), backward: Default::default(), cycles: 1, offset: 0, widening: 1.0 };
    let side = 2 * cascade.half + 1;
    let mut all = vec![none; (cascade.half + 1) * side];
    for (i, mode) in modes.modes.iter().enumerate() {
        let (n, m) = (i / modes.rows(), i % modes.rows());
        all[n * side + m + cascade.half - modes.cascade.half] = *mode;
    }
    CascadeModes { cascade, foam_threshold: modes.foam_threshold, modes: all }
}

#[test]
fn pruned_and_full_transforms_give_the_same_field() {
    let timeline = Timeline::new(&wind_sea(14.0, 128, &[600.0, 80.0, 12.0]));
    let (hs, pruned) = (timeline.hs_at(DAY), timeline.at(DAY));
    let all = Sea { cascades: pruned.cascades.iter().map(unpruned).collect(), ..pruned.clone() };
    let plan = full(FieldSet::SPECTRAL, None, 1.0);
    for (a, b) in step(&pruned, DAY, plan.clone()).iter().zip(step(&all, DAY, plan)) {
        for field in Field::SPECTRAL {
            let (a, b) = (a.plane(field).unwrap(), b.plane(field).unwrap());
            let error = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
            assert!(error <= 1e-6 * hs, "{field:?} differs by {error} with Hs {hs}");
        }
    }
}

#[test]
fn a_level_is_the_sea_of_those_waves_that_its_grid_holds() {
    let timeline = Timeline::new(&wind_sea(12.0, 128, &[400.0]));
    let (tick, sea, hs) = (DAY, timeline.at(DAY), timeline.hs_at(DAY));
    let modes = &sea.cascades[0];
    let cascade = modes.cascade;
    assert_eq!(cascade.levels(), 5, "128, 64, 32, 16 and 8 samples a side");
    let levels = CascadePlan::new((0..5).map(|level| (level, FieldSet::SPECTRAL)), None, &Effects::default());
    let surface = &step(&sea, tick, levels)[0];
    for level in 0..5 {
        let (n, half) = cascade.level(level);
        assert_eq!((n, half), (128 >> level, cascade.half.min(n / 2 - 1)));
        let kept = |i: &usize| {
            let (column, row) = (i / modes.rows(), (i % modes.rows()).abs_diff(cascade.half));
            column <= half && row <= half
        };
        let mut coarse = cascade;
        (coarse.n, coarse.half) = (n, half);
        let kept = (0..modes.modes.len()).filter(kept).map(|i| modes.modes[i]).collect();
        let coarse = CascadeModes { cascade: coarse, foam_threshold: 0.0, modes: kept };
        let sea = Sea { cascades: vec![coarse], ..sea.clone() };
        let truth = reference::fields(&sea, 0, tick, &Field::SPECTRAL);
        for (field, truth) in Field::SPECTRAL.iter().zip(&truth) {
            let error = max_error(surface.plane_at(level, *field).unwrap(), truth);
            assert!(error < 1e-5 * hs.max(1.0), "{field:?} of level {level} errs {error}");
        }
    }
    // The usual band leaves room for half the grid: nothing is lost there.
    let (fine, coarse) = (surface.plane(Field::Height).unwrap(), surface.plane_at(1, Field::Height).unwrap());
    for (i, value) in coarse.iter().enumerate() {
        let error = (value - fine[i / 64 * 2 * 128 + i % 64 * 2]).abs();
        assert!(f64::from(error) < 1e-6 * hs, "half the grid differs by {error}");
    }
}

#[test]
fn foam_of_water_that_never_breaks_fades_without_a_transform() {
    let calm = FoamWork { breaks: false, ..FOAM };
    assert_eq!(full(FieldSet::NONE, Some(calm), 1.0).transforms(), 0);
    let mut sea = Timeline::new(&wind_sea(15.0, 64, &[200.0])).at(DAY);
    let mut foamed = |work: FoamWork| {
        let mut cpu = Cpu::new(Some(1));
        sea.cascades[0].foam_threshold = 0.8;
        cpu.load(&sea).unwrap();
        let step = |work| Plan { cascades: vec![full(FieldSet::NONE, Some(work), 1.0)] };
        cpu.step(DAY, &step(FoamWork { restart: true, ..FOAM })).unwrap();
        sea.cascades[0].foam_threshold = -1e6;
        assert!(!sea.cascades[0].breaks());
        cpu.load(&sea).unwrap();
        let surface = cpu.step(DAY + 720, &step(work)).unwrap();
        bits(&surface.cascades[0], 0, Field::Foam)
    };
    let (looked_for, left_out) = (foamed(FOAM), foamed(calm));
    assert!(looked_for.iter().any(|bits| *bits != 0), "the test must see foam");
    assert!(looked_for == left_out);
}
