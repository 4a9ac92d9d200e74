//! What subscribers want, and how long a wish outlives the one who had it.

use std::collections::{BTreeMap, BTreeSet};

use super::field::Field;
use crate::wire::{Group, TICKS_PER_SECOND, UnitName};

/// Each live unit and the smallest interval, in ticks, at which somebody wants it.
pub type Demand = BTreeMap<UnitName, i64>;

/// How long a unit is made when nobody wants it any more, ticks: a client that joins again, or asks anew, finds
/// everything warm.
pub const LINGER_TICKS: i64 = 2 * TICKS_PER_SECOND;

/// Fields a group is made of, in the order of its channels.
pub fn fields_of(group: Group) -> &'static [Field] {
    match group {
        Group::Displacement => &[Field::Dx, Field::Height, Field::Dz],
        Group::Slopes => &[Field::SlopeX, Field::SlopeZ],
        Group::Derivatives => &[Field::Dxx, Field::Dzz, Field::Dxz],
        Group::Foam => &[Field::Foam],
        Group::Height => &[Field::Height],
        Group::Velocity => &[Field::VelocityX, Field::VelocityY, Field::VelocityZ],
        Group::Jacobian => &[Field::Jacobian, Field::Eigenvalue],
        Group::Stretch => &[Field::Dxx, Field::Dzz],
        Group::Normals => &[Field::NormalX, Field::NormalZ],
    }
}

/// Demand with hysteresis: it grows at once, and shrinks when it has been smaller for [`LINGER_TICKS`].
#[derive(Clone, Debug)]
pub struct Lingering {
    /// Most units that are made: what is wanted comes first.
    most: usize,
    wanted: Demand,
    /// What was wanted more before, each with the tick until which it is made.
    leaving: Vec<(UnitName, i64, i64)>,
}

impl Lingering {
    /// No demand yet; of units that nobody wants any more, only so many stay that there are `most` in all.
    pub fn new(most: usize) -> Self {
        Self { most, wanted: Demand::new(), leaving: Vec::new() }
    }

    /// Takes what is wanted from `now` on. An interval that is not above 0 is no wish.
    pub fn set(&mut self, mut wanted: Demand, now: i64) {
        wanted.retain(|_, interval| *interval > 0);
        for (unit, interval) in std::mem::replace(&mut self.wanted, wanted) {
            if self.wanted.get(&unit).is_none_or(|now| *now > interval) {
                self.leaving.push((unit, interval, now.saturating_add(LINGER_TICKS)));
            }
        }
        // What is wanted as often again does not leave; a unit leaves once, with its latest wish.
        let wanted = &self.wanted;
        self.leaving.retain(|(unit, interval, _)| wanted.get(unit).is_none_or(|now| now > interval));
        self.leaving.sort_by_key(|(unit, interval, until)| (*unit, *interval, -until));
        self.leaving.dedup_by_key(|(unit, interval, _)| (*unit, *interval));
        // Whoever changes a wish over and over must not have more made than the wishes of a moment.
        self.leaving.sort_by_key(|(_, _, until)| -until);
        let mut units: BTreeSet<UnitName> = self.wanted.keys().copied().collect();
        let most = self.most;
        self.leaving.retain(|(unit, ..)| units.contains(unit) || units.len() < most && units.insert(*unit));
    }

    /// What is made at `now`.
    pub fn at(&mut self, now: i64) -> Demand {
        self.leaving.retain(|(_, _, until)| *until > now);
        let mut demand = self.wanted.clone();
        for (unit, interval, _) in &self.leaving {
            demand.entry(*unit).and_modify(|least| *least = (*interval).min(*least)).or_insert(*interval);
        }
        demand
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{Codec, ErrorClass};

    const fn unit(level: u8) -> UnitName {
        UnitName { cascade: 0, level, class: ErrorClass::Millimetre, group: Group::Foam, codec: Codec::I16 }
    }

    #[test]
    fn demand_grows_at_once_and_shrinks_late() {
        let mut demand = Lingering::new(64);
        demand.set(Demand::from([(unit(0), 240)]), 0);
        demand.set(Demand::from([(unit(0), 120), (unit(1), 480)]), 10);
        assert_eq!(demand.at(10), Demand::from([(unit(0), 120), (unit(1), 480)]));
        // One leaves, one is wanted less often: both are made as before, for a while.
        demand.set(Demand::from([(unit(0), 480)]), 20);
        let until = 20 + LINGER_TICKS;
        assert_eq!(demand.at(until - 1), Demand::from([(unit(0), 120), (unit(1), 480)]));
        assert_eq!(demand.at(until), Demand::from([(unit(0), 480)]));
    }

    #[test]
    fn who_comes_back_in_time_finds_nothing_changed() {
        let mut demand = Lingering::new(64);
        let wish = Demand::from([(unit(0), 240)]);
        demand.set(wish.clone(), 0);
        for turn in 1..100 {
            demand.set(Demand::new(), turn * 1000);
            assert_eq!(demand.at(turn * 1000), wish);
            demand.set(wish.clone(), turn * 1000 + 500);
            assert_eq!(demand.at(turn * 1000 + 500), wish);
        }
        assert!(demand.leaving.len() <= 1);
    }

    #[test]
    fn wishes_that_come_and_go_are_few() {
        let mut demand = Lingering::new(64);
        for turn in 0..10_000 {
            demand.set(Demand::from([(unit((turn % 3) as u8), [120, 240, 480][(turn % 7) as usize % 3])]), turn);
        }
        assert!(demand.leaving.len() <= 9, "{} leave", demand.leaving.len());
    }

    #[test]
    fn no_more_units_are_made_than_may_be_wanted_at_a_time() {
        let mut demand = Lingering::new(3);
        for level in 0..60 {
            demand.set(Demand::from([(unit(level), 120), (unit(level + 1), 120)]), i64::from(level));
            let made = demand.at(i64::from(level));
            assert!(made.len() <= 3 && made.contains_key(&unit(level)) && made.contains_key(&unit(level + 1)));
            // The one that left last stays.
            assert!(level == 0 || made.contains_key(&unit(level - 1)));
        }
    }
}
