//! The fixed 88-byte header of a frame: build it, read it, and refuse every wrong one.

use bincode::{Decode, Encode};
use thiserror::Error;

use super::vocabulary::{BETWEEN, Codec, ErrorClass, Group, MAX_DEPTH, MAX_TICK, TILE, layer_of};

/// First four bytes of every frame.
pub const MAGIC: [u8; 4] = *b"SWF1";
/// Length of the header; the payload begins here, aligned to 8 bytes.
pub const HEADER_BYTES: usize = 88;
/// Flag: the frame decodes by itself.
pub const FLAG_KEY: u8 = 1;
/// Flag: a sample was clamped, `max_error` does not hold for it.
pub const FLAG_SATURATED: u8 = 2;

const CRC_OFFSET: usize = 80;
const CONFIG: bincode::config::Configuration<bincode::config::LittleEndian, bincode::config::Fixint> =
    bincode::config::standard().with_fixed_int_encoding();

/// Everything a frame says about its payload (PROTOCOL.md section 5, in the order of its bytes).
#[derive(Clone, Copy, Debug, PartialEq, Encode, Decode)]
#[allow(missing_docs)] // The table of PROTOCOL.md section 5 is their documentation.
pub struct FrameHeader {
    pub magic: [u8; 4],
    pub header_bytes: u16,
    pub cascade: u8,
    pub level: u8,
    pub class: u8,
    pub group: u8,
    pub codec: u8,
    pub flags: u8,
    pub n: u16,
    pub level_n: u16,
    pub tile_x: u16,
    pub tile_z: u16,
    pub channels: u16,
    pub depth: u8,
    pub zero_a: u8,
    pub tick: u64,
    pub epoch: u64,
    pub sequence: u64,
    pub layout: u32,
    pub payload_bytes: u32,
    pub step: [f32; 3],
    pub max_error: [f32; 3],
    pub crc: u32,
    pub zero_b: u32,
}

/// Why bytes are not a frame: the field, what it held, and what it may hold.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FrameError {
    /// Fewer bytes than a header.
    #[error("frame is {got} bytes, a header alone is {HEADER_BYTES}")]
    Short {
        /// Bytes received.
        got: usize,
    },
    /// A field that no frame may hold.
    #[error("{field} is {got}, must be {bound}")]
    Field {
        /// Name of the field in PROTOCOL.md.
        field: &'static str,
        /// The value found.
        got: String,
        /// What is allowed.
        bound: String,
    },
    /// The bytes were changed on the way.
    #[error("crc is {got:#010x}, the bytes give {computed:#010x}")]
    Crc {
        /// The header's checksum.
        got: u32,
        /// The checksum of what arrived.
        computed: u32,
    },
}

fn must(ok: bool, field: &'static str, got: impl ToString, bound: impl ToString) -> Result<(), FrameError> {
    if ok { Ok(()) } else { Err(FrameError::Field { field, got: got.to_string(), bound: bound.to_string() }) }
}

impl FrameHeader {
    /// Writes the header and its checksum over the first [`HEADER_BYTES`] of `frame`, whose rest is the payload.
    ///
    /// # Panics
    /// If `frame` is shorter than a header.
    pub fn seal(&self, frame: &mut [u8]) {
        let (head, payload) = frame.split_at_mut(HEADER_BYTES);
        bincode::encode_into_slice(self, head, CONFIG).expect("a header always fits its fixed size");
        let crc = checksum(head, payload);
        head[CRC_OFFSET..CRC_OFFSET + 4].copy_from_slice(&crc.to_le_bytes());
    }

