//! The valid frames, and the text beside each that says what it holds.

use serde::Serialize;
use serde_json::{Value, json};
use swellcast::wire::{Codec, ErrorClass, FLAG_KEY, FLAG_SATURATED, FrameHeader, Group, HEADER_BYTES, MAGIC, MAX_TICK};

/// A frame before it is bytes.
pub struct Sample {
    /// File name without ending.
    pub name: &'static str,
    /// What it is a vector of.
    pub about: &'static str,
    /// Its header; the checksum is made when it becomes bytes.
    pub header: FrameHeader,
    /// Counts of each channel.
    pub planes: Vec<Vec<i16>>,
}

impl Sample {
    /// The frame as it goes over the wire.
    pub fn bytes(&self) -> Vec<u8> {
        let mut frame = vec![0; HEADER_BYTES];
        frame.extend(self.planes.iter().flatten().flat_map(|count| count.to_le_bytes()));
        self.header.seal(&mut frame);
        frame
    }
}

/// A header of a whole patch of `n` samples a side; the bound is the class's, a step a hair below twice of it.
fn header(group: Group, class: ErrorClass, n: u16, tick: u64) -> FrameHeader {
    let channels = group.channels().len();
    let bound = class.max_error(group);
    let each = |value: f32| std::array::from_fn(|c| if c < channels { value } else { 0.0 });
    FrameHeader {
        magic: MAGIC,
        header_bytes: HEADER_BYTES as u16,
        cascade: 0,
        level: 0,
        class: class.id(),
        group: group.id(),
        codec: Codec::I16.id(),
        flags: FLAG_KEY,
        n,
        level_n: n,
        tile_x: 0,
        tile_z: 0,
        channels: channels as u16,
        depth: 0,
        zero_a: 0,
        tick,
        epoch: 0x0123_4567_89ab_cdef,
        sequence: 0,
        layout: 1,
        payload_bytes: (channels * usize::from(n) * usize::from(n) * 2) as u32,
        step: each(2.0 * bound * 0.999),
        max_error: each(bound),
        crc: 0,
        zero_b: 0,
    }
}

/// Planes of whole numbers from a formula without any rounding, so that every machine makes the same bytes.
fn planes(header: &FrameHeader, value: impl Fn(i64, i64, i64) -> i64) -> Vec<Vec<i16>> {
    let n = i64::from(header.n);
    let count = |c, i| i16::try_from(value(c, i % n, i / n)).expect("a count is an i16");
    (0..i64::from(header.channels)).map(|c| (0..n * n).map(|i| count(c, i)).collect()).collect()
}

/// The valid frames.
pub fn samples() -> Vec<Sample> {
    use ErrorClass::{FiveMillimetres, HalfMillimetre, Millimetre, TwentyMillimetres};
    let ramp = |c, x, z| 1000 * (c + 1) + 10 * z + x - 1234;
    let waves = |c, x: i64, z: i64| ((x * 37 + z * 91 + c * 173) % 401 - 200) * (c + 1);

    let displacement = header(Group::Displacement, Millimetre, 8, 7200);
    let slopes = header(Group::Slopes, HalfMillimetre, 16, 480);
    let derivatives = header(Group::Derivatives, FiveMillimetres, 16, 7680);
    let normals = header(Group::Normals, Millimetre, 16, 960);
    let height = FrameHeader { level: 3, ..header(Group::Height, Millimetre, 8, 240) };
    let foam = header(Group::Foam, TwentyMillimetres, 8, 14400);
    let mut saturated = header(Group::Displacement, HalfMillimetre, 8, 720_000);
    saturated.flags |= FLAG_SATURATED;
    let mut last = header(Group::Foam, Millimetre, 8, MAX_TICK as u64);
    (last.cascade, last.level, last.epoch, last.sequence, last.layout) = (255, 255, u64::MAX, u64::MAX, u32::MAX);
    last.flags = 0;
    let mut tile = header(Group::Foam, Millimetre, 256, 7200 * 3600);
    (tile.cascade, tile.level, tile.level_n, tile.tile_x, tile.tile_z) = (1, 1, 1024, 3, 1);
    tile.sequence = 7;
    let edges = |_, x: i64, z: i64| [-32768, 32767, -32767, 0, 1, -1, 255, 256][((x + z) % 8) as usize];
    let sample = |name, about, header: FrameHeader, planes| Sample { name, about, header, planes };
    vec![
        sample(
            "displacement-8",
            "rows run along x: a count grows by 1 along x, by 10 along z, by 1000 by channel",
            displacement,
            planes(&displacement, ramp),
        ),
        sample("slopes-16", "two channels: the third step and max_error are zero", slopes, planes(&slopes, waves)),
        sample("derivatives-16", "three channels of both signs", derivatives, planes(&derivatives, waves)),
        sample("normals-16", "a group of a later number", normals, planes(&normals, waves)),
        sample("height-8", "one channel, of a level", height, planes(&height, ramp)),
        sample("foam-8", "one channel, none below zero", foam, planes(&foam, |_, x, z| (x * z) % 13)),
        sample("saturated-8", "the largest and smallest counts; max_error does not hold", saturated, {
            planes(&saturated, edges)
        }),
        sample("largest-8", "every header number at its largest, the key flag not set", last, planes(&last, edges)),
        sample("tile-256", "a tile of a larger patch, at level 1", tile, {
            planes(&tile, |_, x, z| (x * x + 3 * z * z + x * z) % 251)
        }),
    ]
}

