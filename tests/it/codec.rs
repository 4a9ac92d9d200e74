//! The codec: what is decoded is what was counted, whoever joined when and left what out, and its error is the one that
//! stands in the frame.

use proptest::prelude::*;
use swellcast::tile::{DecodeError, DecodedFrame, Decoder, Plane, SentFrame, Stamp, UnitEncoder, decode};
use swellcast::wire::{BETWEEN, Codec, ErrorClass, FLAG_SATURATED, Group, HEADER_BYTES, UnitName, layer_of, split};

const N: usize = 64;

fn unit(codec: Codec, class: ErrorClass) -> UnitName {
    UnitName { cascade: 0, level: 0, class, group: Group::Slopes, codec }
}

/// A sea of a few waves with its own clock, and what disturbs it.
#[derive(Clone, Debug)]
struct Waves {
    waves: Vec<(i32, i32, f32, f32)>,
    jump: Option<(i64, f32)>,
}

impl Waves {
    fn plane(&self, tick: i64, channel: usize) -> Vec<f32> {
        let scale = self.jump.map_or(1.0, |(at, scale)| if tick >= at { scale } else { 1.0 });
        let sample = |i: usize| {
            let (x, z) = ((i % N) as f32, (i / N) as f32);
            let wave = |(kx, kz, amplitude, turn): &(i32, i32, f32, f32)| {
                let phase = (*kx as f32 * x + *kz as f32 * z) / N as f32 + turn * tick as f32 / 7200.0;
                amplitude * (std::f32::consts::TAU * phase.fract() + channel as f32).sin()
            };
            scale * self.waves.iter().map(wave).sum::<f32>()
        };
        (0..N * N).map(sample).collect()
    }

    fn planes(&self, tick: i64) -> [Vec<f32>; 2] {
        [self.plane(tick, 0), self.plane(tick, 1)]
    }
}

fn waves() -> impl Strategy<Value = Waves> {
    let wave = (-20..20, -20..20, 0.0f32..3.0, -3.0f32..3.0);
    let jump = proptest::option::of((0i64..4000, 0.0f32..1e4));
    (proptest::collection::vec(wave, 0..5), jump).prop_map(|(waves, jump)| Waves { waves, jump })
}

fn frames(unit: UnitName, sea: &Waves, ticks: impl Iterator<Item = i64>, joins: &[i64]) -> Vec<SentFrame> {
    let mut encoder = UnitEncoder::new(unit);
    let mut frames = Vec::new();
    for tick in ticks {
        if joins.contains(&tick) {
            encoder.join();
        }
        let planes = sea.planes(tick);
        let planes: Vec<Plane> = planes.iter().map(|plane| Plane::Samples(plane)).collect();
        frames.extend(encoder.take(N, &planes, Stamp { tick, epoch: 1, sequence: 0, layout: 0 }).unwrap());
    }
    frames
}

/// What a client sees that takes the deepest frame it can read of each tick from `first` on, up to a layer.
fn followed(frames: &[SentFrame], first: i64, layers: u8) -> Vec<DecodedFrame> {
    let mut decoder = Decoder::new(2 * N * N);
    let mut seen: Vec<DecodedFrame> = Vec::new();
    for frame in frames.iter().filter(|frame| frame.tick >= first && layer_of(frame.tick) <= layers) {
        if seen.iter().any(|seen| seen.header.tick == frame.tick as u64) {
            continue;
        }
        match decoder.decode(&frame.bytes) {
            Ok(decoded) => seen.push(decoded),
            Err(error) => assert_eq!(error, DecodeError::Missing),
        }
    }
    seen
}

