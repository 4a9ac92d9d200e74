//! The frames that must be refused: one valid frame with one rule of PROTOCOL.md 5 broken in each.

use serde_json::json;
use swellcast::wire::{FrameHeader, HEADER_BYTES, MAX_TICK, split};

use super::frames::{Sample, samples};

/// Name, the field a reader must blame, why, and the bytes.
pub type Bad = (&'static str, &'static str, &'static str, Vec<u8>);

/// Every frame that must be refused. All but those that break the checksum carry the right one for what they hold.
pub fn all() -> Vec<Bad> {
    let samples = samples();
    let of = |name| samples.iter().find(|s| s.name == name).expect("a sample of this name");
    let whole = of("displacement-8");
    let (pair, tile) = (of("slopes-16"), of("tile-256"));
    let small: Sample = Sample { name: "", about: "", header: tile.header, planes: vec![] };
    let with = |change: &dyn Fn(&mut FrameHeader)| sealed(whole, change);
    let mut bad: Vec<Bad> = vec![
        ("magic", "magic", "the magic is SWF2", with(&|h| h.magic = *b"SWF2")),
        ("header-bytes", "header_bytes", "the header says it is 96 bytes", with(&|h| h.header_bytes = 96)),
        ("class", "class", "there is no class 4", with(&|h| h.class = 4)),
        ("group", "group", "there is no group 9", with(&|h| h.group = 9)),
        ("codec", "codec", "there is no codec 5", with(&|h| h.codec = 5)),
        ("depth-of-key", "depth", "a key frame that is predicted", with(&|h| (h.codec, h.depth) = (1, 1))),
        ("depth-of-counts", "depth", "counts that are predicted", with(&|h| (h.flags, h.depth) = (0, 1))),
        ("depth-between", "depth", "between two others at a tick of the lowest rate", {
            with(&|h| (h.flags, h.codec, h.depth) = (0, 1, 4))
        }),
        ("depth-past", "depth", "from the past at a tick between two others", {
            with(&|h| (h.flags, h.codec, h.depth, h.tick) = (0, 1, 2, 240))
        }),
        ("flags", "flags", "bit 2 of the flags is not defined", with(&|h| h.flags = 0b101)),
        ("n-zero", "n", "n is 0", with(&|h| (h.n, h.level_n, h.payload_bytes) = (0, 0, 0))),
        ("n-not-a-power", "n", "n is 12", with(&|h| (h.n, h.level_n) = (12, 12))),
        ("n-too-small", "n", "n is 4", with(&|h| (h.n, h.level_n) = (4, 4))),
        ("n-too-large", "n", "n is 512", with(&|h| (h.n, h.level_n) = (512, 512))),
        ("n-other", "payload_bytes", "n is 16 for the payload of 8", with(&|h| (h.n, h.level_n) = (16, 16))),
        ("level-n-below", "level_n", "level_n is below n", with(&|h| h.level_n = 4)),
        ("level-n-small-tile", "level_n", "only patches above 256 are cut into tiles", with(&|h| h.level_n = 16)),
        ("level-n-zero", "level_n", "level_n is 0", with(&|h| h.level_n = 0)),
        ("level-n-no-multiple", "level_n", "level_n is 640, no multiple of 256", sealed(&small, |h| h.level_n = 640)),
        ("tile-x", "tile_x", "tile 1 of a patch of one", with(&|h| h.tile_x = 1)),
        ("tile-z", "tile_z", "tile 65535 of a patch of one", with(&|h| h.tile_z = u16::MAX)),
        ("tile-x-beyond", "tile_x", "tile 4 of a patch of four", sealed(&small, |h| h.tile_x = 4)),
        ("channels-none", "channels", "no channels", with(&|h| h.channels = 0)),
        ("channels-many", "channels", "4 channels", with(&|h| h.channels = 4)),
        ("channels-of-other-group", "channels", "slopes with 3 channels", sealed(pair, |h| h.channels = 3)),
        ("zero-at-23", "zero at 23", "byte 23 is not zero", with(&|h| h.zero_a = 1)),
        ("zero-at-84", "zero at 84", "bytes 84 to 87 are not zero", with(&|h| h.zero_b = 0x8000_0000)),
        ("tick-2-53", "tick", "tick is 2^53", with(&|h| h.tick = MAX_TICK as u64 + 1)),
        ("tick-negative", "tick", "tick is above any a double holds", with(&|h| h.tick = u64::MAX)),
        ("payload-bytes-zero", "payload_bytes", "payload_bytes is 0", with(&|h| h.payload_bytes = 0)),
        ("payload-bytes-huge", "payload_bytes", "payload_bytes is 2^32 - 1", with(&|h| h.payload_bytes = u32::MAX)),
        ("step-zero", "step", "a step of 0", with(&|h| h.step[0] = 0.0)),
        ("step-negative", "step", "a step below 0", with(&|h| h.step[1] = -h.step[1])),
        ("step-nan", "step", "a step that is not a number", with(&|h| h.step[2] = f32::from_bits(0x7fc0_0000))),
        ("step-infinite", "step", "an infinite step", with(&|h| h.step[0] = f32::INFINITY)),
        ("step-absent", "step", "a step for a channel that is not there", sealed(pair, |h| h.step[2] = 1.0)),
        ("error-zero", "max_error", "a max_error of 0", with(&|h| h.max_error[2] = 0.0)),
        ("error-negative", "max_error", "a max_error below 0", with(&|h| h.max_error[0] = -0.001)),
        ("error-nan", "max_error", "a max_error that is not a number", {
            with(&|h| h.max_error[1] = f32::from_bits(0x7fc0_0000))
        }),
        ("error-infinite", "max_error", "an infinite max_error", with(&|h| h.max_error[0] = f32::INFINITY)),
        ("error-absent", "max_error", "a max_error for a channel that is not there", {
            sealed(pair, |h| h.max_error[2] = 0.001)
        }),
    ];
    let good = whole.bytes();
    let edited = |edit: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        edit(&mut bytes);
        bytes
    };
    bad.extend([
        ("empty", "length", "no bytes at all", vec![]),
        ("short-magic", "length", "ends within the magic", good[..3].to_vec()),
        ("short-header", "length", "ends one byte before the payload", good[..HEADER_BYTES - 1].to_vec()),
        ("no-payload", "payload", "ends where the payload begins", good[..HEADER_BYTES].to_vec()),
        ("short-payload", "payload", "ends one byte early", good[..good.len() - 1].to_vec()),
        ("long-payload", "payload", "one byte follows the payload", edited(&|b| b.push(0))),
        ("crc", "crc", "the checksum is inverted", edited(&|b| b[80..84].iter_mut().for_each(|x| *x = !*x))),
        ("crc-header", "crc", "a bit of the epoch was flipped", edited(&|b| b[32] ^= 1)),
        ("crc-payload", "crc", "the last bit was flipped", edited(&|b| b[HEADER_BYTES + 383] ^= 0x80)),
        ("big-endian", "header_bytes", "the header's first number has its bytes swapped", edited(&|b| b.swap(4, 5))),
    ]);
    bad
}

/// The sample with its header changed and sealed again.
fn sealed(sample: &Sample, change: impl Fn(&mut FrameHeader)) -> Vec<u8> {
    let mut bytes = sample.bytes();
    let mut header = sample.header;
    change(&mut header);
    header.seal(&mut bytes);
    bytes
}

/// The text beside them.
pub fn index(bad: &[Bad]) -> String {
    let line = |(name, field, why, _): &Bad| {
        format!(
            "  {{\"file\": {}, \"field\": {}, \"why\": {}}}",
            json!(format!("{name}.bin")),
            json!(field),
            json!(why)
        )
    };
    format!("[\n{}\n]\n", bad.iter().map(line).collect::<Vec<_>>().join(",\n"))
}

#[test]
fn every_bad_frame_is_refused_for_its_field() {
    use swellcast::wire::FrameError;
    for (name, field, why, bytes) in all() {
        let blamed = match split(&bytes) {
            Err(FrameError::Short { .. }) => "length",
            Err(FrameError::Field { field, .. }) => field,
            Err(FrameError::Crc { .. }) => "crc",
            Ok(_) => panic!("{name} was accepted, though {why}"),
        };
        assert_eq!(blamed, field, "{name}: {why}");
    }
}