/// Every field of the header by its name in PROTOCOL.md, in the order of its bytes.
#[derive(Serialize)]
struct Fields {
    magic: String,
    header_bytes: u16,
    cascade: u8,
    level: u8,
    class: u8,
    group: u8,
    codec: u8,
    flags: u8,
    n: u16,
    level_n: u16,
    tile_x: u16,
    tile_z: u16,
    channels: u16,
    depth: u8,
    tick: String,
    epoch: String,
    sequence: String,
    layout: u32,
    payload_bytes: u32,
    step: [f64; 3],
    max_error: [f64; 3],
    crc: u32,
}

/// The text beside a frame. Counts stand in full up to 16 samples a side, above it their CRC-32 as bytes.
pub fn describe(sample: &Sample) -> String {
    let bytes = sample.bytes();
    let h = swellcast::wire::split(&bytes).expect("a sample is valid").0;
    let fields = Fields {
        magic: String::from_utf8_lossy(&h.magic).into_owned(),
        header_bytes: h.header_bytes,
        cascade: h.cascade,
        level: h.level,
        class: h.class,
        group: h.group,
        codec: h.codec,
        flags: h.flags,
        n: h.n,
        level_n: h.level_n,
        tile_x: h.tile_x,
        tile_z: h.tile_z,
        channels: h.channels,
        depth: h.depth,
        tick: h.tick.to_string(),
        epoch: h.epoch.to_string(),
        sequence: h.sequence.to_string(),
        layout: h.layout,
        payload_bytes: h.payload_bytes,
        step: h.step.map(f64::from),
        max_error: h.max_error.map(f64::from),
        crc: h.crc,
    };
    let names = Group::from_id(h.group).expect("a sample is valid").channels();
    let plane = |(name, counts): (&&str, &Vec<i16>)| -> Value {
        let bytes: Vec<u8> = counts.iter().flat_map(|count| count.to_le_bytes()).collect();
        let crc32 = crc32fast::hash(&bytes);
        if h.n <= 16 {
            json!({ "channel": name, "counts": counts, "crc32": crc32 })
        } else {
            json!({ "channel": name, "crc32": crc32 })
        }
    };
    let planes: Vec<String> = names.iter().zip(&sample.planes).map(|pair| plane(pair).to_string()).collect();
    let head = serde_json::to_string_pretty(&fields).expect("plain data").replace("\n", "\n  ");
    let about = json!(sample.about);
    format!(
        "{{\n  \"about\": {about},\n  \"header\": {head},\n  \"planes\": [\n    {}\n  ]\n}}\n",
        planes.join(",\n    ")
    )
}
