//! What the server counts, in Prometheus' text form.

use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::latency::Latency;
use super::ocean::Ocean;
use super::process::Usage;

/// Counts of the server; the engine keeps its own.
#[derive(Debug, Default)]
pub struct Metrics {
    frames_sent: AtomicU64,
    bytes_sent: AtomicU64,
    jumps: AtomicU64,
    quality_changes: AtomicU64,
    refused_connections: AtomicU64,
    probes: AtomicU64,
    probe_points: AtomicU64,
    probe_transforms: AtomicU64,
    probe_us: AtomicU64,
    /// From a batch that is ready to its last byte with the system, client by client.
    pub sending: Latency,
}

impl Metrics {
    /// Frames went out to a client.
    pub fn sent(&self, frames: u64, bytes: u64) {
        self.frames_sent.fetch_add(frames, Relaxed);
        self.bytes_sent.fetch_add(bytes, Relaxed);
    }

    /// Frames so far.
    pub fn frames_sent(&self) -> u64 {
        self.frames_sent.load(Relaxed)
    }

    /// Bytes of frames so far.
    pub fn bytes_sent(&self) -> u64 {
        self.bytes_sent.load(Relaxed)
    }

    /// A client was behind and was moved to the newest frames.
    pub fn jumped(&self) {
        self.jumps.fetch_add(1, Relaxed);
    }

    /// A client is sent more, or less, than before.
    pub fn changed_quality(&self) {
        self.quality_changes.fetch_add(1, Relaxed);
    }

    /// Points were probed.
    pub fn probed(&self, points: u64, transforms: u64, us: u64) {
        self.probes.fetch_add(1, Relaxed);
        self.probe_points.fetch_add(points, Relaxed);
        self.probe_transforms.fetch_add(transforms, Relaxed);
        self.probe_us.fetch_add(us, Relaxed);
    }

    /// A connection or client was refused for want of room.
    pub fn refused(&self) {
        self.refused_connections.fetch_add(1, Relaxed);
    }
}

/// The page of `/metrics`.
pub fn page(ocean: &Ocean) -> String {
    let (engine, counts) = (ocean.counters(), &ocean.metrics);
    let (tick, sequence) = (ocean.tick(), ocean.current().sequence);
    let mut page = String::with_capacity(16384);
    let mut put = |name: &str, kind: &str, help: &str, labels: &str, value: f64| {
        // Writing to a string can't fail.
        let _ = writeln!(page, "# HELP {name} {help}\n# TYPE {name} {kind}\n{name}{labels} {value}");
    };
    // Names that every program has.
    if let Some(Usage { cpu_seconds, resident_bytes }) = Usage::own() {
        put("process_cpu_seconds_total", "counter", "Processor used, user and system.", "", cpu_seconds);
        put("process_resident_memory_bytes", "gauge", "Memory in use.", "", resident_bytes as f64);
    }
    let mut put = |name: &str, kind: &str, help: &str, labels: &str, value: f64| {
        put(&format!("swellcast_{name}"), kind, help, labels, value);
    };
    let build = format!("{{version=\"{}\",backend=\"{}\"}}", env!("CARGO_PKG_VERSION"), engine.backend);
    let count = |n: &AtomicU64| n.load(Relaxed) as f64;
    put("build_info", "gauge", "Version and backend.", &build, 1.0);
    put("clients", "gauge", "Stream clients.", "", ocean.clients() as f64);
    put("connections", "gauge", "Connections of any kind.", "", ocean.seats.taken() as f64);
    put("connections_refused_total", "counter", "Refused for want of room.", "", count(&counts.refused_connections));
    put("frames_sent_total", "counter", "Frames handed to clients' sockets.", "", count(&counts.frames_sent));
    put("frame_bytes_sent_total", "counter", "Bytes of those frames.", "", count(&counts.bytes_sent));
    put("client_jumps_total", "counter", "Clients moved to the newest frames.", "", count(&counts.jumps));
    let help = "Times that a client was given fewer or coarser frames, or more again.";
    put("quality_changes_total", "counter", help, "", count(&counts.quality_changes));
    put("squeeze", "gauge", "Rungs of quality that nobody gets, for the budget.", "", ocean.egress.squeeze() as f64);
    let (status, timeline) = (ocean.status(), ocean.current().timeline);
    put("hs_metres", "gauge", "Significant wave height of the modes.", "", status.hs_m);
    let wanted = timeline.wanted_hs_at(status.tick);
    put("wanted_hs_metres", "gauge", "The same of the spectrum asked for, resolved or not.", "", wanted);
    put("ring_bytes", "gauge", "Bytes of frames held for clients.", "", ocean.ring.bytes() as f64);
    put("live_units", "gauge", "Units wanted now.", "", ocean.demand().len() as f64);
    put("live_points", "gauge", "Points that clients follow.", "", ocean.points.live() as f64);
    put("engine_alive", "gauge", "1 while the engine's thread lives.", "", f64::from(u8::from(ocean.is_ready())));
    put("steps_total", "counter", "Ticks made.", "", engine.steps as f64);
    put("transforms_total", "counter", "Real fields transformed.", "", engine.work.transforms as f64);
    put("transformed_samples_total", "counter", "Samples of those fields.", "", engine.work.samples as f64);
    put("step_seconds_total", "counter", "Seconds spent in steps.", "", engine.step_seconds);
    put("step_seconds", "gauge", "Seconds the last step took.", "", engine.step_ms / 1e3);
    let seen = ocean.budget.pace.seen(i64::MIN);
    put("step_seconds_p95", "gauge", "95 of 100 of the newest steps took no longer.", "", seen.p95_ms / 1e3);
    put("frames_skipped_total", "counter", "Ticks passed over, too slow.", "", engine.skipped_frames as f64);
    put(
        "frames_refused_total",
        "counter",
        "Frames, and messages of points, with a value not finite.",
        "",
        engine.refused_frames as f64,
    );
    put("backend_errors_total", "counter", "Errors of the backend.", "", engine.backend_errors as f64);
    put("backend_changes_total", "counter", "Another backend took over.", "", engine.backend_changes as f64);
    put("backend_losses_total", "counter", "Backends that were lost.", "", engine.backend_losses as f64);
    let gpu = f64::from(u8::from(engine.backend == "gpu"));
    put("gpu_computes", "gauge", "1 while the GPU computes.", "", gpu);
    put("probes_total", "counter", "Requests of points that were answered.", "", count(&counts.probes));
    put("probe_points_total", "counter", "Points of those.", "", count(&counts.probe_points));
    put("probe_transforms_total", "counter", "Transforms made for them.", "", count(&counts.probe_transforms));
    put("probe_seconds_total", "counter", "Seconds spent on them.", "", count(&counts.probe_us) / 1e6);
    put("foam_warm", "gauge", "1 when foam is whole.", "", f64::from(u8::from(engine.foam_warm)));
    put("log_sequence", "gauge", "Newest entry of the control log.", "", sequence as f64);
    put("tick", "gauge", "Ticks since the sea began.", "", tick as f64);
    let help = "From frames that are ready to their last byte with the system, client by client.";
    counts.sending.write("swellcast_sending_seconds", help, &mut page);
    page
}
