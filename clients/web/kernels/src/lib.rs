//! What takes the web client's time, in WebAssembly: coded planes back to counts, by the server's own decoder, and
//! frames joined in time.
//!
//! JavaScript writes and reads what is held here at the addresses it is told; nothing here reads from an address. It
//! names what it holds by numbers: who takes one gives it back.

#[path = "../../../../src/tile/predict.rs"]
#[expect(dead_code, reason = "the encoder's part")]
mod predict;
#[path = "../../../../src/tile/rans.rs"]
#[expect(dead_code, reason = "the encoder's part")]
mod rans;
#[path = "../../../../src/tile/residual.rs"]
#[expect(dead_code, reason = "the encoder's part")]
mod residual;
mod slabs;

/// What the modules above take from the library.
mod wire {
    pub const TILE: usize = 256;
    pub const BETWEEN: u8 = 4;
}

use std::cell::RefCell;

use predict::Basis;
use rans::{Damaged, PlaneDecoder, read_taps};
use slabs::Slabs;
use wire::BETWEEN;

#[derive(Default)]
struct Kernels {
    message: Vec<u8>,
    counts: Slabs<i16>,
    values: Slabs<f32>,
    decoder: PlaneDecoder,
    fault: &'static str,
}

thread_local! {
    static KERNELS: RefCell<Kernels> = RefCell::default();
}

/// Makes room for a message, and says where.
#[unsafe(no_mangle)]
pub extern "C" fn message(bytes: usize) -> *const u8 {
    KERNELS.with_borrow_mut(|kernels| {
        kernels.message.resize(bytes, 0);
        kernels.message.as_ptr()
    })
}

/// Takes so many counts, and says what they are called.
#[unsafe(no_mangle)]
pub extern "C" fn take_counts(len: usize) -> usize {
    KERNELS.with_borrow_mut(|kernels| kernels.counts.take(len))
}

/// Where they lie.
#[unsafe(no_mangle)]
pub extern "C" fn counts_at(name: usize) -> *const i16 {
    KERNELS.with_borrow(|kernels| kernels.counts.get(name).as_ptr())
}

/// Gives them back.
#[unsafe(no_mangle)]
pub extern "C" fn give_counts(name: usize) {
    KERNELS.with_borrow_mut(|kernels| kernels.counts.give(name));
}

/// Takes so many values, and says what they are called.
#[unsafe(no_mangle)]
pub extern "C" fn take_values(len: usize) -> usize {
    KERNELS.with_borrow_mut(|kernels| kernels.values.take(len))
}

/// Where they lie.
#[unsafe(no_mangle)]
pub extern "C" fn values_at(name: usize) -> *const f32 {
    KERNELS.with_borrow(|kernels| kernels.values.get(name).as_ptr())
}

/// Gives them back.
#[unsafe(no_mangle)]
pub extern "C" fn give_values(name: usize) {
    KERNELS.with_borrow_mut(|kernels| kernels.values.give(name));
}

/// Reads a plane of n x n counts, channel `channel` of what is called `out`, from its taps on, which lie at `at` of the
/// message (PROTOCOL.md section 10, codec 1).
///
/// `a`, `b` and `c` are the frames it is predicted from, as many as `depth` asks for. Returns how many bytes it took, or
/// -1: `fault` says why, and what `out` then holds is of no use.
#[unsafe(no_mangle)]
pub extern "C" fn read_plane(
    at: usize,
    depth: u8,
    channel: usize,
    n: usize,
    out: usize,
    a: usize,
    b: usize,
    c: usize,
) -> i32 {
    KERNELS.with_borrow_mut(|kernels| {
        // Away from the others while it is written.
        let mut written = std::mem::take(kernels.counts.get_mut(out));
        let Kernels { message, counts, decoder, .. } = kernels;
        let samples = n * n;
        let plane = |name: usize| &counts.get(name)[channel * samples..][..samples];
        let past = |count: u8| {
            let mut frames = [&[][..]; 3];
            frames.iter_mut().zip([a, b, c]).take(count.into()).for_each(|(frame, name)| *frame = plane(name));
            Basis::Past(frames)
        };
        let basis = match depth {
            0 => Basis::Space,
            BETWEEN => Basis::Between(plane(a), plane(b)),
            _ => past(depth),
        };
        let taken = read(&message[at..], decoder, basis, n, &mut written[channel * samples..][..samples]);
        *kernels.counts.get_mut(out) = written;
        taken.unwrap_or_else(|Damaged(fault)| {
            kernels.fault = fault;
            -1
        })
    })
}

fn read(bytes: &[u8], decoder: &mut PlaneDecoder, basis: Basis, n: usize, out: &mut [i16]) -> Result<i32, Damaged> {
    let mut left = bytes;
    let (taps, wide) = read_taps(&mut left)?;
    if wide {
        return Err(Damaged("wide, which only deflate is"));
    }
    Ok((bytes.len() - left.len() + decoder.decode(left, basis, taps, n, out)?) as i32)
}

/// Where the reason for the last -1 lies: UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn fault_at() -> *const u8 {
    KERNELS.with_borrow(|kernels| kernels.fault.as_ptr())
}

/// Bytes of it.
#[unsafe(no_mangle)]
pub extern "C" fn fault_bytes() -> usize {
    KERNELS.with_borrow(|kernels| kernels.fault.len())
}

/// Writes the weighted sum of channel `channel` of four frames, `samples` each, to the same channel of the values called
/// `out`.
#[unsafe(no_mangle)]
pub extern "C" fn join(
    out: usize,
    channel: usize,
    samples: usize,
    a: usize,
    b: usize,
    c: usize,
    d: usize,
    wa: f32,
    wb: f32,
    wc: f32,
    wd: f32,
) {
    KERNELS.with_borrow_mut(|Kernels { counts, values, .. }| {
        let (begin, end) = (channel * samples, (channel + 1) * samples);
        let [a, b, c, d] = [a, b, c, d].map(|name| &counts.get(name)[begin..end]);
        // Slices of one length: the loop becomes vectors.
        let out = &mut values.get_mut(out)[begin..end];
        for i in 0..samples {
            let [a, b, c, d] = [a[i], b[i], c[i], d[i]].map(f32::from);
            out[i] = wa * a + wb * b + wc * c + wd * d;
        }
    });
}
