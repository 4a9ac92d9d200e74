//! The ways of normals: each is what its formula says, in f64 and by other means than the backend's; and each errs as
//! theory says, against the exact normal of the whole sea.

use swellcast::backend::{Backend, Cpu};
use swellcast::plan::{CascadePlan, Field, FieldSet, Plan, fields_of};
use swellcast::reference;
use swellcast::scene::{Effects, Normals};
use swellcast::sea::{Sea, Timeline};
use swellcast::wire::Group;

use crate::random::Random;
use crate::support::{DAY, scene};

const WAYS: [Normals; 5] =
    [Normals::Exact, Normals::Diagonal, Normals::DisplacedSlopes, Normals::CentralDifference, Normals::Sobel];
const SLOPES: [Field; 2] = [Field::NormalX, Field::NormalZ];
/// Fields of the reference, in this order.
const POINTS: [Field; 3] = [Field::Dx, Field::Height, Field::Dz];
const SOURCES: [Field; 5] = [Field::SlopeX, Field::SlopeZ, Field::Dxx, Field::Dzz, Field::Dxz];
/// A mapping that squeezes to less counts as this.
const LEAST_JACOBIAN: f64 = 0.1;

type Vector = [f64; 3];

fn sea(n: usize, band_limit: f64, patches_m: &[f64], choppiness: f64) -> Sea {
    let text = format!(
        "name = \"normals\"\n[wind]\nspeed_mps = 15\nfetch_m = 200e3\ndirection_from_deg = 240\n\
         [cascades]\nn = {n}\nband_limit = {band_limit}\npatches_m = {patches_m:?}\n\
         [effects]\nchoppiness = {choppiness:?}\nfoam = false\n"
    );
    Timeline::new(&scene(&text)).at(DAY)
}

/// Fields of every cascade by the CPU backend at one level.
fn made(sea: &Sea, way: Normals, level: u8, fields: &[Field]) -> Vec<Vec<Vec<f32>>> {
    let mut cpu = Cpu::new(Some(2));
    cpu.load(sea).unwrap();
    let effects = Effects { choppiness: sea.choppiness, normals: way, ..Effects::default() };
    let cascade = CascadePlan::new([(level, FieldSet::of(fields))], None, &effects);
    let surface = cpu.step(DAY, &Plan { cascades: vec![cascade; sea.cascades.len()] }).unwrap();
    let plane = |field: &Field, cascade: usize| surface.cascades[cascade].plane_at(level, *field).unwrap().to_vec();
    (0..sea.cascades.len()).map(|cascade| fields.iter().map(|field| plane(field, cascade)).collect()).collect()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The normal across two tangents of the surface, as long as its Jacobian is high.
fn normal(hx: f64, hz: f64, dxx: f64, dzz: f64, dxz: f64) -> Vector {
    cross([dxz, hz, 1.0 + dzz], [1.0 + dxx, hx, dxz])
}

/// Angle between two directions, degrees.
fn angle(a: Vector, b: Vector) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    cross(a, b).iter().map(|v| v * v).sum::<f64>().sqrt().atan2(dot).to_degrees()
}

/// Weights of a way's nine neighbours for a derivative along the second index.
fn kernel(way: Normals) -> [[f64; 3]; 3] {
    match way {
        Normals::Sobel => [[-1.0, 0.0, 1.0], [-2.0, 0.0, 2.0], [-1.0, 0.0, 1.0]].map(|line| line.map(|w| w / 8.0)),
        _ => [[0.0; 3], [-0.5, 0.0, 0.5], [0.0; 3]],
    }
}

