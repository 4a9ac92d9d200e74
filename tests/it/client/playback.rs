//! Laws of playback: what is interpolated, what is held, and what is never kept.

use swellcast::client::{Footing, MAX_SAMPLES, Playback, RING, TileKey};
use swellcast::tile::DecodedFrame;
use swellcast::wire::{Codec, ErrorClass, Group, Hello, ServerMessage, UnitName};

use crate::random::Random;
use crate::vectors::{from_server, samples};

/// The hello of the vectors, and a playback of foam at 8 samples a side.
fn hello() -> Hello {
    let Some((_, ServerMessage::Hello(hello))) = from_server().into_iter().next() else { panic!("no hello") };
    *hello
}

fn unit(cascade: u8, level: u8, group: Group) -> UnitName {
    UnitName { cascade, level, class: ErrorClass::Millimetre, group, codec: Codec::I16 }
}

fn playback() -> Playback {
    Playback::new(&hello(), &[unit(0, 5, Group::Foam)])
}

/// A frame of foam whose samples are `value` and its double, alternating.
fn frame(tick: u64, value: f64) -> DecodedFrame {
    let sample = samples().into_iter().find(|s| s.name == "foam-8").unwrap();
    let mut header = sample.header;
    header.tick = tick;
    DecodedFrame { header, planes: vec![(0..64).map(|i| (value * f64::from(1 + i % 2)) as f32).collect()] }
}

const KEY: TileKey = TileKey { cascade: 0, group: 3, x: 0, z: 0 };

fn at(playback: &Playback, tick: f64) -> Option<(f64, Footing)> {
    let mut out = Vec::new();
    let footing = playback.sample(KEY, 0, (tick * 1e6 / 7200.0).round() as i64, &mut out)?;
    assert_eq!(out.len(), 64);
    assert!((f64::from(out[1]) - 2.0 * f64::from(out[0])).abs() < 1e-4 * (1.0 + f64::from(out[1]).abs()));
    Some((f64::from(out[0]), footing))
}

#[test]
fn a_cubic_is_interpolated_exactly() {
    let cubic = |tick: f64| {
        let t = tick / 450.0 - 4.0;
        0.3 * t * t * t - 0.7 * t * t + 1.1 * t - 0.2
    };
    // On the grid, and where the server had to skip frames.
    for ticks in [vec![450, 900, 1350, 1800, 2250, 2700], vec![450, 900, 1800, 3150]] {
        let mut playback = playback();
        ticks.iter().for_each(|t| playback.insert(frame(*t, cubic(*t as f64))).unwrap());
        for tick in (ticks[1]..ticks[ticks.len() - 2]).step_by(18) {
            // Every ninth tick is a whole number of microseconds.
            let (value, footing) = at(&playback, tick as f64).unwrap();
            assert!((value - cubic(tick as f64)).abs() < 2e-5, "{value} at {tick}");
            assert_eq!(footing, Footing::Between);
        }
    }
}

#[test]
fn cubic_at_15_hz_beats_a_line_at_30_hz() {
    // A wave of two seconds and one metre.
    let wave = |tick: f64| (tick / 7200.0 * std::f64::consts::PI).sin();
    let mut playback = playback();
    (0..12).for_each(|i| playback.insert(frame(i * 480, wave(i as f64 * 480.0))).unwrap());
    let (mut cubic, mut line) = (0f64, 0f64);
    for tick in (960..4000).map(f64::from) {
        cubic = cubic.max((at(&playback, tick).unwrap().0 - wave(tick)).abs());
        let (before, part) = ((tick / 240.0).floor() * 240.0, (tick / 240.0).fract());
        line = line.max((wave(before) * (1.0 - part) + wave(before + 240.0) * part - wave(tick)).abs());
    }
    assert!(cubic < 1e-4 && line > 1e-3, "cubic {cubic}, line {line}");
}

