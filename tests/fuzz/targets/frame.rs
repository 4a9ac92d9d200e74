//! Frames and messages of points: bytes are refused, or they are one that writes the same bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use swellcast::tile::decode;
use swellcast::wire::{HEADER_BYTES, MAX_TICK, POINT_BYTES, POINTS_HEADER_BYTES, TILE, read_points, write_points};

/// Where the header holds the length of what follows it.
const PAYLOAD: usize = 52;
/// Where the header holds the checksum.
const CRC: usize = 80;
/// Where the header of points holds how many they are, and its checksum.
const COUNT: usize = 8;
const POINTS_CRC: usize = 48;
/// The largest payload: three channels of a whole tile.
const MOST: usize = 3 * TILE * TILE * 2;

fuzz_target!(|bytes: &[u8]| {
    check(bytes);
    points(bytes);
    // No mutation finds a checksum, nor the 400 kB of a whole tile: the same again, as long as it says and sealed.
    let Some((head, rest)) = bytes.split_at_checked(HEADER_BYTES) else { return };
    let says = u32::from_le_bytes(head[PAYLOAD..PAYLOAD + 4].try_into().expect("four bytes")) as usize;
    let mut frame = head.to_vec();
    frame.extend(rest.iter().chain(std::iter::repeat(&0x80)).take(says.min(MOST)));
    let mut crc = crc32fast::Hasher::new();
    crc.update(&frame[..CRC]);
    crc.update(&frame[HEADER_BYTES..]);
    frame[CRC..CRC + 4].copy_from_slice(&crc.finalize().to_le_bytes());
    check(&frame);
});

/// As it is, and again with the count and the checksum that fit.
fn points(bytes: &[u8]) {
    check_points(bytes);
    let Some(records) = bytes.len().checked_sub(POINTS_HEADER_BYTES).map(|rest| rest / POINT_BYTES) else { return };
    let mut message = bytes[..POINTS_HEADER_BYTES + records * POINT_BYTES].to_vec();
    message[COUNT..COUNT + 4].copy_from_slice(&(records as u32).to_le_bytes());
    let mut crc = crc32fast::Hasher::new();
    crc.update(&message[..POINTS_CRC]);
    crc.update(&message[POINTS_HEADER_BYTES..]);
    message[POINTS_CRC..POINTS_CRC + 4].copy_from_slice(&crc.finalize().to_le_bytes());
    check_points(&message);
}

fn check_points(bytes: &[u8]) {
    let Ok((header, records)) = read_points(bytes) else { return };
    assert!(header.tick <= MAX_TICK as u64 && header.id <= MAX_TICK as u64);
    let again = write_points(&header, records.iter().copied());
    assert!(again.as_deref() == Some(bytes), "{header:?} is written otherwise");
}

fn check(bytes: &[u8]) {
    let Ok(frame) = decode(bytes) else { return };
    let (header, unit) = (frame.header, frame.unit());
    let (n, level_n) = (usize::from(header.n), usize::from(header.level_n));
    assert_eq!((unit.cascade, unit.level), (header.cascade, header.level));
    assert_eq!(frame.planes.len(), unit.group.channels().len());
    assert!(n <= TILE && header.tick <= MAX_TICK as u64);
    assert!((usize::from(header.tile_x) + 1) * n <= level_n && (usize::from(header.tile_z) + 1) * n <= level_n);
    for (plane, step) in frame.planes.iter().zip(header.step) {
        assert_eq!(plane.len(), n * n);
        if unit.codec.is_float() {
            assert!(plane.iter().all(|value| value.is_finite()));
            continue;
        }
        // The largest count by the largest step is beyond an f32, which the protocol allows: an infinity then.
        let most = 32768.0 * step;
        assert!(plane.iter().all(|value| value.abs() <= most), "a value beyond {most}");
    }
    let mut again = bytes.to_vec();
    again[..HEADER_BYTES].fill(0);
    header.seal(&mut again);
    assert!(again == bytes, "{header:?} is written otherwise");
}
