//! Who wants what: the union that the engine is asked for, kept within the limit of live units.

use std::collections::{BTreeMap, BTreeSet};

use crate::plan::Demand;
use crate::wire::{ErrorClass, UnitName};

/// Wishes of all clients.
#[derive(Debug)]
pub struct Subscriptions {
    most: usize,
    by_client: BTreeMap<u64, Wish>,
}

/// Units, each with the interval in ticks at which it is wanted.
type Wish = Vec<(UnitName, i64)>;

impl Subscriptions {
    /// No wishes; at most `most` units are live at a time.
    pub fn new(most: usize) -> Self {
        Self { most, by_client: BTreeMap::new() }
    }

    /// Replaces a client's wish: units, each with its interval in ticks. A unit above the limit is replaced by the next
    /// finer one that is live. Returns what the client gets, in the order asked.
    ///
    /// # Errors
    /// Index of the unit that can't be had; the wish that the client had before stands.
    pub fn replace(&mut self, client: u64, asked: &[(UnitName, i64)]) -> Result<Vec<(UnitName, i64)>, usize> {
        let others = self.by_client.iter().filter(|(id, _)| **id != client);
        let mut live: BTreeSet<UnitName> = others.flat_map(|(_, wish)| wish.iter().map(|(unit, _)| *unit)).collect();
        let mut units = Vec::with_capacity(asked.len());
        for (index, (unit, interval)) in asked.iter().enumerate() {
            let unit = if live.contains(unit) || live.len() < self.most {
                *unit
            } else {
                let finer = ErrorClass::ALL[..usize::from(unit.class.id())].iter().rev();
                finer.map(|class| UnitName { class: *class, ..*unit }).find(|unit| live.contains(unit)).ok_or(index)?
            };
            live.insert(unit);
            units.push((unit, *interval));
        }
        if units.is_empty() {
            self.by_client.remove(&client);
        } else {
            self.by_client.insert(client, units.clone());
        }
        Ok(units)
    }

    /// Forgets units of which nothing will come any more.
    pub fn forget(&mut self, gone: impl Fn(&UnitName) -> bool) {
        self.by_client.values_mut().for_each(|wish| wish.retain(|(unit, _)| !gone(unit)));
    }

    /// Forgets a client.
    pub fn remove(&mut self, client: u64) {
        self.by_client.remove(&client);
    }

    /// Every live unit at the smallest interval that somebody wants.
    pub fn demand(&self) -> Demand {
        let mut demand = Demand::new();
        for (unit, interval) in self.by_client.values().flatten() {
            demand.entry(*unit).and_modify(|least| *least = (*interval).min(*least)).or_insert(*interval);
        }
        demand
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{Codec, Group};

    fn unit(level: u8, class: ErrorClass) -> UnitName {
        UnitName { cascade: 0, level, class, group: Group::Displacement, codec: Codec::I16 }
    }

    #[test]
    fn demand_is_the_union_at_the_smallest_interval() {
        let mut all = Subscriptions::new(64);
        let (a, b) = (unit(0, ErrorClass::Millimetre), unit(1, ErrorClass::Millimetre));
        all.replace(1, &[(a, 480), (b, 240)]).unwrap();
        all.replace(2, &[(b, 120)]).unwrap();
        assert_eq!(all.demand(), Demand::from([(a, 480), (b, 120)]));
        all.remove(2);
        assert_eq!(all.demand(), Demand::from([(a, 480), (b, 240)]));
        all.replace(1, &[]).unwrap();
        assert!(all.demand().is_empty());
    }

    #[test]
    fn at_the_limit_the_next_finer_live_class_serves() {
        let mut all = Subscriptions::new(2);
        let one = |level, class| (unit(level, class), 480);
        let (finest, fine) = (one(0, ErrorClass::HalfMillimetre), one(0, ErrorClass::Millimetre));
        all.replace(1, &[finest, fine]).unwrap();
        let coarse = one(0, ErrorClass::TwentyMillimetres);
        assert_eq!(all.replace(2, &[coarse]), Ok(vec![fine]), "the next finer, not the finest");
        assert_eq!(all.replace(3, &[fine, one(1, ErrorClass::Millimetre)]), Err(1));
        // A client's own units make room for what replaces them.
        all.remove(2);
        assert_eq!(all.replace(1, &[coarse]), Ok(vec![coarse]));
    }
}