#[test]
fn order_and_doubles_do_not_matter() {
    let value = |tick: u64| (tick as f64 / 900.0).sin();
    let mut random = Random(1);
    let mut tidy = playback();
    (0..RING as u64).for_each(|i| tidy.insert(frame(i * 240, value(i * 240))).unwrap());
    for _ in 0..20 {
        let mut order: Vec<u64> = (0..RING as u64).chain(0..5).map(|i| i * 240).collect();
        (0..order.len()).for_each(|i| order.swap(i, random.below(i + 1)));
        let mut shuffled = playback();
        order.into_iter().for_each(|tick| shuffled.insert(frame(tick, value(tick))).unwrap());
        (0..3600).step_by(77).for_each(|t| assert_eq!(at(&tidy, f64::from(t)), at(&shuffled, f64::from(t))));
    }
}

#[test]
fn the_nearest_frame_is_held_beyond_the_ends() {
    let mut playback = playback();
    assert_eq!(at(&playback, 0.0), None);
    playback.insert(frame(7200, 0.25)).unwrap();
    assert_eq!(at(&playback, 7200.0), Some((0.25, Footing::Between)), "on the frame");
    assert_eq!(at(&playback, 9000.0), Some((0.25, Footing::Starved)));
    assert_eq!(at(&playback, -9000.0), Some((0.25, Footing::Starved)));
    playback.insert(frame(7650, 0.75)).unwrap();
    assert_eq!(at(&playback, 7425.0), Some((0.5, Footing::Between)), "two frames make a line");
    assert_eq!(at(&playback, 7651.0), Some((0.75, Footing::Starved)));
    assert_eq!(at(&playback, 7199.0), Some((0.25, Footing::Starved)));
}

#[test]
fn the_last_tick_is_as_good_as_any() {
    let last = swellcast::wire::MAX_TICK as u64;
    let mut playback = playback();
    playback.insert(frame(last, 0.5)).unwrap();
    playback.insert(frame(0, 0.25)).unwrap();
    for us in [i64::MIN, -1, 0, 1, i64::MAX] {
        let mut out = Vec::new();
        assert!(playback.sample(KEY, 0, us, &mut out).is_some() && out[0].is_finite(), "{us}: {out:?}");
        playback.forget_before(us);
        assert!(playback.ticks(KEY).count() > 0, "the last frame is never forgotten");
    }
}

#[test]
fn a_ring_holds_the_newest_frames_and_forgets_the_past() {
    let mut playback = playback();
    (0..1000).for_each(|i| playback.insert(frame(i * 120, 0.5)).unwrap());
    assert_eq!(playback.ticks(KEY).count(), RING);
    assert_eq!(playback.ticks(KEY).last(), Some(999 * 120));
    playback.insert(frame(0, 0.5)).unwrap();
    assert_ne!(playback.ticks(KEY).next(), Some(0), "an old frame doesn't push out a newer one");
    playback.forget_before((995 * 120 + 60) * 1_000_000 / 7200);
    assert_eq!(playback.ticks(KEY).collect::<Vec<_>>(), [994, 995, 996, 997, 998, 999].map(|i| i * 120));
}

#[test]
fn a_cascade_counts_at_its_ticks_alone() {
    let mut changing = hello();
    (changing.layout.cascades[0].from_tick, changing.layout.cascades[0].until_tick) = (7200, Some(14_400));
    let mut playback = Playback::new(&changing, &[unit(0, 5, Group::Foam)]);
    [7200, 7680, 12_480, 12_960].into_iter().for_each(|tick| playback.insert(frame(tick, 0.5)).unwrap());
    assert_eq!(at(&playback, 7199.0), None, "it has not begun");
    assert_eq!(at(&playback, 7200.0), Some((0.5, Footing::Between)));
    // Three frames of 15 Hz before its end it is nothing: only after a frame of those there is nothing to wait for.
    assert_eq!(at(&playback, 13_000.0).unwrap().1, Footing::Between, "at rest");
    assert_eq!(at(&playback, 14_399.0).unwrap().1, Footing::Between);
    assert_eq!(at(&playback, 14_400.0), None, "it has ended");
    playback.forget_before(2_000_000);
    assert_eq!(playback.keys().count(), 0, "what ended is let go of");
    let mut lacking = Playback::new(&changing, &[unit(0, 5, Group::Foam)]);
    lacking.insert(frame(12_480, 0.5)).unwrap();
    assert_eq!(at(&lacking, 13_000.0).unwrap().1, Footing::Starved, "the frames at rest did not come");
}

