//! Streams of frames that are predicted from one another, and payloads that must be refused.

use std::fmt::Write as _;

use serde_json::json;
use swellcast::pass::quantise::Found;
use swellcast::tile::{Decoder, Plane, SentFrame, Stamp, UnitEncoder};
use swellcast::wire::{Codec, ErrorClass, Group, HEADER_BYTES, UnitName, split};

/// Frames in the order in which they are sent, and in which they must be read.
pub struct Stream {
    pub name: &'static str,
    about: &'static str,
    pub frames: Vec<SentFrame>,
}

/// Whole numbers without any rounding, so that every machine makes the same bytes: bumps that travel, on noise.
fn counts(n: usize, channel: i64, tick: i64, height: i64) -> Vec<i16> {
    let side = n as i64;
    let triangle = |at: i64| ((at.rem_euclid(2 * side)) - side).abs() - side / 2;
    let sample = |i: usize| {
        let (x, z) = (i as i64 % side, i as i64 / side);
        let moved = tick / 120;
        let wave = triangle(2 * x + moved + channel) * height / 4 + triangle(4 * z - moved + x) * height / 16;
        let noise = (x * 37 + z * 91 + channel * 173 + moved * moved * 7) % 3 - 1;
        (wave + noise).clamp(-32767, 32767) as i16
    };
    (0..n * n).map(sample).collect()
}

/// A stream at 60 Hz that somebody joins at its end: each tick once, as who joined it at first gets it.
fn stream(unit: UnitName, n: usize, height: impl Fn(i64) -> i64) -> Vec<SentFrame> {
    let mut encoder = UnitEncoder::new(unit);
    let mut frames = Vec::new();
    for tick in (7200..7200 + 5 * 480).step_by(120) {
        let channels = unit.group.channels().len() as i64;
        let planes: Vec<Vec<i16>> = (0..channels).map(|c| counts(n, c, tick, height(tick))).collect();
        let planes: Vec<Plane> = planes.iter().map(|plane| Plane::Counts(plane, Found::default())).collect();
        let stamp = Stamp { tick, epoch: 0x0123_4567_89ab_cdef, sequence: 2, layout: 0 };
        frames.extend(encoder.take(n, &planes, stamp).expect("counts are finite"));
    }
    frames
}

fn floats(unit: UnitName) -> Vec<SentFrame> {
    let values: Vec<f32> = (0..64).map(|i| (i as f32 - 31.5) / 16.0).collect();
    let stamp = Stamp { tick: 240, epoch: 0x0123_4567_89ab_cdef, sequence: 2, layout: 0 };
    UnitEncoder::new(unit).take(8, &[Plane::Samples(&values), Plane::Samples(&values)], stamp).expect("finite")
}

/// All streams.
pub fn all() -> Vec<Stream> {
    let unit = |group, codec| UnitName { cascade: 1, level: 0, class: ErrorClass::Millimetre, group, codec };
    let (slopes, height, foam) = (Group::Slopes, Group::Height, Group::Foam);
    let made = |name, about, frames| Stream { name, about, frames };
    vec![
        made("rans-16", "60 Hz, one table a channel", stream(unit(slopes, Codec::Rans), 16, |_| 40)),
        made("rans-64", "60 Hz, four tables a channel", stream(unit(height, Codec::Rans), 64, |_| 40)),
        made("rans-escapes", "samples beyond what a symbol holds", {
            stream(unit(height, Codec::Rans), 64, |tick| if tick == 8160 { 70 } else { 40 })
        }),
        made("rans-shift", "low bits apart", stream(unit(height, Codec::Rans), 16, |tick| 20 * (tick / 120 % 90))),
        made("rans-still", "nothing at all", stream(unit(foam, Codec::Rans), 64, |_| 0)),
        made("deflate-16", "60 Hz", stream(unit(slopes, Codec::Deflate), 16, |_| 40)),
        made("deflate-wide", "residuals of two bytes", {
            stream(unit(slopes, Codec::Deflate), 16, |tick| 20 * (tick / 120 % 90))
        }),
        made("f16-8", "16-bit floats", floats(unit(slopes, Codec::F16))),
        made("f32-8", "32-bit floats", floats(unit(slopes, Codec::F32))),
    ]
}

