//! What `swellcast watch` counts and measures, and the two ways it says it: a line for people, a report for programs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::playback::TileKey;
use crate::tile::DecodedFrame;
use crate::wire::{Group, Hello, Status, TICKS_PER_SECOND, WindStatus};

/// Everything counted since the connection was made.
#[derive(Debug, Default)]
pub struct Stats {
    hello: Option<Hello>,
    status: Option<Status>,
    frames: u64,
    bytes: u64,
    bad: u64,
    stray: u64,
    starved: u64,
    newest_tick: Option<u64>,
    /// Mean of the heights and of their squares in the newest frame of each tile.
    heights: BTreeMap<TileKey, [f64; 2]>,
}

/// What is printed at the end with `--json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // The names carry their meaning and units.
pub struct Report {
    pub server: String,
    pub scene: String,
    pub epoch: String,
    pub backend: String,
    pub seconds: f64,
    pub tick: Option<i64>,
    pub hs_m: Option<f64>,
    pub hs_received_m: Option<f64>,
    pub wind: Option<WindStatus>,
    pub frames: u64,
    pub frames_per_second: f64,
    pub megabits_per_second: f64,
    pub newest_frame_ahead_ms: Option<f64>,
    pub clock_error_bound_ms: Option<f64>,
    pub clock_drift_ppm: f64,
    pub bad_messages: u64,
    pub stray_frames: u64,
    pub starved: u64,
    pub skipped_by_server: u64,
}

/// Server time, how far it can be off (both microseconds), and the rate of the server's clock over ours.
pub type Now = (Option<i64>, Option<i64>, f64);

impl Stats {
    /// Takes the server's first message, or a further one: cascades that it doesn't name are gone.
    pub fn hello(&mut self, hello: &Hello) {
        let named = |number: u8| hello.layout.cascades.iter().any(|cascade| cascade.index == number);
        self.heights.retain(|key, _| named(key.cascade));
        self.hello = Some(hello.clone());
    }

    /// Takes the server's own figures.
    pub fn status(&mut self, status: Status) {
        self.status = Some(status);
    }

    /// Takes a frame of `bytes`.
    pub fn frame(&mut self, tile: &DecodedFrame, bytes: usize) {
        self.frames += 1;
        self.bytes += bytes as u64;
        self.newest_tick = self.newest_tick.max(Some(tile.header.tick));
        if tile.header.group == Group::Displacement.id()
            && let Some(heights) = tile.planes.get(1)
        {
            let mean = |power: i32| {
                heights.iter().map(|h| f64::from(*h).powi(power)).sum::<f64>() / heights.len().max(1) as f64
            };
            self.heights.insert(TileKey::from(&tile.header), [mean(1), mean(2)]);
        }
    }

    /// A frame or text that could not be read.
    pub fn bad(&mut self) {
        self.bad += 1;
    }

    /// A frame that was not asked for.
    pub fn stray(&mut self) {
        self.stray += 1;
    }

    /// A moment that no frame lay on both sides of.
    pub fn starved(&mut self) {
        self.starved += 1;
    }

    /// Whether anything came.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// 4 sqrt of the variance of the received heights: cascades hold different waves, so their variances add.
    pub fn hs_received_m(&self) -> Option<f64> {
        let mut cascades = BTreeMap::<u8, (f64, [f64; 2])>::new();
        for (key, mean) in &self.heights {
            let (tiles, sums) = cascades.entry(key.cascade).or_default();
            *tiles += 1.0;
            (sums[0], sums[1]) = (sums[0] + mean[0], sums[1] + mean[1]);
        }
        let variance = |(tiles, [mean, square]): &(f64, [f64; 2])| square / tiles - (mean / tiles).powi(2);
        (!cascades.is_empty()).then(|| 4.0 * cascades.values().map(variance).sum::<f64>().max(0.0).sqrt())
    }

    /// Everything, `seconds` after the connection was made.
    pub fn report(&self, seconds: f64, (server_us, bound_us, drift): Now) -> Report {
        let status = self.status.as_ref();
        let text = |of: fn(&Hello) -> &String| self.hello.as_ref().map(of).cloned().unwrap_or_default();
        let ticks = |us: i64| us as f64 * TICKS_PER_SECOND as f64 / 1e6;
        let ahead = |us: i64| Some((self.newest_tick? as f64 - ticks(us)) * 1e3 / TICKS_PER_SECOND as f64);
        Report {
            server: text(|hello| &hello.server),
            scene: text(|hello| &hello.scene),
            epoch: text(|hello| &hello.epoch),
            backend: status.map(|s| s.backend.clone()).unwrap_or_default(),
            seconds,
            tick: server_us.map(|us| ticks(us) as i64),
            hs_m: status.map(|s| s.hs_m),
            hs_received_m: self.hs_received_m(),
            wind: status.and_then(|s| s.wind),
            frames: self.frames,
            frames_per_second: self.frames as f64 / seconds.max(1e-3),
            megabits_per_second: self.bytes as f64 * 8e-6 / seconds.max(1e-3),
            newest_frame_ahead_ms: server_us.and_then(ahead),
            clock_error_bound_ms: bound_us.map(|us| us as f64 / 1e3),
            clock_drift_ppm: drift * 1e6,
            bad_messages: self.bad,
            stray_frames: self.stray,
            starved: self.starved,
            skipped_by_server: status.map_or(0, |s| s.skipped_frames),
        }
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let number = |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
        write!(f, "{}: Hs {} m", self.scene, number(self.hs_m, 2))?;
        write!(f, " (received {} m)", number(self.hs_received_m, 2))?;
        if let Some(wind) = self.wind {
            write!(f, ", wind {:.1} m/s from {:.0}°", wind.speed_mps, wind.direction_from_deg)?;
        }
        write!(f, ", tick {}", self.tick.map_or("-".to_owned(), |tick| tick.to_string()))?;
        write!(f, ", clock ±{} ms", number(self.clock_error_bound_ms, 2))?;
        write!(f, ", frames {} ms ahead", number(self.newest_frame_ahead_ms, 0))?;
        write!(f, ", {:.0} frames/s, {:.1} Mb/s", self.frames_per_second, self.megabits_per_second)?;
        for (count, what) in [(self.bad_messages, "bad"), (self.stray_frames, "stray"), (self.starved, "starved")] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        Ok(())
    }
}
