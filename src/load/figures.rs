//! What is counted: ages in buckets of equal ratio, rows over time, and which ticks of a unit came. Bounded memory.

use serde::Serialize;

/// Each doubling is cut into 2^6 buckets: a percentile is at most 1.6 % too high.
const BITS: u32 = 6;
/// What lies beyond 2^36 microseconds, 19 hours, counts as that.
const MOST_US: u64 = 1 << 36;
/// So many ticks of a unit's grid may still be on their way: the newest are not missed yet.
const ON_THE_WAY: u32 = 8;

/// Times in microseconds, counted in buckets of equal ratio.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Histogram {
    /// Up to the highest bucket that was hit.
    counts: Vec<u64>,
    total: u64,
    max_us: u64,
}

impl Histogram {
    /// Counts one time; what is below zero counts as zero.
    pub fn add(&mut self, us: i64) {
        let us = us.clamp(0, MOST_US as i64) as u64;
        let bucket = bucket(us);
        if self.counts.len() <= bucket {
            self.counts.resize(bucket + 1, 0);
        }
        self.counts[bucket] += 1;
        self.total += 1;
        self.max_us = self.max_us.max(us);
    }

    /// Adds all that another holds.
    pub fn merge(&mut self, other: &Self) {
        if self.counts.len() < other.counts.len() {
            self.counts.resize(other.counts.len(), 0);
        }
        self.counts.iter_mut().zip(&other.counts).for_each(|(mine, theirs)| *mine += theirs);
        self.total += other.total;
        self.max_us = self.max_us.max(other.max_us);
    }

    /// How many were counted.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The time that a share of all (0 to 1) don't exceed, milliseconds: the upper end of its bucket.
    pub fn percentile_ms(&self, share: f64) -> Option<f64> {
        let rank = ((share * self.total as f64).ceil() as u64).clamp(1, self.total.max(1));
        let mut below = 0;
        let at = self.counts.iter().position(|count| {
            below += count;
            below >= rank
        })?;
        Some(last_of(at).min(self.max_us) as f64 / 1e3)
    }

    /// The percentiles that reports name.
    pub fn percentiles(&self) -> Option<Percentiles> {
        let at = |share| self.percentile_ms(share);
        Some(Percentiles { p50: at(0.5)?, p99: at(0.99)?, p999: at(0.999)?, max: self.max_us as f64 / 1e3 })
    }

    /// The share of all that is at or below a time, at the upper end of every bucket that holds any, in milliseconds.
    pub fn shares(&self) -> Vec<(f64, f64)> {
        let mut below = 0;
        let held = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        let share = |(at, count): (usize, &u64)| {
            below += count;
            (last_of(at).min(self.max_us) as f64 / 1e3, below as f64 / self.total as f64)
        };
        held.map(share).collect()
    }
}

/// Milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // The names say it.
pub struct Percentiles {
    pub p50: f64,
    pub p99: f64,
    pub p999: f64,
    pub max: f64,
}

fn bucket(us: u64) -> usize {
    let octave = (us >> BITS).checked_ilog2().map_or(0, |log| log + 1);
    // Below 2^(BITS + 1) every microsecond has a bucket of its own.
    let shift = octave.saturating_sub(1);
    ((shift as usize) << BITS) + (us >> shift) as usize
}

/// The largest time of a bucket.
fn last_of(bucket: usize) -> u64 {
    let shift = (bucket >> BITS).saturating_sub(1);
    let first = ((bucket - (shift << BITS)) as u64) << shift;
    first + (1 << shift) - 1
}

/// Which ticks of one tile's grid came, in whatever order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Continuity {
    /// Numbers on the grid, and how many between them came.
    span: Option<(i64, i64)>,
    came: u64,
    /// The newest 64: bit 0 is the last.
    recent: u64,
}

impl Continuity {
    /// Takes a number on the grid; whether it is new. One more than 64 behind the newest is taken for a repeated one.
    pub fn take(&mut self, number: i64) -> bool {
        let Some((first, last)) = &mut self.span else {
            *self = Self { span: Some((number, number)), came: 1, recent: 1 };
            return true;
        };
        let ahead = number - *last;
        if ahead > 0 {
            self.recent = if ahead < 64 { self.recent << ahead } else { 0 } | 1;
            *last = number;
        } else {
            let bit = if ahead > -64 { 1 << -ahead } else { 0 };
            if bit == 0 || self.recent & bit != 0 {
                return false;
            }
            self.recent |= bit;
            *first = number.min(*first);
        }
        self.came += 1;
        true
    }

    /// How many came.
    pub fn came(&self) -> u64 {
        self.came
    }

    /// How many between the first and the last never came. Of the newest few, some may still be on their way.
    pub fn missing(&self) -> u64 {
        let Some((first, last)) = self.span else { return 0 };
        let newest = ((last - first) as u64 + 1).min(u64::from(ON_THE_WAY)) as u32;
        let on_the_way = newest - (self.recent & ((1 << newest) - 1)).count_ones();
        ((last - first) as u64 + 1 - self.came).saturating_sub(u64::from(on_the_way))
    }
}

/// What all clients together received in one row of time.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Of clients of every kind.
    pub bytes: u64,
    /// Frames of the steady clients.
    pub frames: u64,
    /// Those that came too late to be interpolated between.
    pub late: u64,
    /// Their ages.
    pub ages: Histogram,
}

impl Row {
    /// Adds all that another holds.
    pub fn merge(&mut self, other: &Self) {
        self.bytes += other.bytes;
        self.frames += other.frames;
        self.late += other.late;
        self.ages.merge(&other.ages);
    }
}