/// The file: each frame after its length, a u32.
pub fn bytes(stream: &Stream) -> Vec<u8> {
    let mut bytes = Vec::new();
    for frame in &stream.frames {
        bytes.extend((frame.bytes.len() as u32).to_le_bytes());
        bytes.extend(&frame.bytes);
    }
    bytes
}

/// The text beside it: of each frame what tells it from the others, and of each channel the CRC-32 of its counts as
/// 16-bit integers, or of its floats as 32-bit ones.
pub fn describe(stream: &Stream) -> String {
    let mut decoder = Decoder::new(1 << 20);
    let mut lines = Vec::new();
    for frame in &stream.frames {
        let decoded = decoder.decode(&frame.bytes).expect("a stream is valid");
        let h = decoded.header;
        let is_float = Codec::from_id(h.codec).is_some_and(Codec::is_float);
        let crc = |(plane, step): (&Vec<f32>, &f32)| {
            let count = |value: &f32| ((value / step).round() as i16).to_le_bytes();
            let bytes: Vec<u8> = match is_float {
                true => plane.iter().flat_map(|value| value.to_le_bytes()).collect(),
                false => plane.iter().flat_map(count).collect(),
            };
            crc32fast::hash(&bytes)
        };
        let crcs: Vec<u32> = decoded.planes.iter().zip(&h.step).map(crc).collect();
        lines.push(
            json!({ "tick": h.tick.to_string(), "depth": h.depth, "flags": h.flags,
            "bytes": frame.bytes.len(), "crc32": crcs })
            .to_string(),
        );
    }
    let mut text = String::new();
    let _ = write!(text, "{{\n  \"about\": {},\n  \"frames\": [\n    ", json!(stream.about));
    text + &lines.join(",\n    ") + "\n  ]\n}\n"
}

/// Single frames whose headers are right and whose payloads are not: name, why, bytes.
pub fn damaged() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let streams = all();
    let frame = |name: &str, at: usize| {
        streams.iter().find(|stream| stream.name == name).expect("a stream of this name").frames[at].bytes.to_vec()
    };
    let key = || frame("rans-16", 0);
    let plane = HEADER_BYTES + 20;
    let states = plane + 12;
    let edited = |bytes: Vec<u8>, edit: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = bytes;
        edit(&mut bytes);
        let mut header = split_unchecked(&bytes);
        header.payload_bytes = (bytes.len() - HEADER_BYTES) as u32;
        header.seal(&mut bytes);
        bytes
    };
    vec![
        ("reference", "predicted from frames that are not held", frame("rans-16", 4)),
        ("wide", "wide is 2", edited(key(), &|b| b[HEADER_BYTES + 16] = 2)),
        ("wide-rans", "wide is 1 with rANS", edited(key(), &|b| b[HEADER_BYTES + 16] = 1)),
        ("taps-fixed", "taps where deflate's are fixed", edited(frame("deflate-16", 0), &|b| b[HEADER_BYTES] = 1)),
        ("taps-zero", "a byte after wide is not zero", edited(key(), &|b| b[HEADER_BYTES + 18] = 1)),
        ("contexts", "two contexts", edited(key(), &|b| b[plane] = 2)),
        ("shift", "nine low bits", edited(key(), &|b| b[plane + 1] = 9)),
        ("tables-odd", "tables of an odd length", edited(key(), &|b| b[plane + 2] ^= 1)),
        ("words-many", "more words than samples", edited(key(), &|b| b[plane + 6] = 255)),
        ("escapes-many", "more escapes than samples", edited(key(), &|b| b[plane + 10] = 255)),
        ("state-small", "a state below 2^15", edited(key(), &|b| b[states..states + 4].fill(0))),
        ("state-large", "a state of 2^31", edited(key(), &|b| b[states + 3] = 0x80)),
        ("table-short", "slots that don't add up", edited(key(), &|b| b[plane + 30] ^= 1)),
        ("table-long", "symbols above 255", edited(key(), &|b| b[plane + 29] = 255)),
        ("cut", "ends within the last plane", edited(key(), &|b| b.truncate(b.len() - 4))),
        ("longer", "four bytes after the last plane", edited(key(), &|b| b.extend([0; 4]))),
        (
            "f32-nan",
            "a float that is no number",
            edited(frame("f32-8", 0), &|b| {
                b[HEADER_BYTES + 4..HEADER_BYTES + 8].copy_from_slice(&f32::NAN.to_le_bytes());
            }),
        ),
        (
            "f16-infinite",
            "an infinite float",
            edited(frame("f16-8", 0), &|b| {
                b[HEADER_BYTES..HEADER_BYTES + 2].copy_from_slice(&0x7c00u16.to_le_bytes());
            }),
        ),
        ("deflate", "no deflate stream", edited(frame("deflate-16", 0), &|b| b[HEADER_BYTES + 40..].fill(0xff))),
        (
            "deflate-short",
            "a deflate stream of fewer bytes",
            edited(frame("deflate-16", 0), &|b| {
                b.truncate(HEADER_BYTES + 40);
                // One stored block of one byte.
                b.extend([1, 1, 0, 0xfe, 0xff, 7]);
            }),
        ),
    ]
}

