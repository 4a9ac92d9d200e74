//! Who wants what: the union that the engine is asked for, kept within the limit of live units.

use std::collections::{BTreeMap, BTreeSet};

use crate::engine::Demand;
use crate::wire::{ErrorClass, UnitName};

/// Wishes of all clients.
#[derive(Debug)]
pub struct Subscriptions {
    most: usize,
    by_client: BTreeMap<u64, Wish>,
}

#[derive(Clone, Debug)]
struct Wish {
    interval: i64,
    units: Vec<UnitName>,
}

impl Subscriptions {
    /// No wishes; at most `most` units are live at a time.
    pub fn new(most: usize) -> Self {
        Self { most, by_client: BTreeMap::new() }
    }

    /// Replaces a client's wish. A unit above the limit is replaced by the next finer one that is live. Returns what
    /// the client gets, in the order asked.
    ///
    /// # Errors
    /// Index of the unit that can't be had; the wish that the client had before stands.
    pub fn replace(&mut self, client: u64, interval: i64, asked: &[UnitName]) -> Result<Vec<UnitName>, usize> {
        let others = self.by_client.iter().filter(|(id, _)| **id != client);
        let mut live: BTreeSet<UnitName> = others.flat_map(|(_, wish)| wish.units.iter().copied()).collect();
        let mut units = Vec::with_capacity(asked.len());
        for (index, unit) in asked.iter().enumerate() {
            let unit = if live.contains(unit) || live.len() < self.most {
                *unit
            } else {
                let finer = ErrorClass::ALL[..usize::from(unit.class.id())].iter().rev();
                finer.map(|class| UnitName { class: *class, ..*unit }).find(|unit| live.contains(unit)).ok_or(index)?
            };
            live.insert(unit);
            units.push(unit);
        }
        if units.is_empty() {
            self.by_client.remove(&client);
        } else {
            self.by_client.insert(client, Wish { interval, units: units.clone() });
        }
        Ok(units)
    }

    /// Forgets units of which nothing will come any more.
    pub fn forget(&mut self, gone: impl Fn(&UnitName) -> bool) {
        self.by_client.values_mut().for_each(|wish| wish.units.retain(|unit| !gone(unit)));
    }

    /// Forgets a client.
    pub fn remove(&mut self, client: u64) {
        self.by_client.remove(&client);
    }

    /// Every live unit at the smallest interval that somebody wants.
    pub fn demand(&self) -> Demand {
        let mut demand = Demand::new();
        for wish in self.by_client.values() {
            for unit in &wish.units {
                demand.entry(*unit).and_modify(|least| *least = wish.interval.min(*least)).or_insert(wish.interval);
            }
        }
        demand
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Group;

    fn unit(level: u8, class: ErrorClass) -> UnitName {
        UnitName { cascade: 0, level, class, group: Group::Displacement }
    }

    #[test]
    fn demand_is_the_union_at_the_smallest_interval() {
        let mut all = Subscriptions::new(64);
        let (a, b) = (unit(0, ErrorClass::Millimetre), unit(1, ErrorClass::Millimetre));
        all.replace(1, 480, &[a, b]).unwrap();
        all.replace(2, 120, &[b]).unwrap();
        assert_eq!(all.demand(), Demand::from([(a, 480), (b, 120)]));
        all.remove(2);
        assert_eq!(all.demand(), Demand::from([(a, 480), (b, 480)]));
        all.replace(1, 240, &[]).unwrap();
        assert!(all.demand().is_empty());
    }

    #[test]
    fn at_the_limit_the_next_finer_live_class_serves() {
        let mut all = Subscriptions::new(2);
        let (finest, fine) = (unit(0, ErrorClass::HalfMillimetre), unit(0, ErrorClass::Millimetre));
        all.replace(1, 480, &[finest, fine]).unwrap();
        let coarse = unit(0, ErrorClass::TwentyMillimetres);
        assert_eq!(all.replace(2, 480, &[coarse]), Ok(vec![fine]), "the next finer, not the finest");
        assert_eq!(all.replace(3, 480, &[fine, unit(1, ErrorClass::Millimetre)]), Err(1));
        // A client's own units make room for what replaces them.
        all.remove(2);
        assert_eq!(all.replace(1, 480, &[coarse]), Ok(vec![coarse]));
    }
}