#[test]
fn a_further_hello_keeps_what_goes_on() {
    let mut before = Playback::new(&hello(), &[unit(0, 5, Group::Foam)]);
    before.insert(frame(7200, 0.5)).unwrap();
    let mut ending = hello();
    ending.layout.cascades[0].until_tick = Some(72_000);
    let after = before.renewed(&ending, &[unit(0, 5, Group::Foam), unit(1, 5, Group::Foam)]);
    assert_eq!(at(&after, 7200.0), Some((0.5, Footing::Between)));
    // Another level, another cascade of that number, another sea: nothing of those is held.
    let kept = |hello: &Hello, level| {
        let mut before = Playback::new(&ending, &[unit(0, 5, Group::Foam)]);
        before.insert(frame(7200, 0.5)).unwrap();
        before.renewed(hello, &[unit(0, level, Group::Foam)]).keys().count()
    };
    let mut other = ending.clone();
    assert_eq!((kept(&other, 5), kept(&other, 4)), (1, 0));
    other.layout.cascades[0].from_tick = 1;
    assert_eq!(kept(&other, 5), 0);
    other = Hello { epoch: "0123456789abcdee".to_owned(), ..ending.clone() };
    assert_eq!(kept(&other, 5), 0);
}

#[test]
fn strays_are_refused() {
    let mut ending = hello();
    ending.layout.cascades[0].until_tick = Some(70_000);
    let mut playback = Playback::new(&ending, &[unit(0, 5, Group::Foam)]);
    let stray = |change: &dyn Fn(&mut DecodedFrame)| {
        let mut tile = frame(7200, 0.5);
        change(&mut tile);
        tile
    };
    for tile in [
        stray(&|t| t.header.epoch += 1),
        stray(&|t| t.header.tick = 70_000),
        stray(&|t| t.header.cascade = 1),
        stray(&|t| t.header.group = 0),
        stray(&|t| t.header.level_n = 16),
        stray(&|t| (t.header.n, t.header.level_n) = (16, 16)),
    ] {
        assert!(playback.insert(tile).is_err());
    }
    assert_eq!(playback.keys().count(), 0);
}

#[test]
fn no_hello_makes_a_playback_large() {
    let mut huge = hello();
    huge.layout.cascades = vec![huge.layout.cascades[0].clone(); 200];
    huge.layout
        .cascades
        .iter_mut()
        .enumerate()
        .for_each(|(i, c)| (c.index, c.n) = (i as u8, [u32::MAX, 65_280, 0, 1024][i % 4]));
    let units: Vec<UnitName> =
        (0..=255).flat_map(|cascade| Group::ALL.map(|group| unit(cascade, cascade % 40, group))).collect();
    let mut playback = Playback::new(&huge, &units);
    let sample = samples().into_iter().find(|s| s.name == "tile-256").unwrap();
    let mut held = 0;
    for cascade in 0..=255 {
        for tile in 0..16 {
            let mut header = sample.header;
            (header.cascade, header.level_n, header.tile_x, header.tile_z) = (cascade, 1024, tile % 4, tile / 4);
            held += usize::from(playback.insert(DecodedFrame { header, planes: vec![] }).is_ok());
        }
    }
    assert!(held as u64 * 65_536 <= MAX_SAMPLES, "{held} tiles");
}
