//! What a load test found, as figures, and whether the server held.

use serde::Serialize;

use super::buckets::Shares;
use super::churn::Churned;
use super::crowd::{Crowd, Sample};
use super::figures::{Histogram, Percentiles, Row};
use super::growth::growth;
use super::sight::{Faults, Outcome};
use super::stage::Stage;
use super::viewer::Manner;
use super::wind::WindChanges;

const MIB: f64 = 1048576.0;

/// Everything found.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct Report {
    pub url: String,
    pub server: String,
    pub scene: String,
    /// Length of the measured window.
    pub seconds: f64,
    pub tolerated_share: f64,
    /// It held: all came and stayed, nothing was wrong, and no more was late or missing than is tolerated.
    pub holds: bool,
    /// Why not.
    pub why: Vec<String>,
    pub clock_error_bound_ms: Option<f64>,
    pub load: Findings,
    pub calibration: Option<Calibration>,
}

/// The same crowd at the calibrator.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct Calibration {
    pub findings: Findings,
    /// Bytes per server CPU second over the calibrator's.
    pub ratio: Option<f64>,
    /// The same, of both without what the first client of each demand alone costs: the sea, and making the frames.
    pub fan_out_ratio: Option<f64>,
}

/// What one crowd found.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct Findings {
    pub seconds: f64,
    pub steady: Group,
    pub slow: Option<Group>,
    pub stalled: Option<Stalled>,
    pub churned: Option<Churned>,
    pub wind: Option<WindChanges>,
    pub decoded: u64,
    pub received_mbps: f64,
    pub round_trip_ms: Option<Percentiles>,
    pub server: ServerCost,
    /// Cores that the load test itself used.
    pub own_cpu: Option<f64>,
    /// Cores of this machine that were busy, whoever with.
    pub machine_cpu: Option<f64>,
    pub machine_cores: usize,
    pub rows: Vec<ReportRow>,
    /// (age in milliseconds, share of frames at most that old).
    pub age_shares: Vec<(f64, f64)>,
    /// Steady clients' Mb/s, lowest first.
    pub client_mbps: Vec<f64>,
    /// Seconds of the first row of the window.
    pub window_from_s: f64,
}

/// Clients of one manner.
#[derive(Clone, Debug, Default, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct Group {
    pub clients: usize,
    /// Granted a subscription, and there to the end.
    pub stayed: usize,
    /// Why others were not, and how many.
    pub ended: Vec<(String, usize)>,
    pub frames: u64,
    pub bytes: u64,
    pub mbps: f64,
    pub client_mbps_median: f64,
    pub age_ms: Option<Percentiles>,
    pub late: u64,
    pub late_share: f64,
    pub coarser: u64,
    pub coarser_share: f64,
    pub gaps: u64,
    pub gap_share: f64,
    pub faults: Faults,
}

/// Clients that stalled.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct Stalled {
    pub clients: usize,
    pub woke: usize,
    pub live_again: usize,
    pub live_again_ms: Option<Percentiles>,
    pub faults: Faults,
}

/// What the server says it cost.
#[derive(Clone, Debug, Default, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct ServerCost {
    /// Cores.
    pub cpu: Option<f64>,
    /// Cores with the first client of each demand alone.
    pub base_cpu: Option<f64>,
    pub resident_mib: Option<f64>,
    /// From the median of the window's second quarter to that of its last.
    pub growth_mib: Option<f64>,
    pub clients: Option<f64>,
    /// From frames that are ready to their last byte with the system.
    pub sending_ms: Option<Shares>,
    pub jumps: Option<f64>,
    pub skipped_ticks: Option<f64>,
    /// Of the ticks that were due.
    pub skipped_share: Option<f64>,
    pub bytes_per_cpu_second: Option<f64>,
    pub fan_out_bytes_per_cpu_second: Option<f64>,
}

/// One row over time.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // docs/load.md says what each figure means.
pub struct ReportRow {
    pub at_s: f64,
    pub mbps: f64,
    pub late: u64,
    pub age_p50_ms: Option<f64>,
    pub age_p99_ms: Option<f64>,
    pub server_cpu: Option<f64>,
    pub server_mib: Option<f64>,
    pub own_cpu: Option<f64>,
    pub machine_cpu: Option<f64>,
}

