//! The words of the protocol: error classes, groups of channels, and its few constants.

use serde::{Deserialize, Serialize};

/// WebSocket subprotocol a client must name.
pub const SUBPROTOCOL: &str = "swellcast.v1";
/// Ticks in a second: divisible by every common frame rate from 24 to 144 Hz.
pub const TICKS_PER_SECOND: i64 = 7200;
/// Frame rates that can be asked for; each divides the next, so their ticks nest.
pub const RATES_HZ: [u32; 3] = [15, 30, 60];
/// Ticks between frames of the lowest rate, 15 Hz: the grid on which layouts are cross-faded.
pub const SLOWEST_INTERVAL: i64 = TICKS_PER_SECOND / RATES_HZ[0] as i64;
/// A cascade that ends is exactly zero for this long before its last tick: three frames of the lowest rate, so that
/// nobody has to guess what comes after the last.
pub const REST_TICKS: i64 = 3 * SLOWEST_INTERVAL;
/// The largest tick: 2^53 - 1, so that JSON and JavaScript hold every tick exactly (39,645 years).
pub const MAX_TICK: i64 = (1 << 53) - 1;
/// Most samples a side of one tile; larger patches are cut.
pub const TILE: usize = 256;
/// Frames of the lowest rate that a prediction may reach back to.
pub const MAX_DEPTH: u8 = 3;
/// Depth of a frame that lies between two others and is predicted from both.
pub const BETWEEN: u8 = 4;

/// The temporal layer of a tick: 0 where the lowest rate has a frame, 1 halfway between those, 2 halfway between all of
/// these; higher ones are no frame's. Frames of a layer are predicted from layers below it alone.
pub fn layer_of(tick: i64) -> u8 {
    let layer = RATES_HZ.iter().position(|rate| tick % (TICKS_PER_SECOND / i64::from(*rate)) == 0);
    layer.unwrap_or(RATES_HZ.len()) as u8
}

/// How long before its tick a frame is due to leave the server, ticks: the one place that says so.
///
/// Where frames are predicted, those that lie between two of the lowest rate wait for the second of them: at 30 Hz for one
/// interval more, at 60 Hz until their turn comes, one each 120 ticks.
pub fn lead_of(tick: i64, interval: i64, codec: Codec, lead_ticks: i64) -> i64 {
    let turn = match (layer_of(tick), interval < SLOWEST_INTERVAL / 2) {
        _ if !codec.predicts() => 0,
        (1, false) => SLOWEST_INTERVAL,
        (1, true) => SLOWEST_INTERVAL * 3 / 4,
        (2, _) if tick % SLOWEST_INTERVAL < SLOWEST_INTERVAL / 2 => SLOWEST_INTERVAL * 5 / 4,
        (2, _) => SLOWEST_INTERVAL,
        _ => 0,
    };
    lead_ticks - turn
}

/// How far a streamed sample may be from the field it stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ErrorClass {
    /// 0.5 mm, slopes .001, foam .002.
    #[serde(rename = "0.5mm")]
    HalfMillimetre,
    /// 1 mm, slopes .002, foam .004.
    #[serde(rename = "1mm")]
    Millimetre,
    /// 5 mm, slopes .005, foam .01.
    #[serde(rename = "5mm")]
    FiveMillimetres,
    /// 20 mm, slopes .02, foam .04.
    #[serde(rename = "20mm")]
    TwentyMillimetres,
}

impl ErrorClass {
    /// All classes, finest first; the index is the wire's id.
    pub const ALL: [Self; 4] = [Self::HalfMillimetre, Self::Millimetre, Self::FiveMillimetres, Self::TwentyMillimetres];

    /// The wire's number for this class.
    pub fn id(self) -> u8 {
        self as u8
    }

    /// The class with this number.
    pub fn from_id(id: u8) -> Option<Self> {
        Self::ALL.get(usize::from(id)).copied()
    }

    /// The name used in messages.
    pub fn name(self) -> &'static str {
        ["0.5mm", "1mm", "5mm", "20mm"][self as usize]
    }

    /// Guaranteed largest error of a channel of `group`: metres for displacement and height, m/s for velocity, else of
    /// the number itself.
    pub fn max_error(self, group: Group) -> f32 {
        let row: [f32; 4] = match group {
            Group::Displacement | Group::Height => [0.0005, 0.001, 0.005, 0.02],
            Group::Slopes
            | Group::Derivatives
            | Group::Velocity
            | Group::Jacobian
            | Group::Stretch
            | Group::Normals => [0.001, 0.002, 0.005, 0.02],
            Group::Foam => [0.002, 0.004, 0.01, 0.04],
        };
        row[self as usize]
    }
}

