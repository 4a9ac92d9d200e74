//! Times in buckets of equal ratio, counted by many at once without a lock.

use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Four buckets to each doubling from 50 microseconds on, and one for what is beyond the last, 7.8 s.
const BUCKETS: usize = 71;
const FIRST_US: f64 = 50.0;
const PER_DOUBLING: f64 = 4.0;

/// A histogram of times.
#[derive(Debug)]
pub struct Latency {
    counts: [AtomicU64; BUCKETS],
    sum_us: AtomicU64,
}

impl Default for Latency {
    fn default() -> Self {
        Self { counts: std::array::from_fn(|_| AtomicU64::new(0)), sum_us: AtomicU64::new(0) }
    }
}

impl Latency {
    /// Counts a time.
    pub fn observe(&self, us: i64) {
        let us = us.max(0) as u64;
        let above = libm::ceil(libm::log2(us.max(1) as f64 / FIRST_US) * PER_DOUBLING);
        self.counts[(above.max(0.0) as usize).min(BUCKETS - 1)].fetch_add(1, Relaxed);
        self.sum_us.fetch_add(us, Relaxed);
    }

    /// Writes it in Prometheus' text form.
    pub fn write(&self, name: &str, help: &str, page: &mut String) {
        let mut below = 0;
        // Writing to a string can't fail.
        let _ = writeln!(page, "# HELP {name} {help}\n# TYPE {name} histogram");
        for (at, count) in self.counts.iter().enumerate() {
            below += count.load(Relaxed);
            let bound = FIRST_US * libm::exp2(at as f64 / PER_DOUBLING) / 1e6;
            let bound = if at + 1 < BUCKETS { format!("{bound:.6}") } else { "+Inf".to_owned() };
            let _ = writeln!(page, "{name}_bucket{{le=\"{bound}\"}} {below}");
        }
        let _ = writeln!(page, "{name}_sum {}\n{name}_count {below}", self.sum_us.load(Relaxed) as f64 / 1e6);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_time_is_counted_below_its_bound_and_not_below_the_one_before() {
        let latency = Latency::default();
        for us in [0, 50, 51, 100, 1000, 8_000_000, 3_600_000_000] {
            latency.observe(us);
        }
        let mut page = String::new();
        latency.write("t", "Times.", &mut page);
        let below = |bound: &str| {
            let line = page.lines().find_map(|line| line.strip_prefix(&format!("t_bucket{{le=\"{bound}\"}} ")));
            line.unwrap_or_else(|| panic!("{bound} in {page}")).parse::<u64>().unwrap()
        };
        assert_eq!(["0.000050", "0.000059", "0.000084", "0.000100", "+Inf"].map(below), [2, 3, 3, 4, 7]);
        assert!(page.ends_with("t_sum 3608.001201\nt_count 7\n"), "{page}");
    }
}