impl Findings {
    /// Sums up a crowd of `wanted` steady clients.
    pub fn of(crowd: &Crowd, stage: &Stage, wanted: usize) -> Self {
        let (first, end) = crowd.window;
        let row_s = stage.ledger.row_s();
        let seconds = (end - first) as f64 * row_s;
        let rows = crowd.rows.get(first as usize..).unwrap_or_default();
        let mut window = Row::default();
        rows.iter().take((end - first) as usize).for_each(|row| window.merge(row));
        let [slow_ages, _] = stage.ledger.others();
        let of = |wanted: fn(&Manner) -> bool| -> Vec<&Outcome> {
            crowd.outcomes.iter().filter(|outcome| wanted(&outcome.manner)).collect()
        };
        let steady = of(|manner| *manner == Manner::Steady);
        let slow = of(|manner| matches!(manner, Manner::Slow(_)));
        let stalled = of(|manner| matches!(manner, Manner::Stalled(_)));
        let mut client_mbps: Vec<f64> = steady.iter().map(|o| o.measured_bytes as f64 * 8e-6 / seconds).collect();
        client_mbps.sort_by(f64::total_cmp);
        let mut round_trips = Histogram::default();
        steady.iter().for_each(|outcome| round_trips.merge(&outcome.round_trips));
        let [cpu, own_cpu, machine_cpu] = cpu_between(&crowd.samples, first, end);
        let base_cpu = crowd.base_cpu;
        let per_second = window.bytes as f64 / seconds;
        let at_end = crowd.samples.iter().find(|sample| sample.row >= end).map(|sample| sample.server.clone());
        let at_end = at_end.unwrap_or_default();
        let begin = crowd.samples.iter().find(|sample| sample.row >= first).map(|sample| &sample.server);
        let grown = |of: fn(&super::monitor::Figures) -> Option<f64>| Some(of(&at_end)? - of(begin?)?);
        let (made, skipped_ticks) = (grown(|figures| figures.steps), grown(|figures| figures.skipped));
        let sampled = |row| crowd.samples.iter().find(|sample| sample.row == row);
        let resident: Vec<_> = (first..end).map(|row| sampled(row)?.server.resident_bytes).collect();
        let server = ServerCost {
            cpu,
            base_cpu,
            resident_mib: at_end.resident_bytes.map(|bytes| bytes / MIB),
            growth_mib: growth(&resident).map(|bytes| bytes / MIB),
            clients: at_end.clients,
            sending_ms: begin.and_then(|begin| at_end.sending.since(&begin.sending).shares()),
            jumps: grown(|figures| figures.jumps),
            skipped_ticks,
            skipped_share: made.zip(skipped_ticks).map(|(made, skipped)| skipped / (made + skipped).max(1.0)),
            bytes_per_cpu_second: cpu.filter(|cpu| *cpu > 0.0).map(|cpu| per_second / cpu),
            fan_out_bytes_per_cpu_second: cpu
                .zip(base_cpu)
                .map(|(cpu, base)| cpu - base)
                .filter(|cpu| *cpu > 0.0)
                .map(|cpu| per_second / cpu),
        };
        Self {
            seconds,
            decoded: crowd.outcomes.iter().map(|outcome| outcome.decoded).sum(),
            received_mbps: per_second * 8e-6,
            round_trip_ms: round_trips.percentiles(),
            server,
            own_cpu,
            machine_cpu,
            machine_cores: std::thread::available_parallelism().map_or(1, usize::from),
            rows: over_time(crowd, row_s),
            age_shares: window.ages.shares(),
            window_from_s: first as f64 * row_s,
            steady: Group::of(&steady, wanted, &window.ages, seconds),
            slow: (!slow.is_empty()).then(|| Group::of(&slow, slow.len(), &slow_ages, seconds)),
            stalled: (!stalled.is_empty()).then(|| Stalled::of(&stalled)),
            churned: crowd.churned,
            wind: crowd.wind.clone(),
            client_mbps,
        }
    }

    /// Why this is not good enough; empty when it is. `flat`: MiB by which the server's memory may grow.
    pub fn shortcomings(&self, tolerated: f64, flat: Option<f64>) -> Vec<String> {
        let Group { clients, stayed, late_share, coarser_share, gap_share, faults, ended, .. } = &self.steady;
        let mut why = Vec::new();
        if stayed < clients {
            let most = ended.first().map_or("they didn't end".to_owned(), |(why, _)| why.clone());
            why.push(format!("{} of {clients} clients did not stay: {most}", clients - stayed));
        }
        let mut all = *faults;
        self.slow.iter().for_each(|slow| all.add(&slow.faults));
        self.stalled.iter().for_each(|stalled| all.add(&stalled.faults));
        if all.total() > 0 {
            why.push(format!("{} messages were wrong", all.total()));
        }
        if self.steady.frames == 0 {
            why.push("no frame came".to_owned());
        }
        for (share, what) in [(late_share, "late"), (coarser_share, "coarser than asked for"), (gap_share, "missing")] {
            if *share > tolerated {
                why.push(format!("{:.3} % of frames were {what}, tolerated are {:.3} %", share * 1e2, tolerated * 1e2));
            }
        }
        if let Some(share) = self.server.skipped_share.filter(|share| *share > tolerated) {
            let (share, tolerated) = (share * 1e2, tolerated * 1e2);
            why.push(format!("{share:.3} % of ticks were skipped by the server, tolerated are {tolerated:.3} %"));
        }
        if let Some(Churned { told, left, came }) = self.churned.filter(|churned| churned.came < churned.told) {
            why.push(format!("{told} clients were told to leave, {left} did, {came} came in their place"));
        }
        if let Some(WindChanges { accepted, failed, first_failure: Some(first) }) = &self.wind {
            why.push(format!("{failed} of {} changes of wind failed: {first}", accepted + failed));
        }
        match (flat, self.server.growth_mib) {
            (Some(most), Some(grown)) if grown > most => {
                why.push(format!("the server's memory grew by {grown:.1} MiB, at most {most:.1} may be"));
            }
            (Some(_), None) => why.push("whether the server's memory grows is not known".to_owned()),
            _ => {}
        }
        why
    }
}

