//! What a process has used, as Linux tells it in /proc (elsewhere nothing is known), and how much it may open.

use std::fs;

/// Fields of /proc/PID/stat count the processor in hundredths of a second, on every machine that Linux runs on today.
const TICKS: f64 = 100.0;

/// Processor and memory of one process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usage {
    /// Seconds of processor, user and system, all threads together, since it began.
    pub cpu_seconds: f64,
    /// Memory in use now, bytes.
    pub resident_bytes: u64,
}

impl Usage {
    /// Of this process.
    pub fn own() -> Option<Self> {
        let read = |file: &str| fs::read_to_string(format!("/proc/self/{file}")).ok();
        Self::parse(&read("stat")?, &read("status")?)
    }

    fn parse(stat: &str, status: &str) -> Option<Self> {
        // The name of the program stands in parentheses and may hold anything. After it, field 3 is the first.
        let (_, fields) = stat.rsplit_once(')')?;
        let mut fields = fields.split_ascii_whitespace().skip(11);
        let (user, system) = (fields.next()?.parse::<u64>().ok()?, fields.next()?.parse::<u64>().ok()?);
        // In kilobytes, so that the size of a page needn't be known; a process that is ending has none.
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kilobytes = resident.map_or(Some(0), |text| text.split_ascii_whitespace().next()?.parse::<u64>().ok())?;
        Some(Self { cpu_seconds: (user + system) as f64 / TICKS, resident_bytes: kilobytes << 10 })
    }
}

/// Seconds that all processors of this machine were busy since it began, whoever with: also what the system does for
/// sockets and books on no process, and what a host took away.
pub fn machine_cpu_seconds() -> Option<f64> {
    busy(&fs::read_to_string("/proc/stat").ok()?)
}

fn busy(stat: &str) -> Option<f64> {
    let fields = stat.lines().next()?.strip_prefix("cpu ")?.split_ascii_whitespace();
    let fields: Vec<u64> = fields.take(8).map(|field| field.parse().ok()).collect::<Option<_>>()?;
    let [user, nice, system, _idle, _io_wait, irq, soft_irq, stolen] = fields[..] else { return None };
    Some((user + nice + system + irq + soft_irq + stolen) as f64 / TICKS)
}

/// Lets this process open as many files and sockets as it wants, as far as the system's hard limit allows; returns how
/// many that are now.
///
/// # Errors
/// When the system won't say.
pub fn allow_open_files(wanted: u64) -> std::io::Result<u64> {
    // Elsewhere sockets are no files.
    if cfg!(unix) { rlimit::increase_nofile_limit(wanted) } else { Ok(wanted) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fields_are_those_of_proc() {
        let stat = "7 (a ) b) S 1 7 7 0 -1 4194560 1 2 3 4 150 25 0 0 20 0 5 0 100 1000 200 18446744073709551615";
        let status = "Name:\ta ) b\nVmHWM:\t  9999 kB\nVmRSS:\t   12 kB\nThreads:\t5\n";
        assert_eq!(Usage::parse(stat, status), Some(Usage { cpu_seconds: 1.75, resident_bytes: 12 << 10 }));
        assert_eq!(Usage::parse(stat, "").map(|usage| usage.resident_bytes), Some(0));
        assert_eq!(Usage::parse("", status), None);
        assert_eq!(busy("cpu  100 20 3 9999 99 4 5 6 0 0\ncpu0 1 1 1 1 1 1 1 1 0 0\n"), Some(1.38));
        assert_eq!(busy("cpu0 1 1 1 1 1 1 1 1 0 0\n"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_process_has_used_something() {
        assert!(Usage::own().is_some_and(|usage| usage.resident_bytes > 1 << 20));
    }
}
