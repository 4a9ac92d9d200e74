//! A frame costs a client nothing but references: no allocation, and no copy of its bytes.
//!
//! All sessions run on the thread of the test, whose allocations are counted; engine and clients have threads of their
//! own.

use std::io::Read;
use std::time::Duration;

use allocation_counter::{AllocationInfo, measure};
use swellcast::server::Settings;
use tokio::runtime::Builder;

use crate::served::{Client, Served};
use crate::support::scene;

const CLIENTS: usize = 24;
const SECONDS: u64 = 3;
/// One cascade of 64 x 64: a frame of displacement has 24 KiB.
const SEA: &str = "name = \"small\"\n[wind]\nspeed_mps = 8\n[cascades]\nn = 64\npatches_m = [60]\n";

/// Allocations in so many seconds with so many clients at a rate, and frames that were sent in them.
fn counted(rate_hz: u32) -> (AllocationInfo, u64) {
    let runtime = Builder::new_current_thread().enable_all().build().unwrap();
    let served = runtime.block_on(Served::start(&scene(SEA), Settings::default()));
    let address = served.address;
    let crowd = std::thread::spawn(move || {
        let runtime = Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let client = async || {
                let mut client = Client::on(tokio::net::TcpStream::connect(address).await.unwrap()).await;
                client.subscribe(rate_hz, &["displacement"]).await;
                client.stream.into_inner()
            };
            let mut sockets = Vec::new();
            for _ in 0..CLIENTS {
                sockets.push(client().await.into_std().unwrap());
            }
            let mut waste = vec![0; 1 << 20];
            while !sockets.is_empty() {
                // A socket that has nothing says so; one that has ended is let go.
                sockets.retain_mut(|socket| !matches!(socket.read(&mut waste), Ok(0)));
                tokio::time::sleep(Duration::from_millis(2)).await;
            }
        });
    });
    let sent = || served.ocean.frames_sent();
    let wait = |until: &dyn Fn() -> bool| {
        while !until() {
            runtime.block_on(async { tokio::time::sleep(Duration::from_millis(50)).await });
        }
    };
    wait(&|| served.ocean.clients() == CLIENTS);
    let begun = sent();
    // What grows at first has grown after a second.
    wait(&|| sent() - begun > u64::from(rate_hz) * CLIENTS as u64);
    let before = sent();
    let info = measure(|| runtime.block_on(async { tokio::time::sleep(Duration::from_secs(SECONDS)).await }));
    let frames = sent() - before;
    runtime.block_on(served.stop());
    crowd.join().unwrap();
    (info, frames)
}

#[test]
fn a_frame_is_neither_copied_nor_allocated_for_a_client() {
    let (few, few_frames) = counted(15);
    let (many, many_frames) = counted(60);
    let more = many_frames - few_frames;
    assert!(more > 2000, "{few_frames} and {many_frames} frames");
    // Once a second there are news; frames add nothing to those but the counter of their references, one a frame for
    // all clients together.
    let made = more as f64 / CLIENTS as f64;
    let each = (many.count_total as f64 - few.count_total as f64 - made) / more as f64;
    assert!(each < 0.005, "{each} allocations for each of {more} frames more: {few:?}, {many:?}");
    let bytes = (many.bytes_total as f64 - few.bytes_total as f64) / more as f64;
    assert!(bytes < 8.0, "{bytes} bytes for each of {more} frames more of 24 KiB: {few:?}, {many:?}");
    // A copy would need room for at least one frame of each client.
    assert!(many.bytes_max < (CLIENTS * 24 * 1024) as u64, "{many:?}");
}
