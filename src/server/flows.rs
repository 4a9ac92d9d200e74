//! All flows of one client: what it was granted, and what of that is sent at its quality.

use super::flow::Flow;
use crate::engine::interval_of_rate;
use crate::tile::SentFrame;
use crate::wire::{Quality, UnitName};

/// Units, each with the interval in ticks at which it comes.
pub type Granted = Vec<(UnitName, i64)>;

/// The flows of a client, in the order of their units.
#[derive(Debug, Default)]
pub struct Flows {
    flows: Vec<Flow>,
    /// Whether every second begins with key frames.
    keys: bool,
}

/// What is asked of the engine at this quality, where `levels` says how many levels a cascade has.
pub fn at_quality(granted: &Granted, quality: Quality, levels: impl Fn(u8) -> u8) -> Granted {
    let least = interval_of_rate(quality.rate_hz);
    let unit = |(unit, interval): &(UnitName, i64)| {
        let coarsest = levels(unit.cascade).saturating_sub(1).max(unit.level);
        (UnitName { level: unit.level.saturating_add(quality.coarser).min(coarsest), ..*unit }, (*interval).max(least))
    };
    granted.iter().map(unit).collect()
}

/// The first tick of a unit whose frames leave after those of `begun`. One that is predicted can be begun with every
/// `grid` ticks.
pub fn first_tick(unit: &UnitName, interval: i64, begun: i64, grid: i64) -> i64 {
    let grid = if unit.codec.predicts() { grid } else { interval };
    (begun / grid + 1) * grid
}

impl Flows {
    /// Whether nothing flows.
    pub fn is_empty(&self) -> bool {
        self.flows.is_empty()
    }

    /// Replaces the flows by these; those that go on flow without a gap. Gives the units that need key frames.
    pub fn replace(&mut self, units: &Granted, keys: bool, begun: i64, grid: i64) -> Vec<UnitName> {
        let held = std::mem::take(&mut self.flows);
        let known = |unit: &UnitName| held.binary_search_by_key(unit, |flow| flow.unit).map(|at| held[at]);
        let flow = |(unit, interval): &(UnitName, i64)| match known(unit) {
            Ok(flow) => flow.every(*interval),
            Err(_) => Flow::new(*unit, *interval, first_tick(unit, *interval, begun, grid)),
        };
        self.flows = units.iter().map(flow).collect();
        self.keys = keys;
        // Of a unit that was asked for twice the shorter interval stays.
        self.flows.sort_unstable_by_key(|flow| (flow.unit, flow.interval));
        self.flows.dedup_by_key(|flow| flow.unit);
        let new = self.flows.iter().map(|flow| flow.unit).filter(|unit| unit.codec.predicts() && known(unit).is_err());
        new.collect()
    }

    /// Ends the flows of units that are gone.
    pub fn retain(&mut self, stays: impl Fn(&UnitName) -> bool) {
        self.flows.retain(|flow| stays(&flow.unit));
    }

    /// Whether this frame is sent.
    pub fn takes(&mut self, frame: &SentFrame) -> bool {
        let at = self.flows.binary_search_by_key(&frame.unit, |flow| flow.unit);
        at.is_ok_and(|at| self.flows[at].takes(frame, self.keys))
    }

    /// Begins all flows anew: the client has lost what it had.
    pub fn forget(&mut self) {
        self.flows.iter_mut().for_each(Flow::forget);
    }

    /// Units of which the client lacks what their next frames are predicted from; each is given once.
    pub fn lost(&mut self) -> Vec<UnitName> {
        self.flows.iter_mut().filter_map(|flow| flow.is_lost().then_some(flow.unit)).collect()
    }
}