fn check_against(sea: &Waves, decoded: &DecodedFrame) {
    let h = &decoded.header;
    let exact = sea.planes(h.tick as i64);
    for (c, (got, want)) in decoded.planes.iter().zip(&exact).enumerate() {
        for (got, want) in got.iter().zip(want) {
            let within = f64::from((got - want).abs()) <= f64::from(h.max_error[c]);
            assert!(within || h.flags & FLAG_SATURATED != 0, "{got} for {want} within {}", h.max_error[c]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_decoded_is_what_was_counted(sea in waves(), class in 0u8..4, deflate: bool, skipped in 0i64..20) {
        let class = ErrorClass::from_id(class).unwrap();
        let codec = if deflate { Codec::Deflate } else { Codec::Rans };
        // One tick is passed over, as a server that falls behind does.
        let ticks = || (0..2400).step_by(120).filter(|tick| *tick != skipped * 120);
        let raw = frames(unit(Codec::I16, class), &sea, ticks(), &[]);
        let sent = frames(unit(codec, class), &sea, ticks(), &[960]);
        for (first, layers) in [(0, 2), (0, 1), (0, 0), (960, 2), (960, 0)] {
            for decoded in followed(&sent, first, layers) {
                check_against(&sea, &decoded);
                let plain = raw.iter().find(|frame| frame.tick as u64 == decoded.header.tick).unwrap();
                prop_assert_eq!(&decode(&plain.bytes).unwrap().planes, &decoded.planes);
            }
        }
    }

    #[test]
    fn damaged_bytes_are_refused_or_are_numbers(
        sea in waves(), deflate: bool, at in 0usize..1 << 20, byte: u8, cut in 0usize..4,
    ) {
        let codec = if deflate { Codec::Deflate } else { Codec::Rans };
        let sent = frames(unit(codec, ErrorClass::Millimetre), &sea, (0..1440).step_by(240), &[]);
        let mut decoder = Decoder::new(2 * N * N);
        for frame in &sent {
            let mut bytes = frame.bytes.to_vec();
            let place = HEADER_BYTES + at % (bytes.len() - HEADER_BYTES);
            bytes[place] = byte;
            bytes.truncate(bytes.len() - cut);
            let mut header = split(&frame.bytes).unwrap().0;
            header.payload_bytes -= cut as u32;
            header.seal(&mut bytes);
            if let Ok(decoded) = decoder.decode(&bytes) {
                prop_assert!(decoded.planes.iter().flatten().all(|value| value.is_finite()));
            }
            // The next is predicted from the right one.
            prop_assert!(decoder.decode(&frame.bytes).is_ok());
        }
    }
}

fn swell() -> Waves {
    Waves { waves: vec![(3, 1, 0.3, 0.2), (-2, 5, 0.2, -0.3), (7, -4, 0.1, 0.4)], jump: None }
}

#[test]
fn who_follows_gets_each_tick_once_and_in_the_order_in_which_it_can_be_read() {
    let sent = frames(unit(Codec::Rans, ErrorClass::Millimetre), &swell(), (0..1920).step_by(120), &[]);
    let order: Vec<(i64, u8)> = sent.iter().map(|frame| (frame.tick, frame.depth)).collect();
    let expected = [
        (0, 0),
        (480, 1),
        (240, 4),
        (120, 4),
        (360, 4),
        (960, 2),
        (720, 4),
        (600, 4),
        (840, 4),
        (1440, 3),
        (1200, 4),
        (1080, 4),
        (1320, 4),
    ];
    assert_eq!(order, expected);
    assert_eq!(followed(&sent, 0, 2).len(), sent.len());
    // At half the rate a frame between two others waits for the second of them, and one interval more.
    let sent = frames(unit(Codec::Rans, ErrorClass::Millimetre), &swell(), (0..1200).step_by(240), &[]);
    let order: Vec<(i64, u8)> = sent.iter().map(|frame| (frame.tick, frame.depth)).collect();
    assert_eq!(order, [(0, 0), (480, 1), (240, 4), (960, 2)]);
}

#[test]
fn who_joins_costs_the_others_nothing() {
    let unit = unit(Codec::Rans, ErrorClass::Millimetre);
    let alone = frames(unit, &swell(), (0..4800).step_by(240), &[]);
    let joined = frames(unit, &swell(), (0..4800).step_by(240), &[1920]);
    let deepest: Vec<&SentFrame> = {
        let mut last = None;
        joined.iter().filter(|frame| last.replace(frame.tick) != Some(frame.tick)).collect()
    };
    assert!(alone.iter().eq(deepest), "who follows gets the same bytes");
    let others: Vec<(i64, u8)> = {
        let mut last = None;
        let again = joined.iter().filter(|frame| last.replace(frame.tick) == Some(frame.tick));
        again.map(|frame| (frame.tick, frame.depth)).collect()
    };
    assert_eq!(others, [(1920, 0), (2400, 1), (2880, 2)], "who joins gets three frames of its own");
}

#[test]
fn two_encoders_that_began_apart_make_the_same_bytes_after_three_frames() {
    let unit = unit(Codec::Rans, ErrorClass::HalfMillimetre);
    let old = frames(unit, &swell(), (0..9600).step_by(240), &[]);
    let young = frames(unit, &swell(), (4800..9600).step_by(240), &[]);
    let from = |frames: &[SentFrame]| -> Vec<SentFrame> {
        frames.iter().filter(|frame| frame.tick >= 4800 + 3 * 480).cloned().collect()
    };
    assert!(from(&old).len() > 10 && from(&old) == from(&young));
}

#[test]
fn a_step_that_is_not_finite_breaks_no_prediction() {
    let unit = unit(Codec::Rans, ErrorClass::Millimetre);
    let mut encoder = UnitEncoder::new(unit);
    let mut decoder = Decoder::new(2 * N * N);
    let mut depths = Vec::new();
    for tick in (0..4800).step_by(480) {
        let mut planes = swell().planes(tick);
        if tick == 1920 {
            planes[1][77] = f32::NAN;
        }
        let planes: Vec<Plane> = planes.iter().map(|plane| Plane::Samples(plane)).collect();
        let taken = encoder.take(N, &planes, Stamp { tick, epoch: 1, sequence: 0, layout: 0 });
        assert_eq!(taken.is_err(), tick == 1920);
        for frame in taken.unwrap_or_default() {
            depths.push(frame.depth);
            check_against(&swell(), &decoder.decode(&frame.bytes).unwrap());
        }
    }
    assert_eq!(depths, [0, 1, 2, 3, 0, 1, 2, 3, 3]);
}

#[test]
fn a_decoder_keeps_no_more_than_it_was_made_for() {
    let sent = frames(unit(Codec::Rans, ErrorClass::Millimetre), &swell(), (0..960).step_by(480), &[]);
    assert!(sent[1].depth == 1 && sent[1].depth != BETWEEN);
    let mut small = Decoder::new(2 * N * N - 1);
    assert!(small.decode(&sent[0].bytes).is_ok());
    assert_eq!(small.decode(&sent[1].bytes), Err(DecodeError::Missing));
    let mut other = Decoder::new(2 * N * N);
    assert!(other.decode(&sent[0].bytes).is_ok());
    other.retain(|_| false);
    assert_eq!(other.decode(&sent[1].bytes), Err(DecodeError::Missing));
}

#[test]
fn floats_are_as_they_were_computed() {
    let sea = swell();
    for codec in [Codec::F32, Codec::F16] {
        let sent = frames(unit(codec, ErrorClass::HalfMillimetre), &sea, (0..960).step_by(240), &[]);
        assert_eq!(sent.len(), 4);
        for frame in sent {
            let decoded = decode(&frame.bytes).unwrap();
            check_against(&sea, &decoded);
            if codec == Codec::F32 {
                assert_eq!(decoded.planes, sea.planes(frame.tick));
            }
        }
    }
}

#[test]
fn a_smooth_sea_takes_a_small_part_of_its_counts() {
    let bytes = |codec| -> usize {
        let sent = frames(unit(codec, ErrorClass::Millimetre), &swell(), (0..14_400).step_by(240), &[]);
        sent.iter().map(|frame| frame.bytes.len()).sum()
    };
    let (raw, rans, deflate) = (bytes(Codec::I16), bytes(Codec::Rans), bytes(Codec::Deflate));
    assert!(rans * 8 < raw && deflate * 5 < raw, "{raw} {rans} {deflate}");
}
