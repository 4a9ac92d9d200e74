//! The shared clock: server time from four timestamps of each exchange. Reads no clock itself; time is an argument.
//!
//! An exchange bounds the offset from both sides, whatever the network did: it is at most t1 - t0 (the request took no
//! negative time) and at least t2 - t3. Delay only ever loosens these bounds, so the tight ones are the good samples:
//! the line below every upper bound and the line above every lower bound enclose the truth, and their middle is right
//! by as much as the quickest requests and the quickest answers take equally long.

use std::collections::VecDeque;

/// Exchanges that are kept.
const SAMPLES: usize = 128;
/// A jump of server time larger than this is followed at once, microseconds.
const STEP_US: f64 = 200_000.0;
/// Share of passing time by which server time is bent towards the truth otherwise.
const SLEW: f64 = 0.01;
/// No two clocks differ more in rate: twice what a poor crystal is off.
const MAX_DRIFT: f64 = 200e-6;
/// What two clocks usually differ: a slope is trusted as far as its noise is below this.
const USUAL_DRIFT: f64 = 50e-6;
/// Noise of a slope, times the span of the samples, as a share of half the least round trip. Found by simulation, for
/// jitter of half the delay.
const SLOPE_NOISE: f64 = 0.1;
/// Times beyond this are nobody's: 2^60 microseconds, 36,000 years.
const MAX_US: i64 = 1 << 60;

/// One exchange of `time`, in microseconds; t0 and t3 by our clock, t1 and t2 by the server's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// When we sent the request.
    pub t0: i64,
    /// When the server read it.
    pub t1: i64,
    /// When the server wrote its answer.
    pub t2: i64,
    /// When we read the answer.
    pub t3: i64,
}

impl Exchange {
    /// Whether these four can be times of one exchange.
    fn is_possible(&self) -> bool {
        let within = [self.t0, self.t1, self.t2, self.t3].iter().all(|t| (-MAX_US..=MAX_US).contains(t));
        within && self.t3 >= self.t0 && self.t2 >= self.t1 && self.t2 - self.t1 <= self.t3 - self.t0
    }
}

/// Server time as a line over ours, both relative to `origin`.
#[derive(Clone, Copy, Debug)]
struct Fit {
    offset_us: f64,
    drift: f64,
    /// Half the room between the bounds; below zero when no line passes between them.
    half_width_us: f64,
    bound_us: f64,
}

/// Server time by our clock.
#[derive(Clone, Debug, Default)]
pub struct SharedClock {
    samples: VecDeque<Exchange>,
    /// Our time and the offset at the last fit; everything else is relative to them, so that f64 stays exact.
    origin: (i64, i64),
    fit: Option<Fit>,
    /// What server time still lacks to the fit at `origin`, taken back by [`SLEW`].
    lag_us: f64,
    /// Exchanges in a row that the fit says can't be.
    contradictions: usize,
}

impl SharedClock {
    /// A clock that knows nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes one exchange. Returns whether it was possible; an impossible one changes nothing.
    pub fn observe(&mut self, exchange: Exchange) -> bool {
        if !exchange.is_possible() {
            return false;
        }
        let before = self.server_us(exchange.t3);
        if self.contradicts(&exchange) {
            // One of our clocks was set or stood still: the old samples say nothing about the new time. Two in a row,
            // so that one wild answer doesn't throw away a good fit.
            self.contradictions += 1;
            if self.contradictions < 2 {
                return true;
            }
            self.samples.clear();
        }
        self.contradictions = 0;
        if self.samples.len() == SAMPLES {
            self.samples.pop_front();
        }
        self.samples.push_back(exchange);
        self.origin = (exchange.t3, exchange.t2 - exchange.t3);
        let mut fit = fit(&self.samples, self.origin);
        while fit.half_width_us < 0.0 && self.samples.len() > 1 {
            // Bounds that exclude one another: the clocks ran apart, or one was moved a little. The newer ones are right.
            self.samples.pop_front();
            fit = self::fit(&self.samples, self.origin);
        }
        self.fit = Some(fit);
        let now = exchange.t3 + self.origin.1 + fit.offset_us.round() as i64;
        let lag = before.map_or(0.0, |before| (before - now) as f64);
        self.lag_us = if lag.abs() > STEP_US { 0.0 } else { lag };
        true
    }