/// Slopes at sample `i` by a way, in f64: out of tangents, the Jacobian at least a tenth. And that Jacobian.
fn slopes(way: Normals, n: usize, spacing: f64, fields: &[Vec<f64>], i: usize) -> ([f64; 2], f64) {
    let at = |field: usize| fields[field][i];
    let [hx, hz, dxx, dzz, dxz] = [3, 4, 5, 6, 7].map(at);
    let normal = match way {
        Normals::Diagonal => {
            let [x, z] = [1.0 + dxx, 1.0 + dzz].map(|stretch| stretch.max(LEAST_JACOBIAN));
            return ([hx / x, hz / z], x.min(z));
        }
        Normals::CentralDifference | Normals::Sobel => {
            let (mut along_x, mut along_z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
            let weights = kernel(way);
            for (down, line) in weights.iter().enumerate() {
                for (across, weight) in line.iter().enumerate() {
                    let sample = |x: usize, z: usize| (i / n + n + z - 1) % n * n + (i % n + n + x - 1) % n;
                    for axis in 0..3 {
                        along_x[axis] += weight / spacing * fields[axis][sample(across, down)];
                        along_z[axis] += weight / spacing * fields[axis][sample(down, across)];
                    }
                }
            }
            cross(along_z, along_x)
        }
        _ => normal(hx, hz, dxx, dzz, dxz),
    };
    let jacobian = normal[1].max(LEAST_JACOBIAN);
    ([-normal[0] / jacobian, -normal[2] / jacobian], normal[1])
}

#[test]
fn each_way_is_what_its_formula_says() {
    for (choppiness, folds) in [(1.0, false), (5.0, true)] {
        let full = sea(64, 1.0 / 3.0, &[900.0, 130.0, 20.0], choppiness);
        for level in [0, 1] {
            // A level of detail is a coarser grid of the same waves.
            let mut coarse = full.clone();
            coarse.cascades.iter_mut().for_each(|cascade| cascade.cascade.n >>= level);
            let fields: Vec<Vec<Vec<f64>>> = (0..full.cascades.len())
                .map(|cascade| reference::fields(&coarse, cascade, DAY, &[&POINTS[..], &SOURCES].concat()))
                .collect();
            for way in WAYS {
                let (mut clamped, mut worst) = (0, 0.0_f64);
                let fast = made(&full, way, level, &SLOPES);
                for ((cascade, fields), fast) in coarse.cascades.iter().zip(&fields).zip(&fast) {
                    let n = cascade.cascade.n;
                    let spacing = cascade.cascade.patch_m / n as f64;
                    for i in 0..n * n {
                        let (want, jacobian) = slopes(way, n, spacing, fields, i);
                        clamped += usize::from(jacobian <= LEAST_JACOBIAN);
                        // Where the mapping squeezes, rounding of the fields grows as much as the slopes do.
                        let squeezed = jacobian.max(LEAST_JACOBIAN);
                        for (fast, want) in fast.iter().zip(want) {
                            let error = (f64::from(fast[i]) - want).abs() / (1.0 + want.abs()) * squeezed;
                            worst = worst.max(error);
                        }
                    }
                }
                println!("{way:?}, choppiness {choppiness}, level {level}: {worst:.1e}, {clamped} clamped");
                assert!(worst < 1e-6, "{way:?} at level {level} errs {worst:e} at choppiness {choppiness}");
                assert_eq!(clamped > 0, folds, "{clamped} samples of {way:?} fold at choppiness {choppiness}");
            }
        }
    }
}

#[test]
fn the_eigenvalue_is_the_smaller_of_two_whose_product_is_the_jacobian() {
    let mut sea = sea(64, 1.0 / 3.0, &[900.0, 130.0, 20.0], 5.0);
    // Waves so high that they fold along both axes, too.
    for mode in sea.cascades.iter_mut().flat_map(|cascade| &mut cascade.modes) {
        (mode.forward, mode.backward) = (3.0 * mode.forward, 3.0 * mode.backward);
    }
    let fast = made(&sea, Normals::None, 0, &[Field::Eigenvalue, Field::Jacobian]);
    let (mut folded, mut twice) = (0, 0);
    for (cascade, fast) in fast.iter().enumerate() {
        let slow = reference::fields(&sea, cascade, DAY, &SOURCES[2..]);
        let jacobian = reference::jacobian(&slow[0], &slow[1], &slow[2]);
        for i in 0..jacobian.len() {
            let trace = 2.0 + slow[0][i] + slow[1][i];
            let eigenvalue = 0.5 * (trace - (trace * trace - 4.0 * jacobian[i]).max(0.0).sqrt());
            let [got, product] = [0, 1].map(|plane| f64::from(fast[plane][i]));
            assert!((got - eigenvalue).abs() < 1e-5, "cascade {cascade}: {got} for {eigenvalue}");
            assert!((product - jacobian[i]).abs() < 1e-5, "cascade {cascade}: {product} for {}", jacobian[i]);
            assert!((got * (trace - got) - product).abs() < 2e-5 && got <= trace - got + 1e-5);
            // Folded once the Jacobian is negative; folded along both axes it is positive again, and only the
            // eigenvalue tells.
            folded += usize::from(jacobian[i] < -1e-5);
            twice += usize::from(jacobian[i] > 1e-5 && got < 0.0);
            assert!(product > -1e-5 || got < 0.0, "a Jacobian of {product} with an eigenvalue of {got}");
        }
    }
    println!("{folded} samples fold along one axis, {twice} along both");
    assert!(folded > 100 && twice > 10, "only {folded} and {twice} samples fold");
}

/// Angle errors of a way, degrees rms, over meetings of samples of a sea's cascades: all samples of one alone; random
/// ones of several, whose patches have no common measure, so that all meetings are equally frequent.
fn errors(sea: &Sea) -> [f64; 6] {
    let (n, cascades) = (sea.cascades[0].cascade.n, sea.cascades.len());
    let mut random = Random(9);
    let meetings: Vec<Vec<usize>> = (0..n * n)
        .map(|i| (0..cascades).map(|_| if cascades == 1 { i } else { random.below(n * n) }).collect())
        .collect();
    let slow: Vec<_> = (0..cascades).map(|cascade| reference::fields(sea, cascade, DAY, &SOURCES)).collect();
    let of = |fields: [f64; 5]| normal(fields[0], fields[1], fields[2], fields[3], fields[4]);
    let exact = |meeting: &[usize]| {
        of(std::array::from_fn(|field| meeting.iter().zip(&slow).map(|(i, slow)| slow[field][*i]).sum()))
    };
    let rms = |own: &dyn Fn(&[usize]) -> Vector| {
        let square = |meeting: &Vec<usize>| angle(exact(meeting), own(meeting)).powi(2);
        (meetings.iter().map(square).sum::<f64>() / meetings.len() as f64).sqrt()
    };
    let averaged = |meeting: &[usize]| {
        let own = |(i, slow): (&usize, &Vec<Vec<f64>>)| of(std::array::from_fn(|field| slow[field][*i]));
        let unit = |v: Vector| v.map(|c| c / v.iter().map(|c| c * c).sum::<f64>().sqrt());
        meeting.iter().zip(&slow).map(own).map(unit).fold([0.0; 3], |a, b| std::array::from_fn(|i| a[i] + b[i]))
    };
    let [exact_way, diagonal, displaced, central, sobel] = WAYS.map(|way| {
        let fields: &[Field] = match way {
            Normals::Exact => &SOURCES,
            Normals::Diagonal => &SOURCES[..4],
            _ => &SLOPES,
        };
        let fast = made(sea, way, 0, fields);
        rms(&|meeting| {
            let sum = |field: usize| meeting.iter().zip(&fast).map(|(i, fast)| f64::from(fast[field][*i])).sum::<f64>();
            match way {
                Normals::Exact => of(std::array::from_fn(sum)),
                Normals::Diagonal => [-sum(0) / (1.0 + sum(2)), 1.0, -sum(1) / (1.0 + sum(3))],
                _ => [-sum(0), 1.0, -sum(1)],
            }
        })
    });
    [exact_way, diagonal, displaced, central, sobel, rms(&averaged)]
}

#[test]
fn on_one_cascade_differences_err_with_the_square_of_the_spacing() {
    let grids = [64, 128, 256];
    let errors = grids.map(|n| errors(&sea(n, 32.0 / n as f64, &[130.0], 1.0)));
    let slope = |way: usize| (errors[2][way] / errors[0][way]).ln() / f64::from(grids[2] as u32 / grids[0] as u32).ln();
    for (n, [exact, diagonal, displaced, central, sobel, _]) in grids.into_iter().zip(errors) {
        println!("{n}: diagonal {diagonal:.4}, central difference {central:.4}, Sobel {sobel:.4} degrees");
        assert!(exact < 1e-3 && displaced < 1e-3, "at {n}: exact {exact}, displaced slopes {displaced} degrees");
        assert!(sobel > 1.2 * central, "at {n}: Sobel {sobel}, central difference {central} degrees");
        assert!((diagonal / errors[0][1] - 1.0).abs() < 0.02, "the diagonal form errs {diagonal} degrees at {n}");
    }
    let (central, sobel) = (slope(3), slope(4));
    println!("central difference falls with the spacing to the {:.2}, Sobel to the {:.2}", -central, -sobel);
    assert!((central + 2.0).abs() < 0.3 && (sobel + 2.0).abs() < 0.3, "to the {central} and {sobel}");
}

#[test]
fn on_several_cascades_only_sums_of_what_adds_are_exact() {
    let [exact, diagonal, displaced, central, sobel, averaged] =
        errors(&sea(128, 1.0 / 3.0, &[1000.0, 149.3, 21.7], 1.0));
    println!(
        "exact {exact:.5}, diagonal {diagonal:.2}, displaced slopes {displaced:.2}, central difference {central:.2}, \
         Sobel {sobel:.2}, averaged unit normals {averaged:.2} degrees"
    );
    assert!(exact < 1e-3, "exact errs {exact} degrees");
    assert!(0.1 < diagonal && 1.2 * diagonal < displaced, "diagonal {diagonal}, displaced slopes {displaced}");
    assert!(displaced < central && central < sobel && sobel < 1.5, "{displaced}, {central}, {sobel}");
    assert!(averaged > 4.0 * displaced, "averaged {averaged}, displaced slopes {displaced}");
}

#[test]
fn a_way_streams_the_channels_it_needs() {
    let has = |way: Normals, group: Group| Effects { normals: way, ..Effects::default() }.has(group);
    for way in WAYS {
        let groups: Vec<Group> = match way {
            Normals::Exact => vec![Group::Slopes, Group::Derivatives],
            Normals::Diagonal => vec![Group::Slopes, Group::Stretch],
            _ => vec![Group::Normals],
        };
        assert!(groups.iter().all(|group| has(way, *group)), "{way:?} lacks one of {groups:?}");
        let channels: usize = groups.iter().map(|group| fields_of(*group).len()).sum();
        assert_eq!(channels, [5, 4, 2, 2, 2][WAYS.iter().position(|w| *w == way).unwrap()]);
    }
}
