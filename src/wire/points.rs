//! Points that a client subscribes to, and the message that says how the water is there: 56 bytes and 40 a point.

use serde::{Deserialize, Serialize};

use super::frame::FrameError;
use super::vocabulary::MAX_TICK;

/// First four bytes of every message of points.
pub const POINTS_MAGIC: [u8; 4] = *b"SWP1";
/// Length of its header.
pub const POINTS_HEADER_BYTES: usize = 56;
/// Length of the record of a point.
pub const POINT_BYTES: usize = 40;
/// Most points of one client.
pub const MAX_POINTS: usize = 2000;
/// Farthest from the origin that a point may lie, metres: there an f64 still tells a tenth of a millimetre.
pub const FARTHEST_M: f64 = 1e9;
/// Flag: normals were computed. Velocity and Jacobian have the next two; what was not computed is zero.
pub const FLAG_NORMAL: u32 = 1;
/// Flag: velocities were computed.
pub const FLAG_VELOCITY: u32 = 2;
/// Flag: Jacobians were computed.
pub const FLAG_JACOBIAN: u32 = 4;

const CRC_OFFSET: usize = 48;
const FOLDED: u32 = 1;

/// A client asks for the water at points; replaces what it asked before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Points {
    /// Echoed in the answer, and in every message.
    pub id: u64,
    /// Messages a second.
    pub rate_hz: u32,
    /// World positions (x, z), metres; none ends the flow.
    pub points: Vec<[f64; 2]>,
}

/// Answer to `points`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointsSubscribed {
    /// As sent.
    pub id: u64,
    /// Messages a second.
    pub rate_hz: u32,
    /// The first tick whose message will come.
    pub from_tick: i64,
    /// Points of each.
    pub count: u32,
}

/// What a message of points says beside its records.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointsHeader {
    /// What was computed: [`FLAG_NORMAL`], [`FLAG_VELOCITY`], [`FLAG_JACOBIAN`].
    pub flags: u32,
    /// The tick.
    pub tick: u64,
    /// As in `hello`.
    pub epoch: u64,
    /// Newest entry of the control log in effect at the tick.
    pub sequence: u64,
    /// Of the subscription.
    pub id: u64,
}

/// The water at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointRecord {
    /// Metres.
    pub height: f32,
    /// Unit normal of the surface.
    pub normal: [f32; 3],
    /// m/s.
    pub velocity: [f32; 3],
    /// Determinant of the horizontal mapping.
    pub jacobian: f32,
    /// Distance between the point and the particle found, metres.
    pub residual: f32,
    /// The surface folds here.
    pub folded: bool,
}

impl PointRecord {
    fn numbers(&self) -> [f32; 9] {
        let ([a, b, c], [u, v, w]) = (self.normal, self.velocity);
        [self.height, a, b, c, u, v, w, self.jacobian, self.residual]
    }
}

/// The bytes of a message; `None` where a number is not finite, because a wrong number is never sent.
pub fn write_points(header: &PointsHeader, records: impl Iterator<Item = PointRecord> + Clone) -> Option<Vec<u8>> {
    let points = records.clone().count();
    let count = u32::try_from(points).ok()?;
    let mut bytes = Vec::with_capacity(POINTS_HEADER_BYTES + points * POINT_BYTES);
    bytes.extend(POINTS_MAGIC);
    bytes.extend((POINTS_HEADER_BYTES as u16).to_le_bytes());
    bytes.extend((POINT_BYTES as u16).to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend(header.flags.to_le_bytes());
    for number in [header.tick, header.epoch, header.sequence, header.id] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend([0; 8]);
    for record in records {
        for number in record.numbers() {
            if !number.is_finite() {
                return None;
            }
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(u32::from(record.folded).to_le_bytes());
    }
    let crc = checksum(&bytes);
    bytes[CRC_OFFSET..CRC_OFFSET + 4].copy_from_slice(&crc.to_le_bytes());
    Some(bytes)
}

/// Reads a message, checked in every field, by its length and by its CRC.
///
/// # Errors
/// [`FrameError`] names the first field that is wrong.
pub fn read_points(bytes: &[u8]) -> Result<(PointsHeader, Vec<PointRecord>), FrameError> {
    if bytes.len() < POINTS_HEADER_BYTES {
        return Err(wrong("length", format!("{} bytes", bytes.len()), format!("at least {POINTS_HEADER_BYTES}")));
    }
    let (head, records) = bytes.split_at(POINTS_HEADER_BYTES);
    let is = |field, got: u64, bound: u64| if got == bound { Ok(()) } else { Err(wrong(field, got, bound)) };
    if head[..4] != POINTS_MAGIC {
        return Err(wrong("magic", format!("{:?}", &head[..4]), "SWP1"));
    }
    is("header_bytes", number(head, 4, 2), POINTS_HEADER_BYTES as u64)?;
    is("record_bytes", number(head, 6, 2), POINT_BYTES as u64)?;
    is("count", number(head, 8, 4) * POINT_BYTES as u64, records.len() as u64)?;
    let flags = number(head, 12, 4) as u32;
    if flags & !(FLAG_NORMAL | FLAG_VELOCITY | FLAG_JACOBIAN) != 0 {
        return Err(wrong("flags", flags, "0 to 7"));
    }
    let [tick, epoch, sequence, id] = [16, 24, 32, 40].map(|at| number(head, at, 8));
    for (field, value) in [("tick", tick), ("id", id)] {
        if value > MAX_TICK as u64 {
            return Err(wrong(field, value, "at most 2^53 - 1"));
        }
    }
    is("zero at 52", number(head, 52, 4), 0)?;
    let (got, computed) = (number(head, CRC_OFFSET, 4) as u32, checksum(bytes));
    if got != computed {
        return Err(FrameError::Crc { got, computed });
    }
    let points = records.chunks_exact(POINT_BYTES).map(record).collect::<Result<_, _>>()?;
    Ok((PointsHeader { flags, tick, epoch, sequence, id }, points))
}

fn record(bytes: &[u8]) -> Result<PointRecord, FrameError> {
    let [height, a, b, c, u, v, w, jacobian, residual] =
        std::array::from_fn(|i| f32::from_bits(number(bytes, 4 * i, 4) as u32));
    let flags = number(bytes, 36, 4) as u32;
    if flags & !FOLDED != 0 {
        return Err(wrong("flags of a point", flags, "0 or 1"));
    }
    let (normal, velocity) = ([a, b, c], [u, v, w]);
    let record = PointRecord { height, normal, velocity, jacobian, residual, folded: flags == FOLDED };
    match record.numbers().into_iter().find(|number| !number.is_finite()) {
        None => Ok(record),
        Some(number) => Err(wrong("a number of a point", number, "finite")),
    }
}

fn wrong(field: &'static str, got: impl ToString, bound: impl ToString) -> FrameError {
    FrameError::Field { field, got: got.to_string(), bound: bound.to_string() }
}

/// A little-endian number of so many bytes, up to 8.
fn number(bytes: &[u8], at: usize, length: usize) -> u64 {
    bytes[at..at + length].iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

/// Of all bytes but the checksum itself and what follows it in the header.
fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bytes[..CRC_OFFSET]);
    crc.update(&bytes[POINTS_HEADER_BYTES..]);
    crc.finalize()
}
