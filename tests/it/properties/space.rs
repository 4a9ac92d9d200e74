//! The space of scene files that the properties range over: a line for every number and every choice of the form.
//!
//! A field that the form gains is one more line here.

use proptest::collection::vec;
use proptest::option::weighted;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use swellcast::scene::{
    DepthCorrection, DirectionMethod, DispersionLaw, Distribution, ReplayFile, SceneFile, Spreading, SpreadingForm,
    SwellModel, WindModel,
};

/// Parts that stand several times, at most so often.
const SWELLS: usize = 3;
const BINS: usize = 5;
const PATCHES: usize = 3;

/// Puts a number where it belongs.
type Set = Box<dyn Fn(&mut SceneFile, f64)>;

/// A number of the form: its bounds, and where it goes.
struct Number {
    low: f64,
    high: f64,
    set: Set,
}

/// A field with a few values, of which the first `good` are allowed.
struct Choice {
    good: usize,
    all: usize,
    set: fn(&mut SceneFile, usize),
}

fn number(low: f64, high: f64, set: impl Fn(&mut SceneFile, f64) + 'static) -> Number {
    Number { low, high, set: Box::new(set) }
}

/// A number of the wind, where there is wind.
fn of_wind(low: f64, high: f64, set: impl Fn(&mut f64, &mut [f64; 2], f64) + 'static) -> Number {
    number(low, high, move |file, v| {
        if let Some(wind) = &mut file.wind {
            set(&mut wind.speed_mps, &mut wind.range_mps, v);
        }
    })
}

/// Every spreading that a file gives.
fn spreadings(file: &mut SceneFile) -> impl Iterator<Item = &mut Spreading> {
    let of_wind = file.wind.iter_mut().filter_map(|wind| wind.spreading.as_mut());
    of_wind.chain(file.swell.iter_mut().map(|swell| &mut swell.spreading))
}

/// Numbers that must keep an order would hardly ever do so by themselves: within 0 to 1 they are shares of what is
/// allowed, anything else is taken as it is.
fn share(v: f64, low: f64, high: f64) -> f64 {
    if (0.0..=1.0).contains(&v) { low + v * (high - low) } else { v }
}

/// Sets frequency `i` of a record, 0.1 mHz to 100 Hz, evenly in factors; those after it follow by the half.
fn frequency(bins: &mut [Vec<f64>], i: usize, v: f64) {
    let low = if i > 0 { bins.get(i - 1).map_or(1e-4, |bin| bin[0] * 1.01 + f64::EPSILON) } else { 1e-4 };
    let after = bins.len().saturating_sub(i + 1) as i32;
    let high = 100.0 / 1.5_f64.powi(after);
    let first = if (0.0..=1.0).contains(&v) && low < high { low * (high / low).powf(v) } else { v };
    for (bin, step) in bins.iter_mut().skip(i).zip(0..) {
        bin[0] = first * 1.5_f64.powi(step);
    }
}

/// Sets side `i` of the patches: from what the one before allows at the shortest to three quarters of it, evenly in
/// factors; those after it follow by halves.
fn length(patches: &mut [f64], i: usize, shortest_share: f64, v: f64) {
    let before = if i > 0 { patches.get(i - 1).copied() } else { None };
    let (low, high) = before.map_or((0.1, 1e5), |before| ((before * shortest_share).max(0.1), before * 0.75));
    let first = if (0.0..=1.0).contains(&v) && low < high { low * (high / low).powf(v) } else { v };
    for (side, step) in patches.iter_mut().skip(i).zip(0..) {
        *side = first * 0.5_f64.powi(step);
    }
}