    fn check(&self, payload: &[u8]) -> Result<(), FrameError> {
        must(self.magic == MAGIC, "magic", format!("{:?}", self.magic), "SWF1")?;
        must(usize::from(self.header_bytes) == HEADER_BYTES, "header_bytes", self.header_bytes, HEADER_BYTES)?;
        must(ErrorClass::from_id(self.class).is_some(), "class", self.class, "0 to 3")?;
        let Some(codec) = Codec::from_id(self.codec) else {
            return must(false, "codec", self.codec, "0 to 4");
        };
        must(self.flags & !(FLAG_KEY | FLAG_SATURATED) == 0, "flags", self.flags, "0 to 3")?;
        let (n, level_n) = (usize::from(self.n), usize::from(self.level_n));
        must((8..=TILE).contains(&n) && n.is_power_of_two(), "n", n, "a power of two, 8 to 256")?;
        must(
            level_n == n || (n == TILE && level_n > n && level_n.is_multiple_of(TILE)),
            "level_n",
            level_n,
            "n, or a multiple of it above 256",
        )?;
        must(usize::from(self.tile_x) < level_n / n, "tile_x", self.tile_x, "below level_n / n")?;
        must(usize::from(self.tile_z) < level_n / n, "tile_z", self.tile_z, "below level_n / n")?;
        let Some(group) = Group::from_id(self.group) else {
            return must(false, "group", self.group, "0 to 8");
        };
        let channels = group.channels().len();
        must(usize::from(self.channels) == channels, "channels", self.channels, channels)?;
        must(self.zero_a == 0, "zero at 23", self.zero_a, 0)?;
        must(self.zero_b == 0, "zero at 84", self.zero_b, 0)?;
        must(self.tick <= MAX_TICK as u64, "tick", self.tick, "at most 2^53 - 1")?;
        must(self.flags & FLAG_KEY == 0 || self.depth == 0, "depth", self.depth, "0 in a key frame")?;
        let deepest = match layer_of(self.tick as i64) {
            _ if !codec.predicts() => 0..=0,
            0 => 0..=MAX_DEPTH,
            1 | 2 => BETWEEN..=BETWEEN,
            _ => 0..=0,
        };
        must(
            self.depth == 0 || deepest.contains(&self.depth),
            "depth",
            self.depth,
            "one that the codec and the tick allow",
        )?;
        for c in 0..3 {
            let here = c < channels;
            for (field, value) in [("step", self.step[c]), ("max_error", self.max_error[c])] {
                let ok = match here {
                    // What was computed is sent as it is.
                    true if codec == Codec::F32 && field == "max_error" => value == 0.0,
                    true => value.is_finite() && value > 0.0,
                    false => value == 0.0,
                };
                let bound = if here { "finite and above 0, but 0 for the error of f32" } else { "0: absent channel" };
                must(ok, field, value, bound)?;
            }
        }
        let bytes = self.payload_bytes as usize;
        let possible = codec.payload_is_possible(channels * n * n, bytes);
        must(possible, "payload_bytes", bytes, "what the codec and the samples allow")?;
        must(payload.len() == bytes, "payload", format!("{} bytes", payload.len()), format!("{bytes} bytes"))
    }
}

/// Reads a frame: its header, checked in every field, and its payload, checked by length and CRC.
///
/// # Errors
/// [`FrameError`] names the first field that is wrong.
pub fn split(frame: &[u8]) -> Result<(FrameHeader, &[u8]), FrameError> {
    let Some((head, payload)) = frame.split_at_checked(HEADER_BYTES) else {
        return Err(FrameError::Short { got: frame.len() });
    };
    let (header, _): (FrameHeader, usize) =
        bincode::decode_from_slice(head, CONFIG).map_err(|_| FrameError::Short { got: frame.len() })?;
    header.check(payload)?;
    let computed = checksum(head, payload);
    if header.crc != computed {
        return Err(FrameError::Crc { got: header.crc, computed });
    }
    Ok((header, payload))
}

fn checksum(head: &[u8], payload: &[u8]) -> u32 {
    let mut crc = crc32fast::Hasher::new();
    crc.update(&head[..CRC_OFFSET]);
    crc.update(payload);
    crc.finalize()
}
