//! A thin client: follows the displacement of one cascade and prints, frame by frame, how high its waves are.
//!
//! `target/release/examples/follow ws://127.0.0.1:8080/v1/stream 10` (address of the stream, seconds), after
//! `cargo build --release --bin swellcast --examples`
#![allow(clippy::disallowed_methods, reason = "a client has a clock of its own")]

use std::time::{Duration, Instant};

use swellcast::client::{Connection, Event};
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

/// How long to wait before connecting again: at first, and at most.
const WAITS: [Duration; 2] = [Duration::from_millis(250), Duration::from_secs(3)];

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let url = arguments.next().unwrap_or_else(|| "ws://127.0.0.1:8080/v1/stream".to_owned());
    let seconds = arguments.next().map_or(Ok(10.0), |seconds| seconds.parse())?;
    // The client reads no clock of its own: any that runs evenly will do.
    let begun = Instant::now();
    let now_us = move || begun.elapsed().as_micros() as i64;
    let (mut connection, mut wait) = (Connection::open(&url, now_us).await?, WAITS[0]);
    while begun.elapsed() < Duration::from_secs_f64(seconds) {
        match connection.next().await {
            Event::Hello(hello) => {
                println!("{} with {} cascades", hello.scene, hello.layout.cascades.len());
                // What is printed is as good late: the server need not know how this client fares, and send it less.
                connection.stop_reports();
                let (cascade, class) = (hello.layout.cascades[0].index, ErrorClass::FiveMillimetres);
                let unit = UnitName { cascade, level: 0, class, group: Group::Displacement, codec: Codec::Rans };
                connection.subscribe(15, vec![unit], false).await;
            }
            // A busy server may send coarser frames than were asked for.
            Event::Frame(frame, _) if frame.header.level == 0 => {
                wait = WAITS[0];
                // dx, height and dz, `[z][x]`, in metres; 4 standard deviations are the significant wave height.
                let heights = &frame.planes[1];
                let mean_square = heights.iter().map(|h| h * h).sum::<f32>() / heights.len() as f32;
                let counts = frame.planes.iter().flatten().map(|value| (value / frame.header.step[0]).round() as i16);
                let digest = crc32fast::hash(&counts.flat_map(i16::to_le_bytes).collect::<Vec<u8>>());
                let hs_m = 4.0 * mean_square.sqrt();
                println!("{{\"tick\":{},\"digest\":\"{digest:08x}\",\"hs_m\":{hs_m:.3}}}", frame.header.tick);
            }
            // It is told again until there is another connection. Whose sea that is, its hello says.
            Event::Closed(closed) => {
                eprintln!("{closed}; again in {wait:?}");
                tokio::time::sleep(wait).await;
                wait = WAITS[1].min(2 * wait);
                if let Ok(again) = Connection::open(&url, now_us).await {
                    connection = again;
                }
            }
            _ => {}
        }
    }
    connection.close_politely().await;
    Ok(())
}
