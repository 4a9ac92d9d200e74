//! LERC, each channel a blob of its own.

use std::ffi::{c_int, c_uint, c_void};

use crate::{CHANNELS, N, Peer};

#[link(name = "Lerc")]
unsafe extern "C" {
    fn lerc_encode(
        samples: *const c_void,
        kind: c_uint,
        depth: c_int,
        columns: c_int,
        rows: c_int,
        bands: c_int,
        masks: c_int,
        valid: *const u8,
        max_error: f64,
        blob: *mut u8,
        room: c_uint,
        written: *mut c_uint,
    ) -> c_uint;
    fn lerc_decode(
        blob: *const u8,
        bytes: c_uint,
        masks: c_int,
        valid: *mut u8,
        depth: c_int,
        columns: c_int,
        rows: c_int,
        bands: c_int,
        kind: c_uint,
        samples: *mut c_void,
    ) -> c_uint;
}

/// Its number of f32.
const FLOAT: c_uint = 6;
/// Room of a blob: it is never much more than the samples themselves.
const ROOM: usize = 8 * N * N;

struct Blob {
    max_error: f64,
    bytes: Vec<u8>,
    used: c_uint,
}

/// All channels, each with its largest error.
pub struct Lerc(Vec<Blob>);

impl Lerc {
    pub fn new(bounds: [f32; CHANNELS]) -> Self {
        Self(bounds.map(|bound| Blob { max_error: bound.into(), bytes: vec![0; ROOM], used: 0 }).into())
    }
}

impl Peer for Lerc {
    fn encode(&mut self, channels: &[Vec<f32>]) -> usize {
        let side = N as c_int;
        for (blob, channel) in self.0.iter_mut().zip(channels) {
            assert_eq!(channel.len(), N * N);
            // SAFETY: the samples are N x N, the blob is as long as is said; no mask: all samples are valid.
            let status = unsafe {
                let (from, to) = (channel.as_ptr().cast(), blob.bytes.as_mut_ptr());
                let valid = std::ptr::null();
                let room = blob.bytes.len() as c_uint;
                lerc_encode(from, FLOAT, 1, side, side, 1, 0, valid, blob.max_error, to, room, &mut blob.used)
            };
            assert_eq!(status, 0);
        }
        self.0.iter().map(|blob| blob.used as usize).sum()
    }

    fn decode(&mut self, channels: &mut [Vec<f32>]) {
        let side = N as c_int;
        for (blob, channel) in self.0.iter().zip(channels) {
            assert_eq!(channel.len(), N * N);
            // SAFETY: the blob holds what `encode` wrote; the samples are N x N.
            let status = unsafe {
                let (from, to) = (blob.bytes.as_ptr(), channel.as_mut_ptr().cast());
                lerc_decode(from, blob.used, 0, std::ptr::null_mut(), 1, side, side, 1, FLOAT, to)
            };
            assert_eq!(status, 0);
        }
    }
}