/// Every number of the form. Those of a part that a file lacks set nothing.
fn numbers() -> Vec<Number> {
    let mut all = vec![
        // A loop is a whole number of ticks.
        number(1.0, 21_600.0, |s, v| s.loop_s = Some(if v.abs() < 1e6 { (v * 7200.0).round() / 7200.0 } else { v })),
        number(1e-3, 1e4, |s, v| s.water.depth_m = Some(v)),
        number(0.1, 100.0, |s, v| s.water.gravity = v),
        number(0.0, 1.0, |s, v| s.water.surface_tension = v),
        number(100.0, 20_000.0, |s, v| s.water.density = v),
        number(0.0, 1.5, |s, v| s.amplitudes.sigma = v),
        of_wind(0.0, 100.0, |speed, range, v| {
            range[0] = v;
            if (0.0..=100.0).contains(&v) {
                (range[1], *speed) = (range[1].max(v), speed.max(v));
            }
        }),
        of_wind(0.0, 1.0, |speed, range, v| {
            range[1] = share(v, range[0].max(0.1), 100.0);
            *speed = speed.min(range[1]);
        }),
        of_wind(0.0, 1.0, |speed, range, v| *speed = share(v, range[0], range[1])),
        number(-3600.0, 3600.0, |s, v| s.wind.iter_mut().for_each(|w| w.direction_from_deg = v)),
        number(0.0, 1e7, |s, v| s.wind.iter_mut().for_each(|w| w.fetch_m = v)),
        number(1.0, 20.0, |s, v| s.wind.iter_mut().for_each(|w| w.gamma = v)),
        number(0.0, 1.0, |s, v| s.wind.iter_mut().for_each(|w| w.swell = v)),
        number(0.0, 1.0, |s, v| s.wind.iter_mut().for_each(|w| w.alpha = v)),
        number(0.0, 1e4, |s, v| s.wind.iter_mut().for_each(|w| w.small_wave_m = v)),
        number(0.0, 30.0, |s, v| s.wind.iter_mut().take(1).for_each(|w| w.hs_m = w.hs_m.map(|_| v))),
        number(0.0, 1000.0, |s, v| spreadings(s).for_each(|spread| spread.s = v)),
        number(0.0, 1.0, |s, v| spreadings(s).for_each(|spread| spread.against_wind = v)),
        number(0.0, 1.0, |s, v| spreadings(s).for_each(|spread| spread.blend = v)),
        number(0.1, 1.0, |s, v| s.cascades.band_limit = v),
        number(1e-3, 1e4, |s, v| s.cascades.finest_wavelength_m = v),
        number(0.0, 5.0, |s, v| s.effects.choppiness = v),
        number(0.0, 1.0, |s, v| s.effects.foam_growth_s = v),
        number(0.1, 3.0, |s, v| s.effects.foam_decay_s = v),
        number(0.0, 10.0, |s, v| s.effects.foam_gain = v),
    ];
    for i in 0..SWELLS {
        all.push(number(0.0, 30.0, move |s, v| s.swell.iter_mut().skip(i).take(1).for_each(|w| w.hs_m = v)));
        all.push(number(0.5, 30.0, move |s, v| s.swell.iter_mut().skip(i).take(1).for_each(|w| w.tp_s = v)));
        all.push(number(-3600.0, 3600.0, move |s, v| {
            s.swell.iter_mut().skip(i).take(1).for_each(|w| w.direction_from_deg = v);
        }));
        all.push(number(1.0, 20.0, move |s, v| s.swell.iter_mut().skip(i).take(1).for_each(|w| w.gamma = v)));
        all.push(number(0.5, 20.0, move |s, v| s.swell.iter_mut().skip(i).take(1).for_each(|w| w.lambda = v)));
        all.push(number(0.0, 1.0, move |s, v| s.swell.iter_mut().skip(i).take(1).for_each(|w| w.swell = v)));
    }
    for i in 0..BINS {
        all.push(number(0.0, 1.0, move |s, v| s.measured.iter_mut().for_each(|m| frequency(&mut m.bins, i, v))));
        let bounds = [(0.0, 1e5), (-360.0, 360.0), (-360.0, 360.0), (0.0, 1.0), (0.0, 1.0)];
        for (column, (low, high)) in (1..).zip(bounds) {
            all.push(number(low, high, move |s, v| {
                let bins = s.measured.iter_mut().flat_map(|m| m.bins.get_mut(i));
                bins.flat_map(|bin| bin.get_mut(column)).for_each(|number| *number = v);
            }));
        }
    }
    for i in 0..PATCHES {
        all.push(number(0.0, 1.0, move |s, v| {
            let shortest_share = 2.0 / (s.cascades.band_limit * s.cascades.n.unwrap_or(256) as f64);
            length(&mut s.cascades.patches_m, i, shortest_share, v);
        }));
    }
    all
}