impl Group {
    fn of(outcomes: &[&Outcome], clients: usize, ages: &Histogram, seconds: f64) -> Self {
        let sum = |of: fn(&Outcome) -> u64| outcomes.iter().map(|outcome| of(outcome)).sum::<u64>();
        let mut faults = Faults::default();
        outcomes.iter().for_each(|outcome| faults.add(&outcome.faults));
        let mut ended = std::collections::BTreeMap::<&str, usize>::new();
        outcomes.iter().filter_map(|o| o.ended.as_deref()).for_each(|why| *ended.entry(why).or_default() += 1);
        let mut ended: Vec<_> = ended.into_iter().map(|(why, times)| (why.to_owned(), times)).collect();
        ended.sort_by_key(|(_, times)| std::cmp::Reverse(*times));
        let mut each: Vec<u64> = outcomes.iter().map(|outcome| outcome.measured_bytes).collect();
        each.sort_unstable();
        let [frames, late] = [sum(|o| o.measured_frames), sum(|o| o.measured_late)];
        let coarser = sum(|o| o.measured_coarser);
        let (bytes, gaps, came) = (sum(|o| o.measured_bytes), sum(|o| o.gaps), sum(|o| o.came));
        let mbps = |bytes: u64| bytes as f64 * 8e-6 / seconds;
        Self {
            clients,
            stayed: outcomes.iter().filter(|outcome| outcome.subscribed && outcome.ended.is_none()).count(),
            ended,
            frames,
            bytes,
            mbps: mbps(bytes),
            client_mbps_median: each.get(each.len() / 2).copied().map_or(0.0, mbps),
            age_ms: ages.percentiles(),
            late,
            late_share: late as f64 / frames.max(1) as f64,
            coarser,
            coarser_share: coarser as f64 / frames.max(1) as f64,
            gaps,
            gap_share: gaps as f64 / (gaps + came).max(1) as f64,
            faults,
        }
    }
}

impl Stalled {
    fn of(outcomes: &[&Outcome]) -> Self {
        let (mut live, mut faults) = (Histogram::default(), Faults::default());
        outcomes.iter().filter_map(|outcome| outcome.live_again_us).for_each(|us| live.add(us));
        outcomes.iter().for_each(|outcome| faults.add(&outcome.faults));
        Self {
            clients: outcomes.len(),
            woke: outcomes.iter().filter(|outcome| outcome.woke).count(),
            live_again: live.total() as usize,
            live_again_ms: live.percentiles(),
            faults,
        }
    }
}

/// Cores of the server, of ourselves and of the machine from one row to another.
fn cpu_between(samples: &[Sample], first: i64, end: i64) -> [Option<f64>; 3] {
    let mut within = samples.iter().filter(|sample| (first..=end).contains(&sample.row));
    let (Some(begin), Some(end)) = (within.next(), within.next_back()) else { return [None; 3] };
    let seconds = (end.at_us - begin.at_us) as f64 / 1e6;
    let cores = |of: fn(&Sample) -> Option<f64>| Some((of(end)? - of(begin)?) / seconds);
    let server = cores(|sample| sample.server.cpu_seconds);
    [server, cores(|sample| sample.own_cpu_seconds), cores(|sample| sample.machine_cpu_seconds)]
}

fn over_time(crowd: &Crowd, row_s: f64) -> Vec<ReportRow> {
    let row = |(at, row): (usize, &Row)| {
        let [server_cpu, own_cpu, machine_cpu] = cpu_between(&crowd.samples, at as i64, at as i64 + 1);
        let sample = crowd.samples.iter().find(|sample| sample.row == at as i64);
        ReportRow {
            at_s: at as f64 * row_s,
            mbps: row.bytes as f64 * 8e-6 / row_s,
            late: row.late,
            age_p50_ms: row.ages.percentile_ms(0.5),
            age_p99_ms: row.ages.percentile_ms(0.99),
            server_cpu,
            server_mib: sample.and_then(|sample| sample.server.resident_bytes).map(|bytes| bytes / MIB),
            own_cpu,
            machine_cpu,
        }
    };
    // What came behind the window is no whole row.
    crowd.rows.iter().take(crowd.window.1 as usize).enumerate().map(row).collect()
}