/// How samples are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Codec {
    /// Planes of 16-bit counts, each frame by itself.
    #[default]
    I16,
    /// Counts, predicted from frames before, in interleaved rANS.
    Rans,
    /// Counts, predicted from frames before, in Huffman-only deflate.
    Deflate,
    /// 16-bit floats as they are, each frame by itself; the error class is without effect.
    F16,
    /// 32-bit floats as they are, each frame by itself; the error class is without effect.
    F32,
}

impl Codec {
    /// All codecs; the index is the wire's id.
    pub const ALL: [Self; 5] = [Self::I16, Self::Rans, Self::Deflate, Self::F16, Self::F32];

    /// The wire's number for this codec.
    pub fn id(self) -> u8 {
        self as u8
    }

    /// The codec with this number.
    pub fn from_id(id: u8) -> Option<Self> {
        Self::ALL.get(usize::from(id)).copied()
    }

    /// The name used in messages.
    pub fn name(self) -> &'static str {
        ["i16", "rans", "deflate", "f16", "f32"][self as usize]
    }

    /// Whether frames are predicted from frames before.
    pub fn predicts(self) -> bool {
        matches!(self, Self::Rans | Self::Deflate)
    }

    /// Whether samples are floats as they were computed, not counts of a step.
    pub fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32)
    }

    /// Whether a payload for so many samples can have this length.
    pub fn payload_is_possible(self, samples: usize, bytes: usize) -> bool {
        match self {
            Self::I16 | Self::F16 => bytes == samples * 2,
            Self::F32 => bytes == samples * 4,
            // Where every sample escapes: a symbol, its low bits and the count itself.
            Self::Rans | Self::Deflate => (1..=samples * 4 + 8192).contains(&bytes),
        }
    }
}

/// Channels that are encoded and sent together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// `dx`, `height`, `dz` in metres, choppiness included.
    Displacement,
    /// Derivatives of height along the rest position's x and z.
    Slopes,
    /// Derivatives of the horizontal displacement: `dxx`, `dzz`, `dxz`.
    Derivatives,
    /// Foam, 0 to 1.
    Foam,
    /// `height` alone, metres.
    Height,
    /// Velocity of the water particle, m/s: `velocity_x`, `velocity_y`, `velocity_z`.
    Velocity,
    /// `jacobian` and `eigenvalue` of the horizontal mapping of the cascade alone.
    Jacobian,
    /// Diagonal derivatives of the horizontal displacement: `dxx`, `dzz`.
    Stretch,
    /// Slopes of the cascade's displaced surface as seen from the world, in the scene's way: `normal_x`, `normal_z`.
    Normals,
}

impl Group {
    /// All groups; the index is the wire's id.
    pub const ALL: [Self; 9] = [
        Self::Displacement,
        Self::Slopes,
        Self::Derivatives,
        Self::Foam,
        Self::Height,
        Self::Velocity,
        Self::Jacobian,
        Self::Stretch,
        Self::Normals,
    ];

    /// The wire's number for this group.
    pub fn id(self) -> u8 {
        self as u8
    }

    /// The group with this number.
    pub fn from_id(id: u8) -> Option<Self> {
        Self::ALL.get(usize::from(id)).copied()
    }

    /// The name used in messages.
    pub fn name(self) -> &'static str {
        ["displacement", "slopes", "derivatives", "foam", "height", "velocity", "jacobian", "stretch", "normals"]
            [self as usize]
    }

    /// Names of the channels, in the order of their planes.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Displacement => &["dx", "height", "dz"],
            Self::Slopes => &["slope_x", "slope_z"],
            Self::Derivatives => &["dxx", "dzz", "dxz"],
            Self::Foam => &["foam"],
            Self::Height => &["height"],
            Self::Velocity => &["velocity_x", "velocity_y", "velocity_z"],
            Self::Jacobian => &["jacobian", "eigenvalue"],
            Self::Stretch => &["dxx", "dzz"],
            Self::Normals => &["normal_x", "normal_z"],
        }
    }
}
