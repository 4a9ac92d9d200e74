//! A histogram as a server tells it in `/metrics`, and what share of it lies below which time. Pure.

use serde::Serialize;

/// Bounds in seconds, lowest first, each with how many were at most that.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Buckets(Vec<(f64, f64)>);

/// Milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // The names say it.
pub struct Shares {
    pub p50: f64,
    pub p99: f64,
    pub p999: f64,
}

impl Buckets {
    /// The histogram of this name; empty where the page has none.
    pub fn parse(page: &str, name: &str) -> Self {
        let bucket = |line: &str| {
            let (bound, count) = line.strip_prefix(name)?.strip_prefix("_bucket{le=\"")?.split_once("\"} ")?;
            let bound = if bound == "+Inf" { f64::INFINITY } else { bound.parse().ok()? };
            Some((bound, count.trim().parse().ok()?))
        };
        Self(page.lines().filter_map(bucket).collect())
    }

    /// What was added since an earlier look.
    pub fn since(&self, earlier: &Self) -> Self {
        let before = earlier.0.iter().map(|(_, count)| *count).chain(std::iter::repeat(0.0));
        Self(self.0.iter().zip(before).map(|((bound, count), before)| (*bound, count - before)).collect())
    }

    /// Evenly within each bucket, as Prometheus has it; `None` where nothing was counted.
    pub fn shares(&self) -> Option<Shares> {
        let total = self.0.last().map(|(_, count)| *count).filter(|count| *count > 0.0)?;
        let at = |share: f64| {
            let wanted = share * total;
            let (mut low, mut below) = (0.0, 0.0);
            for (bound, count) in &self.0 {
                if *count >= wanted {
                    // Nothing is known of what is beyond the last bound.
                    let high = if bound.is_finite() { *bound } else { low };
                    return (low + (high - low) * (wanted - below) / (count - below).max(1e-9)) * 1e3;
                }
                (low, below) = (*bound, *count);
            }
            low * 1e3
        };
        Some(Shares { p50: at(0.5), p99: at(0.99), p999: at(0.999) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_what_came_between_two_looks() {
        let page = |counts: [u32; 4]| {
            let [a, b, c, d] = counts;
            format!(
                "# TYPE t histogram\nt_bucket{{le=\"0.001\"}} {a}\nt_bucket{{le=\"0.002\"}} {b}\n\
                 t_bucket{{le=\"0.004\"}} {c}\nt_bucket{{le=\"+Inf\"}} {d}\nt_sum 3\nt_count {d}\n"
            )
        };
        let (before, after) =
            (Buckets::parse(&page([7, 7, 7, 9]), "t"), Buckets::parse(&page([57, 107, 107, 109]), "t"));
        let shares = after.since(&before).shares().unwrap();
        assert_eq!((shares.p50, shares.p99), (1.0, 1.98));
        assert_eq!(before.since(&before).shares(), None);
        assert_eq!(Buckets::parse("", "t").shares(), None);
    }
}