/// Every field with a few values. The first value is the one that a failing case is brought down to.
fn choices() -> Vec<Choice> {
    fn parts(file: &mut SceneFile, swells: usize) {
        file.swell = vec![Default::default(); swells];
    }
    vec![
        Choice { good: 3, all: 3, set: |s, i| s.wind = (i > 0).then(Default::default) },
        Choice { good: 2 * SWELLS, all: 2 * SWELLS + 1, set: |s, i| parts(s, [0, 0, 0, 1, 2, 3, 17][i]) },
        Choice { good: 6, all: 10, set: measured },
        Choice {
            good: 8,
            all: 13,
            set: |s, i| {
                s.cascades.n = Some([16, 16, 16, 16, 16, 16, 32, 64, 0, 8, 48, 4096, usize::MAX][i]);
            },
        },
        Choice {
            good: 6,
            all: 7,
            set: |s, i| {
                s.cascades.patches_m = (0..[0, 0, 0, 1, 2, 3, 9][i]).map(|i| 1000.0 * 0.5_f64.powi(i)).collect()
            },
        },
        // Calibrating foam costs more than all the rest: few scenes foam.
        Choice { good: 24, all: 24, set: |s, i| s.effects.foam = i == 23 },
        Choice { good: 5, all: 5, set: |s, i| s.wind.iter_mut().for_each(|w| w.model = WindModel::ALL[i]) },
        Choice { good: 3, all: 3, set: |s, i| s.wind.iter_mut().for_each(|w| w.depth_correction = CORRECTIONS[i]) },
        Choice { good: 2, all: 2, set: |s, i| s.wind.iter_mut().for_each(|w| w.hs_m = (i > 0).then_some(1.0)) },
        Choice {
            good: 7,
            all: 7,
            set: |s, i| {
                let form = SpreadingForm::ALL.get(i.wrapping_sub(1));
                let spreading = form.map(|form| Spreading {
                    form: *form,
                    with: SpreadingForm::ALL[5 - i / 2],
                    ..Spreading::default()
                });
                s.wind.iter_mut().for_each(|w| w.spreading = spreading);
                s.swell.iter_mut().for_each(|w| w.spreading = spreading.unwrap_or(w.spreading));
            },
        },
        Choice { good: 2, all: 2, set: |s, i| s.swell.iter_mut().for_each(|w| w.model = SWELL_MODELS[i]) },
        Choice { good: 3, all: 3, set: |s, i| s.water.dispersion = DISPERSIONS[i] },
        Choice { good: 2, all: 2, set: |s, i| s.amplitudes.distribution = DISTRIBUTIONS[i] },
        Choice { good: 2, all: 2, set: |s, i| s.measured.iter_mut().for_each(|m| m.directions = METHODS[i]) },
        Choice { good: 2, all: 3, set: |s, i| s.measured.iter_mut().for_each(|m| m.replay = replay(&m.bins, i)) },
        Choice { good: 2, all: 4, set: |s, i| s.name = ["sea", "a-0", "", "Not Plain"][i].to_owned() },
        Choice { good: 2, all: 3, set: |s, i| s.title = "é".repeat([0, 128, 129][i]) },
        Choice { good: 5, all: 5, set: |s, i| s.seed = [1, 0, 2, u64::MAX, 1 << 63][i] },
    ]
}

const CORRECTIONS: [DepthCorrection; 3] =
    [DepthCorrection::Kitaigorodskii, DepthCorrection::None, DepthCorrection::ThompsonVincent];
const SWELL_MODELS: [SwellModel; 2] = [SwellModel::Jonswap, SwellModel::OchiHubble];
const DISPERSIONS: [DispersionLaw; 3] = [DispersionLaw::Capillary, DispersionLaw::Finite, DispersionLaw::Deep];
const DISTRIBUTIONS: [Distribution; 2] = [Distribution::Gaussian, Distribution::LogNormal];
const METHODS: [DirectionMethod; 2] = [DirectionMethod::MaximumEntropy, DirectionMethod::Fourier];

