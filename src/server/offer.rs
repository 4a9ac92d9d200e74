//! What a recording has to offer: a part of what its sea could give.

use std::sync::{PoisonError, RwLock};

use crate::recording::Taken;
use crate::wire::{ErrorClass, Group, Hello, HelloDetail, TICKS_PER_SECOND, UnitName};

/// Units that were recorded, each with the ticks between its frames.
#[derive(Debug)]
pub struct Offer {
    units: RwLock<Vec<(UnitName, i64)>>,
}

impl Offer {
    /// What was recorded at first.
    pub fn new(taken: &Taken) -> Self {
        Self { units: RwLock::new(taken.intervals()) }
    }

    /// What was recorded from now on.
    pub fn replace(&self, taken: &Taken) {
        *self.units.write().unwrap_or_else(PoisonError::into_inner) = taken.intervals();
    }

    /// What was recorded.
    pub fn units(&self) -> Vec<UnitName> {
        self.units.read().unwrap_or_else(PoisonError::into_inner).iter().map(|(unit, _)| *unit).collect()
    }

    /// What a client gets that asks for these: each unit as it was recorded, or in the next finer class that was, and
    /// no more often.
    ///
    /// # Errors
    /// Index of the first unit that was not recorded.
    pub fn grant(&self, asked: &[(UnitName, i64)]) -> Result<Vec<(UnitName, i64)>, usize> {
        let units = self.units.read().unwrap_or_else(PoisonError::into_inner);
        let grant = |(index, (unit, interval)): (usize, &(UnitName, i64))| {
            let classes = ErrorClass::ALL[..=usize::from(unit.class.id())].iter().rev();
            let mut had = classes.filter_map(|class| {
                let unit = UnitName { class: *class, ..*unit };
                units.iter().find(|(had, _)| *had == unit)
            });
            had.next().map(|(unit, recorded)| (*unit, *interval.max(recorded))).ok_or(index)
        };
        asked.iter().enumerate().map(grant).collect()
    }

    /// Says of a sea only what was recorded.
    pub fn narrow(&self, hello: &mut Hello) {
        hello.limits.points = 0;
        let units = self.units.read().unwrap_or_else(PoisonError::into_inner);
        let fastest = units.iter().map(|(_, interval)| *interval).min().unwrap_or(TICKS_PER_SECOND);
        hello.rates_hz.retain(|rate| TICKS_PER_SECOND / i64::from(*rate).max(1) >= fastest);
        hello.classes.retain(|class| units.iter().any(|(unit, _)| unit.class == class.name));
        hello.groups.retain(|group| units.iter().any(|(unit, _)| unit.group == group.name));
        for cascade in &mut hello.layout.cascades {
            let recorded: Vec<_> = units.iter().filter(|(unit, _)| unit.cascade == cascade.index).collect();
            let detail = |group: Group| {
                let of_group = || recorded.iter().filter(|(unit, _)| unit.group == group);
                let finest_level = of_group().map(|(unit, _)| unit.level).min().unwrap_or(0);
                let rate_hz = of_group().map(|(_, interval)| (TICKS_PER_SECOND / interval) as u32).max();
                HelloDetail { group, finest_level, rate_hz: Some(rate_hz.unwrap_or(0)) }
            };
            cascade.detail = hello.groups.iter().map(|group| detail(group.name)).collect();
            cascade.levels = recorded.iter().map(|(unit, _)| unit.level.saturating_add(1)).max().unwrap_or(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Codec;

    #[test]
    fn a_client_gets_what_was_recorded_or_a_finer_class_of_it_and_nothing_else() {
        let unit = |class, level| UnitName { cascade: 1, level, class, group: Group::Foam, codec: Codec::Rans };
        let fine = unit(ErrorClass::Millimetre, 0);
        let offer = Offer::new(&Taken { rate_hz: 30, units: vec![fine.into()] });
        let coarse = unit(ErrorClass::TwentyMillimetres, 0);
        assert_eq!(offer.grant(&[(fine, 120), (coarse, 480)]), Ok(vec![(fine, 240), (fine, 480)]));
        assert_eq!(offer.grant(&[(fine, 240), (unit(ErrorClass::HalfMillimetre, 0), 240)]), Err(1));
        assert_eq!(offer.grant(&[(unit(ErrorClass::Millimetre, 1), 240)]), Err(0));
        assert_eq!(offer.grant(&[(UnitName { codec: Codec::I16, ..fine }, 240)]), Err(0));
    }
}
