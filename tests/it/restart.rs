//! The program itself: killed with -9 and started again on its folder, it goes on with the same sea.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

use bytes::Bytes;
use serde_json::json;
use swellcast::backend::Cpu;
use swellcast::control::Store;
use swellcast::engine::Stepper;
use swellcast::plan::Demand;
use swellcast::sea::Timeline;
use swellcast::tile::SentFrame;
use swellcast::wire::{Codec, ErrorClass, Group, UnitName};
use tokio::net::TcpStream;

use crate::served::{Client, header};

const SCENE: &str =
    "name = \"bay\"\n[wind]\nspeed_mps = 12\nrange_mps = [2.0, 20.0]\n[cascades]\nn = 64\npatches_m = [200]\n";
const GROUPS: [&str; 4] = ["displacement", "slopes", "derivatives", "foam"];
type Frames = BTreeMap<(u64, u8), Bytes>;

/// The program on a folder; killed when it is dropped.
struct Program {
    process: Child,
    address: SocketAddr,
}

impl Program {
    fn serve(scene: &Path, data: &Path) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_swellcast"))
            .args(["serve", "--listen", "127.0.0.1:0", "--scene"])
            .arg(scene)
            .arg("--data")
            .arg(data)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.split_once("http://").and_then(|(_, rest)| rest.trim().trim_end_matches('/').parse().ok());
        Self { address: address.unwrap_or_else(|| panic!("no address in {line:?}")), process }
    }

    async fn client(&self) -> Client {
        Client::on(TcpStream::connect(self.address).await.unwrap()).await
    }

    /// SIGKILL.
    fn kill(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may be dead already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Frames of all groups until `foam` of them are foam.
async fn watch(client: &mut Client, foam: usize) -> Frames {
    client.text("hello").await;
    client.subscribe(30, &GROUPS).await;
    let mut frames = Frames::new();
    while frames.keys().filter(|(_, group)| *group == Group::Foam.id()).count() < foam {
        let frame = client.frame().await;
        let header = header(&frame);
        frames.insert((header.tick, header.group), frame);
    }
    frames
}

/// The same ticks, computed here from what the log says.
fn recompute(data: &Path, frames: &Frames) {
    let begun = Store::open(data).unwrap().begun().unwrap().unwrap();
    let timeline = Timeline::replay(&begun.scene, &begun.changes, 0);
    let unit = |group| UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group, codec: Codec::I16 };
    let demand: Demand = Group::ALL.map(|group| (unit(group), 240)).into();
    let mut stepper = Stepper::new(Box::new(Cpu::new(Some(1))), Arc::new(timeline), begun.epoch.id);
    stepper.set_demand(&demand);
    let mut ticks: Vec<u64> = frames.keys().map(|(tick, _)| *tick).collect();
    ticks.dedup();
    let mut compared = 0;
    for tick in ticks {
        while stepper.warm_foam(tick as i64).unwrap() {}
        for SentFrame { unit, bytes: here, .. } in stepper.frames(tick as i64, &demand).unwrap().frames {
            if let Some(there) = frames.get(&(tick, unit.group.id())) {
                assert!(here == there, "{} differs at tick {tick}", unit.group.name());
                compared += 1;
            }
        }
    }
    assert_eq!(compared, frames.len(), "every frame that was streamed was compared");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn killed_and_started_again_it_streams_the_same_sea_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, data) = (folder.path().join("bay.toml"), folder.path().join("data"));
    std::fs::write(&scene, SCENE).unwrap();

    let mut first = Program::serve(&scene, &data);
    let mut client = first.client().await;
    let hello = client.text("hello").await;
    let before = watch(&mut first.client().await, 3).await;
    let body = json!({ "speed_mps": 16, "direction_from_deg": 200, "transition_s": 3 }).to_string();
    let request = format!(
        "PUT /v1/scenes/bay/wind HTTP/1.1\r\nhost: x\r\nconnection: close\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    );
    let answer = crate::served::raw(first.address, request.as_bytes()).await;
    assert!(answer.starts_with("HTTP/1.1 202"), "{answer}");
    // Killed as soon as the change is acknowledged.
    first.kill();

    let mut again = Program::serve(&scene, &data);
    let mut client = again.client().await;
    let hello_again = client.text("hello").await;
    assert_eq!(hello["epoch"], hello_again["epoch"]);
    assert_eq!(hello_again["sequence"], 1);
    assert!(hello_again["tick"].as_i64() > hello["tick"].as_i64(), "time goes on");
    let after = watch(&mut again.client().await, 6).await;
    assert!(after.values().any(|frame| header(frame).sequence == 1), "the change is in force");
    again.kill();

    recompute(&data, &before);
    recompute(&data, &after);
}