/// No replay, one of the record's own numbers where it has some, and one of none.
fn replay(bins: &[Vec<f64>], i: usize) -> Option<ReplayFile> {
    let of = |records| Some(ReplayFile { records, record_s: 20.0, transition_s: 5.0, ..ReplayFile::default() });
    match i {
        1 if !bins.is_empty() => of(vec![bins.to_vec(); 2]),
        2 => of(Vec::new()),
        _ => None,
    }
}

/// None, the built-in record, rows with and without directions; then none and both at once, a single row, and rows
/// of a length that is none.
fn measured(file: &mut SceneFile, i: usize) {
    let row = |i: usize| vec![0.05 * (i + 1) as f64, 1.0, 200.0, 190.0, 0.8, 0.6];
    let rows = |count: usize| (0..count).map(row).collect::<Vec<_>>();
    let record = file.measured.insert(Default::default());
    match i {
        0 | 1 => file.measured = None,
        2 => record.station = Some("41010".to_owned()),
        3 => record.bins = rows(2),
        4 => record.bins = rows(BINS),
        5 => record.bins = (0..BINS).map(|i| row(i)[..if i % 2 == 0 { 2 } else { 6 }].to_vec()).collect(),
        6 => {}
        7 => (record.station, record.bins) = (Some("41010".to_owned()), rows(2)),
        8 => record.bins = rows(1),
        _ => record.bins = vec![row(0), row(1)[..3].to_vec()],
    }
}

/// A value within the bounds: evenly, evenly in factors, or a bound.
fn inside(low: f64, high: f64) -> BoxedStrategy<f64> {
    let least = low.max(1e-9 * high);
    prop_oneof![
        4 => low..=high,
        3 => (0.0..=1.0).prop_map(move |t: f64| (least * (high / least).powf(t)).clamp(low, high)),
        1 => Just(low),
        1 => Just(high),
        1 => Just(if low == 0.0 { -0.0 } else { low }),
    ]
    .boxed()
}

/// A value that is likely to be refused: just outside, not finite, huge, tiny, or of the other sign.
fn outside(low: f64, high: f64) -> BoxedStrategy<f64> {
    let values = [
        low.next_down(),
        high.next_up(),
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        -0.0,
        5e-324,
        -5e-324,
        f64::MIN_POSITIVE,
        f64::MAX,
        f64::MIN,
        1e300,
        low - 1.0,
        2.0 * high,
        -high,
        f64::EPSILON,
    ];
    select(values.to_vec()).boxed()
}

/// What is drawn of a file: `None` leaves the default.
type Drawn = (Vec<Option<f64>>, Vec<Index>);

fn drawn(wild: bool) -> impl Strategy<Value = (Drawn, bool)> {
    let each = move |n: &Number| {
        let (low, high) = (n.low, n.high);
        let value = prop_oneof![if wild { 24 } else { 1 } => inside(low, high), u32::from(wild) => outside(low, high)];
        weighted(0.7, value)
    };
    let numbers: Vec<_> = numbers().iter().map(each).collect();
    (numbers, vec(any::<Index>(), choices().len())).prop_map(move |drawn| (drawn, wild))
}

/// Scene files: half of them with every number within its bounds, so that the other half's refusals hide nothing.
pub fn scene_files() -> impl Strategy<Value = SceneFile> {
    prop_oneof![drawn(false), drawn(true)].prop_map(|((values, picks), wild)| {
        let mut file = SceneFile::default();
        for (choice, pick) in choices().iter().zip(picks) {
            let i = pick.index(if wild { 32 * choice.good } else { choice.good });
            // A wild choice is a bad one now and then.
            let i = if i < choice.all { i } else { i % choice.good };
            (choice.set)(&mut file, i);
        }
        for (number, value) in numbers().iter().zip(values) {
            if let Some(value) = value {
                (number.set)(&mut file, value);
            }
        }
        file
    })
}
