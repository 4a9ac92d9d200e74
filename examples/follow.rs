//! A thin client: follows the displacement of one cascade and prints, frame by frame, how high its waves are.
//!
//! `cargo run --release --example follow -- ws://127.0.0.1:8080/v1/stream 10` (address of the stream, seconds)
#![allow(clippy::disallowed_methods, reason = "a client has a clock of its own")]

use std::time::{Duration, Instant};

use swellcast::client::{Connection, Event};
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let url = arguments.next().unwrap_or_else(|| "ws://127.0.0.1:8080/v1/stream".to_owned());
    let seconds = arguments.next().map_or(Ok(10.0), |seconds| seconds.parse())?;
    // The client reads no clock of its own: any that runs evenly will do.
    let begun = Instant::now();
    let mut connection = Connection::open(&url, move || begun.elapsed().as_micros() as i64).await?;
    while begun.elapsed() < Duration::from_secs_f64(seconds) {
        match connection.next().await {
            Event::Hello(hello) => {
                println!("{} with {} cascades", hello.scene, hello.layout.cascades.len());
                let (cascade, class) = (hello.layout.cascades[0].index, ErrorClass::FiveMillimetres);
                let unit = UnitName { cascade, level: 0, class, group: Group::Displacement, codec: Codec::Rans };
                connection.subscribe(15, vec![unit], false).await;
            }
            // A busy server may send coarser frames than were asked for.
            Event::Frame(frame, _) if frame.header.level == 0 => {
                // dx, height and dz, `[z][x]`, in metres; 4 standard deviations are the significant wave height.
                let heights = &frame.planes[1];
                let mean_square = heights.iter().map(|h| h * h).sum::<f32>() / heights.len() as f32;
                let counts = frame.planes.iter().flatten().map(|value| (value / frame.header.step[0]).round() as i16);
                let digest = crc32fast::hash(&counts.flat_map(i16::to_le_bytes).collect::<Vec<u8>>());
                let hs_m = 4.0 * mean_square.sqrt();
                println!("{{\"tick\":{},\"digest\":\"{digest:08x}\",\"hs_m\":{hs_m:.3}}}", frame.header.tick);
            }
            Event::Closed(closed) => return Err(closed.into()),
            _ => {}
        }
    }
    connection.close_politely().await;
    Ok(())
}