/// The header of a frame that may be wrong otherwise.
fn split_unchecked(bytes: &[u8]) -> swellcast::wire::FrameHeader {
    let whole = all().into_iter().flat_map(|stream| stream.frames);
    let mut same = whole.filter(|frame| frame.bytes[..52] == bytes[..52]);
    split(&same.next().expect("a frame with this header").bytes).expect("a stream is valid").0
}

/// The text beside them.
pub fn index() -> String {
    let line = |(name, why, _): &(&str, &str, Vec<u8>)| {
        format!("  {{\"file\": {}, \"why\": {}}}", json!(format!("{name}.bin")), json!(why))
    };
    format!("[\n{}\n]\n", damaged().iter().map(line).collect::<Vec<_>>().join(",\n"))
}

#[test]
fn every_damaged_payload_is_refused() {
    for (name, why, bytes) in damaged() {
        assert!(split(&bytes).is_ok(), "{name}: the header is right");
        assert!(Decoder::new(1 << 20).decode(&bytes).is_err(), "{name} was accepted: {why}");
    }
}

#[test]
fn the_streams_hold_what_they_are_named_for() {
    let streams = all();
    let depths = |name: &str| -> Vec<u8> {
        let stream = streams.iter().find(|stream| stream.name == name).unwrap();
        stream.frames.iter().map(|frame| frame.depth).collect()
    };
    assert_eq!(depths("rans-16"), [0, 1, 4, 4, 4, 2, 4, 4, 4, 3, 4, 4, 4, 3, 4, 4, 4]);
    let byte = |name: &str, at: usize| {
        let stream = streams.iter().find(|stream| stream.name == name).unwrap();
        stream.frames.iter().map(|frame| frame.bytes[HEADER_BYTES + 20 + at]).collect::<Vec<_>>()
    };
    assert!(byte("rans-64", 0).contains(&4));
    assert!(byte("rans-16", 0).iter().all(|contexts| *contexts == 1));
    assert!(byte("rans-shift", 1).iter().any(|shift| *shift > 0));
    assert!(byte("rans-escapes", 8).iter().any(|escapes| *escapes > 0));
    let wide = streams.iter().find(|stream| stream.name == "deflate-wide").unwrap();
    assert!(wide.frames.iter().any(|frame| frame.bytes[HEADER_BYTES + 16] == 1));
}
