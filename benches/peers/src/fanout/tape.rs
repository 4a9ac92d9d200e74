//! A recording of frames of one length: two seconds that repeat.

use std::path::Path;

use anyhow::{Context, Result};
use swellcast::control::{Epoch, Store};
use swellcast::engine::Clock;
use swellcast::recording::{Preface, RecordingWriter, Taken};
use swellcast::scene::SceneFile;
use swellcast::server::{Ocean, Settings};
use swellcast::wire::{
    Codec, ErrorClass, FLAG_KEY, FrameHeader, Group, HEADER_BYTES, MAGIC, SLOWEST_INTERVAL, TICKS_PER_SECOND, UnitName,
    lead_of,
};

const SCENE: &str = "name = \"tape\"\nloop_s = 2\n[wind]\nspeed_mps = 8\n[cascades]\nn = 256\npatches_m = [250]\n";
/// As many seconds as the scene repeats after, and those that a round needs besides.
const SECONDS: i64 = 5;

/// The unit that is recorded.
pub const UNIT: UnitName =
    UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group: Group::Displacement, codec: Codec::Rans };

/// Writes key frames of `bytes` each, 15 a second. Their payload is noise: nothing here decodes it.
pub fn write(path: &Path, bytes: usize) -> Result<()> {
    let scene = SceneFile::from_toml(SCENE)?.check(None)?;
    let store = Store::in_memory()?;
    let begun = store.begin(&scene, Epoch::begin(Clock::unix_now_ns()))?;
    let hello = Ocean::start(store, begun, Settings::default()).hello();
    let epoch = u64::from_str_radix(&hello.epoch, 16).context("an epoch")?;
    let taken = Taken { rate_hz: 15, units: vec![UNIT.into()] };
    let scene = serde_json::to_value(SceneFile::from(&scene))?;
    let lead = hello.lead_ticks;
    let preface = Preface { hello, scene, changes: Vec::new(), taken };
    let mut writer = RecordingWriter::create(path, &preface)?;
    let mut frame: Vec<u8> = (0..bytes as u32).map(|at| (at.wrapping_mul(0x9e37_79b9) >> 24) as u8).collect();
    for tick in (TICKS_PER_SECOND..(1 + SECONDS) * TICKS_PER_SECOND).step_by(SLOWEST_INTERVAL as usize) {
        header(tick as u64, epoch, bytes).seal(&mut frame);
        writer.frame(tick - lead_of(tick, SLOWEST_INTERVAL, UNIT.codec, lead), &frame)?;
    }
    writer.finish()?;
    Ok(())
}

fn header(tick: u64, epoch: u64, bytes: usize) -> FrameHeader {
    FrameHeader {
        magic: MAGIC,
        header_bytes: HEADER_BYTES as u16,
        cascade: UNIT.cascade,
        level: UNIT.level,
        class: UNIT.class.id(),
        group: UNIT.group.id(),
        codec: UNIT.codec.id(),
        flags: FLAG_KEY,
        n: 256,
        level_n: 256,
        tile_x: 0,
        tile_z: 0,
        channels: 3,
        depth: 0,
        zero_a: 0,
        tick,
        epoch,
        sequence: 0,
        layout: 0,
        payload_bytes: (bytes - HEADER_BYTES) as u32,
        step: [0.002; 3],
        max_error: [0.001; 3],
        crc: 0,
        zero_b: 0,
    }
}
