//! A report for people: a table in text, and a row of docs/load.md.

use std::fmt::Write;

use super::figures::Percentiles;
use super::report::{Findings, Report};

/// A number, or a dash.
pub fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

impl Report {
    /// The lines of the table: what, here, and at the calibrator.
    pub fn lines(&self) -> Vec<[String; 3]> {
        let of = |findings: &Findings| -> Vec<(&'static str, String)> {
            let (steady, server) = (&findings.steady, &findings.server);
            let ages = |age: Option<Percentiles>| {
                age.map_or("-".to_owned(), |a| format!("{:.2} / {:.2} / {:.2} / {:.2}", a.p50, a.p99, a.p999, a.max))
            };
            let share = |count: u64, share: f64| format!("{count} ({:.4} %)", share * 1e2);
            let slow = findings.slow.as_ref();
            let stalled = findings.stalled.as_ref();
            vec![
                ("clients that stayed", format!("{} of {}", steady.stayed, steady.clients)),
                ("received, Mb/s", number(Some(findings.received_mbps), 1)),
                ("received by a client, least / median, Mb/s", {
                    let least = number(findings.client_mbps.first().copied(), 2);
                    format!("{least} / {:.2}", steady.client_mbps_median)
                }),
                ("frames", steady.frames.to_string()),
                ("age p50 / p99 / p99.9 / max, ms", ages(steady.age_ms)),
                ("ready to last byte with the system p50 / p99 / p99.9, ms", {
                    server.sending_ms.map_or("-".to_owned(), |s| format!("{:.2} / {:.2} / {:.2}", s.p50, s.p99, s.p999))
                }),
                ("late", share(steady.late, steady.late_share)),
                ("coarser than asked for", share(steady.coarser, steady.coarser_share)),
                ("gaps", share(steady.gaps, steady.gap_share)),
                ("wrong messages", steady.faults.total().to_string()),
                ("decoded in full", findings.decoded.to_string()),
                ("round trip p50 / p99 / p99.9 / max, ms", ages(findings.round_trip_ms)),
                ("slow clients that stayed", slow.map_or("-".to_owned(), |s| format!("{} of {}", s.stayed, s.clients))),
                ("stalled, woke, live again", {
                    stalled.map_or("-".to_owned(), |s| format!("{}, {}, {}", s.clients, s.woke, s.live_again))
                }),
                ("live again after p50 / p99 / p99.9 / max, ms", ages(stalled.and_then(|s| s.live_again_ms))),
                ("clients that left, that came in their place", {
                    findings.churned.map_or("-".to_owned(), |churned| format!("{}, {}", churned.left, churned.came))
                }),
                ("changes of wind, accepted, failed", {
                    let wind = findings.wind.as_ref();
                    wind.map_or("-".to_owned(), |wind| format!("{}, {}", wind.accepted, wind.failed))
                }),
                ("ticks skipped by the server", {
                    let of_all = server.skipped_share.map(|share| format!(" ({:.4} %)", share * 1e2));
                    number(server.skipped_ticks, 0) + &of_all.unwrap_or_default()
                }),
                ("clients moved to the newest frames", number(server.jumps, 0)),
                ("server CPU, cores", number(server.cpu, 2)),
                ("server CPU without the crowd, cores", number(server.base_cpu, 2)),
                ("server memory, MiB", number(server.resident_mib, 0)),
                ("... grew from second to last quarter by", number(server.growth_mib, 1)),
                ("MB per server CPU second", number(server.bytes_per_cpu_second.map(|bytes| bytes / 1e6), 0)),
                ("... of fan-out alone", number(server.fan_out_bytes_per_cpu_second.map(|bytes| bytes / 1e6), 0)),
                ("CPU of the load test, cores", number(findings.own_cpu, 2)),
                ("CPU of this machine, cores", {
                    findings
                        .machine_cpu
                        .map_or("-".to_owned(), |busy| format!("{busy:.2} of {}", findings.machine_cores))
                }),
            ]
        };
        let here = of(&self.load);
        let there = self.calibration.as_ref().map(|calibration| of(&calibration.findings)).unwrap_or_default();
        let there = there.into_iter().map(|(_, value)| value).chain(std::iter::repeat(String::new()));
        here.into_iter()
            .zip(there)
            .map(|((what, here), there)| [what.to_owned(), here, there])
            .filter(|[_, here, there]| here != "-" || !(there.is_empty() || there == "-"))
            .collect()
    }

    /// The table as text.
    pub fn table(&self) -> String {
        let mut text = format!("{} at {}, {:.0} s\n\n", self.scene, self.url, self.seconds);
        let mut lines = self.lines();
        if self.calibration.is_some() {
            lines.insert(0, [String::new(), "server".to_owned(), "calibrator".to_owned()]);
        }
        let wide = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let (first, second) = (wide(0), wide(1));
        for [what, here, there] in &lines {
            let line = format!("{what:first$}  {here:second$}  {there}");
            // Writing to a string can't fail.
            let _ = writeln!(text, "{}", line.trim_end());
        }
        if let Some(calibration) = &self.calibration {
            let percent = |ratio: Option<f64>| number(ratio.map(|ratio| ratio * 1e2), 0);
            let (all, fan_out) = (percent(calibration.ratio), percent(calibration.fan_out_ratio));
            let _ = writeln!(
                text,
                "\nbytes per server CPU second: {all} % of the calibrator's, {fan_out} % for fan-out alone"
            );
        }
        let bound = number(self.clock_error_bound_ms, 2);
        let _ = writeln!(text, "\nshared clock within {bound} ms");
        let verdict =
            if self.holds { "it holds".to_owned() } else { format!("it does not hold: {}", self.why.join("; ")) };
        let _ = writeln!(text, "{verdict}");
        text
    }

    /// One row of the table of docs/load.md.
    pub fn markdown_row(&self) -> String {
        let Findings { steady, server, .. } = &self.load;
        let age = |of: fn(&Percentiles) -> f64| number(steady.age_ms.as_ref().map(of), 1);
        let cells = [
            steady.clients.to_string(),
            number(Some(self.load.received_mbps), 0),
            age(|age| age.p50),
            age(|age| age.p99),
            age(|age| age.p999),
            format!("{:.3} %", steady.late_share * 1e2),
            format!("{:.3} %", steady.gap_share * 1e2),
            number(server.cpu, 2),
            number(server.resident_mib, 0),
            number(self.load.own_cpu, 2),
            number(self.load.machine_cpu, 2),
            number(server.bytes_per_cpu_second.map(|bytes| bytes / 1e6), 0),
            number(self.calibration.as_ref().and_then(|c| c.fan_out_ratio).map(|ratio| ratio * 1e2), 0),
            if self.holds { "yes" } else { "no" }.to_owned(),
        ];
        format!("| {} |", cells.join(" | "))
    }
}
