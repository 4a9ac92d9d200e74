//! Composes what the server says of itself: `hello` for a client that joins, `status` for all.

use crate::control::Epoch;
use crate::engine::{Counters, HEADSTART, lead_ticks};
use crate::scene::{Detail, Foam, Scene};
use crate::sea::{Cascade, Life, Timeline};
use crate::wire::{
    Group, Hello, HelloCascade, HelloDetail, HelloLayout, Limits, MAX_MESSAGE_BYTES, MAX_POINTS, RATES_HZ,
    SLOWEST_INTERVAL, Status, TICKS_PER_SECOND, WindStatus,
};

use super::settings::MAX_UNITS;

/// Name and version.
pub const SERVER: &str = concat!("swellcast/", env!("CARGO_PKG_VERSION"));

/// How far ahead of its tick a frame leaves at the latest: one lead for all rates, so that their frames go together.
pub fn lead() -> i64 {
    lead_ticks(SLOWEST_INTERVAL)
}

/// How far ahead of now frames may have been made already.
pub fn reach() -> i64 {
    lead() + HEADSTART
}

/// `hello`, for a client that joins at `tick`.
pub fn hello(timeline: &Timeline, epoch: Epoch, sequence: u64, tick: i64, live_units: usize) -> Hello {
    let scene = timeline.scene();
    Hello {
        protocol: 1,
        server: SERVER.to_owned(),
        scene: scene.name.clone(),
        epoch: epoch.to_string(),
        seed: scene.seed.to_string(),
        ticks_per_second: TICKS_PER_SECOND,
        tick,
        lead_ticks: lead(),
        sequence,
        layout: layout(timeline, tick),
        choppiness: scene.effects.choppiness,
        rates_hz: RATES_HZ.to_vec(),
        classes: Hello::all_classes(),
        groups: Hello::groups(|group| scene.effects.has(group)),
        foam_step_ticks: Foam::STEP_TICKS,
        limits: Limits {
            message_bytes: MAX_MESSAGE_BYTES as u32,
            points: MAX_POINTS as u32,
            units: MAX_UNITS as u32,
            live_units: u32::try_from(live_units).unwrap_or(u32::MAX),
        },
    }
}

/// The layout as clients are told: all cascades that are there at a tick, or will be.
pub fn layout(timeline: &Timeline, tick: i64) -> HelloLayout {
    let cascade = |Life { cascade, from_tick, until_tick, .. }: Life| HelloCascade {
        index: cascade.index,
        patch_m: cascade.patch_m,
        n: cascade.n as u32,
        levels: cascade.levels(),
        wavelength_min_m: cascade.shortest_m(),
        wavelength_max_m: cascade.longest_m(),
        from_tick: from_tick.max(0),
        until_tick,
        detail: Group::ALL.into_iter().filter_map(|group| detail(timeline.scene(), &cascade, group)).collect(),
    };
    let cascades = timeline.lives().filter(|life| !life.is_over(tick)).map(cascade).collect();
    HelloLayout { generation: timeline.layout().generation, cascades }
}

fn detail(scene: &Scene, cascade: &Cascade, group: Group) -> Option<HelloDetail> {
    let Detail { finest_level, rate_hz, .. } = scene.detail_of(cascade.index, cascade.levels(), group)?;
    Some(HelloDetail { group, finest_level, rate_hz })
}

/// `status` at a tick. Sums the energies of all modes: call it off the async threads.
pub fn status(timeline: &Timeline, counters: &Counters, tick: i64, clients: usize) -> Status {
    let Scene { sea, wind_range_mps, .. } = timeline.scene_at(tick);
    Status {
        tick,
        sequence: timeline.sequence_at(tick),
        hs_m: timeline.hs_at(tick),
        wind: sea
            .wind
            .map(|wind| WindStatus { speed_mps: wind.speed_mps, direction_from_deg: wind.direction_from_deg }),
        wind_range_mps: *wind_range_mps,
        depth_m: Some(sea.water.depth_m).filter(|depth| depth.is_finite()),
        clients: u32::try_from(clients).unwrap_or(u32::MAX),
        backend: counters.backend.to_owned(),
        step_ms: counters.step_ms,
        skipped_frames: counters.skipped_frames,
    }
}