    /// Server time, microseconds since tick 0, at a time of ours; `None` before the first exchange.
    pub fn server_us(&self, now_us: i64) -> Option<i64> {
        let fit = self.fit?;
        let passed = now_us.clamp(-MAX_US, MAX_US) - self.origin.0;
        let slewed = SLEW * (passed as f64).max(0.0);
        let lag = self.lag_us.signum() * (self.lag_us.abs() - slewed).max(0.0);
        Some(self.origin.0 + passed + self.origin.1 + (fit.offset_us + fit.drift * passed as f64 + lag).round() as i64)
    }

    /// How far server time can be off, microseconds: the truth lies within it even if one direction took no time and the
    /// clocks' rates differ as much as clocks may.
    pub fn error_bound_us(&self, now_us: i64) -> Option<i64> {
        let fit = self.fit?;
        let passed = (now_us.clamp(-MAX_US, MAX_US) - self.origin.0).max(0) as f64;
        let lag = (self.lag_us.abs() - SLEW * passed).max(0.0);
        Some((fit.bound_us + lag + MAX_DRIFT * passed).ceil() as i64)
    }

    /// By how much the server's clock runs faster than ours, as a share.
    pub fn drift(&self) -> f64 {
        self.fit.map_or(0.0, |fit| fit.drift)
    }

    /// Exchanges held.
    pub fn samples(&self) -> usize {
        self.samples.len()
    }

    /// Whether an exchange rules out the fit by more than a step.
    fn contradicts(&self, e: &Exchange) -> bool {
        let Some(fit) = self.fit else { return false };
        let at = |t: i64| self.origin.1 as f64 + fit.offset_us + fit.drift * (t - self.origin.0) as f64;
        at(e.t0) > (e.t1 - e.t0) as f64 + STEP_US || at(e.t3) < (e.t2 - e.t3) as f64 - STEP_US
    }
}

/// The middle between the line below all upper bounds and the line above all lower bounds.
fn fit(samples: &VecDeque<Exchange>, origin: (i64, i64)) -> Fit {
    let point = |ours: i64, theirs: i64| ((ours - origin.0) as f64, (theirs - ours - origin.1) as f64);
    let upper: Vec<_> = samples.iter().map(|e| point(e.t0, e.t1)).collect();
    let lower: Vec<_> = samples.iter().map(|e| point(e.t3, e.t2)).collect();
    let span = upper[upper.len() - 1].0 - upper[0].0;
    let mirrored: Vec<_> = lower.iter().map(|(x, y)| (*x, -y)).collect();
    let steepest = (supporting_slope(&upper) - supporting_slope(&mirrored)) / 2.0;
    let within = |drift: f64, at: f64| {
        let above = upper.iter().map(|(x, y)| y + drift * (at - x)).fold(f64::INFINITY, f64::min);
        let below = lower.iter().map(|(x, y)| y + drift * (at - x)).fold(f64::NEG_INFINITY, f64::max);
        ((above + below) / 2.0, (above - below) / 2.0)
    };
    // Jitter tilts the lines, the more the shorter they are: weigh the slope by what it is worth.
    let noise = SLOPE_NOISE * within(steepest, 0.0).1.max(0.0) / span.max(1.0);
    let drift = (steepest / (1.0 + (noise / USUAL_DRIFT).powi(2))).clamp(-MAX_DRIFT, MAX_DRIFT);
    let (offset_us, half_width_us) = within(drift, 0.0);
    Fit { offset_us, drift, half_width_us, bound_us: bound(&upper, &lower, offset_us) }
}

/// How far `offset` can be off at the origin, whatever the clocks' rates within [`MAX_DRIFT`] of one another.
fn bound(upper: &[(f64, f64)], lower: &[(f64, f64)], offset: f64) -> f64 {
    let above = upper.iter().map(|(x, y)| y + MAX_DRIFT * x.abs()).fold(f64::INFINITY, f64::min);
    let below = lower.iter().map(|(x, y)| y - MAX_DRIFT * x.abs()).fold(f64::NEG_INFINITY, f64::max);
    (above - offset).max(offset - below).max(0.0)
}

/// Slope of the highest line below all points, measured at their mean: an edge of the lower convex hull.
fn supporting_slope(points: &[(f64, f64)]) -> f64 {
    let turn = |a: (f64, f64), b: (f64, f64), c: (f64, f64)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for point in sorted {
        while hull.len() >= 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0.0 {
            hull.pop();
        }
        hull.push(point);
    }
    let mean = points.iter().map(|p| p.0).sum::<f64>() / points.len() as f64;
    let edge = hull.windows(2).find(|edge| edge[1].0 >= mean && edge[1].0 > edge[0].0);
    edge.map_or(0.0, |edge| (edge[1].1 - edge[0].1) / (edge[1].0 - edge[0].0))
}
