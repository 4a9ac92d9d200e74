//! zfp in fixed accuracy, each channel a plane of its own. No header is written: what is sent is the bare stream.

use std::ffi::{c_int, c_uint, c_void};

use crate::{CHANNELS, N, Peer, Sea, miss};

#[link(name = "zfp")]
unsafe extern "C" {
    fn stream_open(buffer: *mut c_void, bytes: usize) -> *mut c_void;
    fn stream_close(bits: *mut c_void);
    fn zfp_stream_open(bits: *mut c_void) -> *mut c_void;
    fn zfp_stream_close(stream: *mut c_void);
    fn zfp_stream_set_accuracy(stream: *mut c_void, tolerance: f64) -> f64;
    fn zfp_stream_rewind(stream: *mut c_void);
    fn zfp_field_2d(samples: *mut c_void, kind: c_int, nx: usize, ny: usize) -> *mut c_void;
    fn zfp_field_set_pointer(field: *mut c_void, samples: *mut c_void);
    fn zfp_field_free(field: *mut c_void);
    fn zfp_compress(stream: *mut c_void, field: *const c_void) -> usize;
    fn zfp_decompress(stream: *mut c_void, field: *mut c_void) -> usize;
    fn zfp_stream_maximum_size(stream: *const c_void, field: *const c_void) -> usize;
    static zfp_codec_version: c_uint;
}

/// zfp_type_float.
const FLOAT: c_int = 3;

/// One channel's stream, over a buffer of its own.
struct Stream {
    field: *mut c_void,
    stream: *mut c_void,
    bits: *mut c_void,
    // The library writes here through the pointer it was given.
    _buffer: Vec<u64>,
}

impl Stream {
    fn new(tolerance: f64) -> Self {
        // SAFETY: the buffer is as long as the library asks for with this tolerance, and lives as long as the stream;
        // a vector's memory stays where it is when the vector moves.
        unsafe {
            let field = zfp_field_2d(std::ptr::null_mut(), FLOAT, N, N);
            let stream = zfp_stream_open(std::ptr::null_mut());
            assert!(!field.is_null() && !stream.is_null());
            zfp_stream_set_accuracy(stream, tolerance);
            let mut buffer = vec![0u64; zfp_stream_maximum_size(stream, field).div_ceil(8)];
            zfp_stream_close(stream);
            let bits = stream_open(buffer.as_mut_ptr().cast(), buffer.len() * 8);
            let stream = zfp_stream_open(bits);
            assert!(!bits.is_null() && !stream.is_null());
            zfp_stream_set_accuracy(stream, tolerance);
            Self { field, stream, bits, _buffer: buffer }
        }
    }

    fn encode(&mut self, samples: &[f32]) -> usize {
        assert_eq!(samples.len(), N * N);
        // SAFETY: the samples are N x N and only read; the stream has room for the worst of them.
        let bytes = unsafe {
            zfp_field_set_pointer(self.field, samples.as_ptr().cast_mut().cast());
            zfp_stream_rewind(self.stream);
            zfp_compress(self.stream, self.field)
        };
        assert!(bytes > 0);
        bytes
    }

    fn decode(&mut self, samples: &mut [f32]) {
        assert_eq!(samples.len(), N * N);
        // SAFETY: the samples are N x N; the stream holds what `encode` wrote with the same tolerance.
        let bytes = unsafe {
            zfp_field_set_pointer(self.field, samples.as_mut_ptr().cast());
            zfp_stream_rewind(self.stream);
            zfp_decompress(self.stream, self.field)
        };
        assert!(bytes > 0);
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        // SAFETY: made by `new`, freed once.
        unsafe {
            zfp_stream_close(self.stream);
            stream_close(self.bits);
            zfp_field_free(self.field);
        }
    }
}

/// All channels, each with a tolerance.
pub struct Zfp(Vec<Stream>);

impl Zfp {
    pub fn new(tolerances: [f64; CHANNELS]) -> Self {
        // SAFETY: a constant of the library: the declarations above were read in the header of release 1.0.
        assert_eq!(unsafe { zfp_codec_version }, 5, "another zfp than these declarations are of");
        Self(tolerances.map(Stream::new).into())
    }

    /// For each channel the largest tolerance with which no sample of this sea is off by more than its bound. zfp takes
    /// powers of two alone, and errs by less than it is allowed to.
    pub fn loosest(sea: &Sea, bounds: [f32; CHANNELS]) -> [f64; CHANNELS] {
        let mut decoded = vec![0.0; N * N];
        let mut holds = |channel: usize, tolerance: f64| {
            let mut stream = Stream::new(tolerance);
            sea.values().all(|channels| {
                stream.encode(&channels[channel]);
                stream.decode(&mut decoded);
                miss(&decoded, &channels[channel]) <= bounds[channel]
            })
        };
        std::array::from_fn(|channel| {
            let told = f64::from(bounds[channel]).log2().floor().exp2();
            let steps = std::iter::successors(Some(told), |tolerance| Some(tolerance * 2.0));
            steps.take_while(|tolerance| holds(channel, *tolerance)).last().expect("zfp keeps what it is told")
        })
    }
}

impl Peer for Zfp {
    fn encode(&mut self, channels: &[Vec<f32>]) -> usize {
        self.0.iter_mut().zip(channels).map(|(stream, channel)| stream.encode(channel)).sum()
    }

    fn decode(&mut self, channels: &mut [Vec<f32>]) {
        self.0.iter_mut().zip(channels).for_each(|(stream, channel)| stream.decode(channel));
    }
}
