//! The counts of a tile at its recent ticks: what later frames are predicted from. The same at both ends.

use std::collections::VecDeque;
use std::sync::Arc;

use super::predict::Basis;
use crate::wire::{BETWEEN, MAX_DEPTH, SLOWEST_INTERVAL, layer_of};

/// All channels of a tile at one tick, one after the other.
pub type Counts = Arc<[i16]>;

/// What is held of a tile.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Frames of the lowest rate, the newest first.
    base: VecDeque<(i64, Counts)>,
    /// The newest frame halfway between two of those.
    middle: Option<(i64, Counts)>,
}

impl History {
    /// How many frames of the lowest rate, of so many counts each, are held without a gap before this tick.
    pub fn depth(&self, tick: i64, counts: usize) -> u8 {
        let held = |back: &u8| self.at(tick - i64::from(*back) * SLOWEST_INTERVAL).is_some_and(|h| h.len() == counts);
        (1..=MAX_DEPTH).take_while(held).count() as u8
    }

    /// What channel `channel` of a frame is predicted from; `None` where something of that is not held.
    pub fn basis(&self, tick: i64, depth: u8, channel: usize, samples: usize) -> Option<Basis<'_>> {
        let plane = |tick: i64| self.at(tick)?.get(channel * samples..(channel + 1) * samples);
        match depth {
            0 => Some(Basis::Space),
            BETWEEN => {
                let gap = (SLOWEST_INTERVAL / 2) >> (layer_of(tick) - 1);
                Some(Basis::Between(plane(tick - gap)?, plane(tick + gap)?))
            }
            _ => {
                let mut past: [&[i16]; 3] = [&[]; 3];
                for (back, slot) in past.iter_mut().enumerate().take(depth.into()) {
                    *slot = plane(tick - (back as i64 + 1) * SLOWEST_INTERVAL)?;
                }
                Some(Basis::Past(past))
            }
        }
    }

    /// Keeps a frame that others may be predicted from.
    pub fn keep(&mut self, tick: i64, counts: Counts) {
        match layer_of(tick) {
            0 => {
                // A frame again, or one of another past: what is newer has nothing to do with it.
                self.base.retain(|(held, _)| *held < tick);
                self.base.push_front((tick, counts));
                self.base.truncate(MAX_DEPTH.into());
            }
            1 => self.middle = Some((tick, counts)),
            _ => {}
        }
    }

    fn at(&self, tick: i64) -> Option<&Counts> {
        let held = self.base.iter().chain(&self.middle).find(|(held, _)| *held == tick);
        held.map(|(_, counts)| counts)
    }
}
