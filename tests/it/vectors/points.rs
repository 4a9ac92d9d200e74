//! The vectors of points: messages, and what they hold.

use serde_json::json;
use swellcast::wire::{
    FrameError, MAX_TICK, POINTS_HEADER_BYTES, PointRecord, PointsHeader, read_points, write_points,
};

/// Name, header and records of each.
pub fn samples() -> Vec<(&'static str, PointsHeader, Vec<PointRecord>)> {
    let header = PointsHeader { flags: 7, tick: 7200, epoch: 0x0123_4567_89ab_cdef, sequence: 3, id: 5 };
    let last =
        PointsHeader { flags: 0, tick: MAX_TICK as u64, epoch: u64::MAX, sequence: u64::MAX, id: MAX_TICK as u64 };
    let record = |i: i16| PointRecord {
        height: f32::from(i) * 0.125,
        normal: [0.6, 0.8, -0.0],
        velocity: [f32::from(i), -0.5, 1e-3],
        jacobian: 1.0 - 0.75 * f32::from(i),
        residual: 6.25e-5,
        folded: i > 1,
    };
    vec![
        ("three", header, (0..3).map(record).collect()),
        ("none", header, vec![]),
        ("largest", last, vec![PointRecord { height: f32::MAX, ..PointRecord::default() }]),
    ]
}

pub fn bytes((_, header, records): &(&str, PointsHeader, Vec<PointRecord>)) -> Vec<u8> {
    write_points(header, records.iter().copied()).expect("all numbers are finite")
}

pub fn describe((_, header, records): &(&str, PointsHeader, Vec<PointRecord>)) -> String {
    let record = |r: &PointRecord| {
        json!({
            "height": r.height, "normal": r.normal, "velocity": r.velocity, "jacobian": r.jacobian,
            "residual": r.residual, "folded": r.folded,
        })
    };
    let described = json!({
        "flags": header.flags,
        "tick": header.tick.to_string(),
        "epoch": header.epoch.to_string(),
        "sequence": header.sequence.to_string(),
        "id": header.id.to_string(),
        "points": records.iter().map(record).collect::<Vec<_>>(),
    });
    format!("{described:#}\n")
}

#[test]
fn points_are_read_as_they_were_written_and_every_wrong_byte_is_found() {
    for sample in samples() {
        let written = bytes(&sample);
        assert_eq!(read_points(&written), Ok((sample.1, sample.2.clone())), "{}", sample.0);
        for at in 0..written.len() {
            let mut wrong = written.clone();
            wrong[at] ^= 0x41;
            read_points(&wrong).expect_err("a changed byte");
            read_points(&written[..at]).expect_err("a message cut short");
        }
        assert!(read_points(&[&written[..], &[0]].concat()).is_err(), "a message too long");
    }
    for value in [f32::NAN, f32::INFINITY] {
        let wrong = PointRecord { residual: value, ..PointRecord::default() };
        assert_eq!(write_points(&samples()[0].1, [wrong].into_iter()), None);
    }
}

#[test]
fn a_wrong_message_of_points_is_refused_for_its_field() {
    let good = bytes(&samples()[0]);
    for (at, byte, field) in [
        (0, b'X', "magic"),
        (3, b'2', "magic"),
        (4, 88, "header_bytes"),
        (6, 44, "record_bytes"),
        (8, 4, "count"),
        (11, 255, "count"),
        (12, 8, "flags"),
        (22, 0x20, "tick"),
        (46, 0x20, "id"),
        (52, 1, "zero at 52"),
    ] {
        let mut wrong = good.clone();
        wrong[at] = byte;
        assert!(matches!(read_points(&wrong), Err(FrameError::Field { field: f, .. }) if f == field), "{field}");
    }
    // With the checksum that fits, so that each field is checked and not the checksum alone.
    for (at, byte, field) in [(36, 2, "flags of a point"), (3, 0x7f, "a number of a point")] {
        let mut wrong = good.clone();
        wrong[POINTS_HEADER_BYTES + at] = byte;
        if field.starts_with("a number") {
            wrong[POINTS_HEADER_BYTES + 2] = 0x80;
        }
        let mut crc = crc32fast::Hasher::new();
        crc.update(&wrong[..48]);
        crc.update(&wrong[POINTS_HEADER_BYTES..]);
        wrong[48..52].copy_from_slice(&crc.finalize().to_le_bytes());
        assert!(matches!(read_points(&wrong), Err(FrameError::Field { field: f, .. }) if f == field), "{field}");
    }
}
