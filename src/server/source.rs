//! Where frames come from: an engine that makes them, or a recording that has them.

use std::sync::Arc;

use super::player::Player;
use super::requests;
use crate::engine::{Counters, Engine, PointsWish};
use crate::plan::Demand;
use crate::sea::Timeline;
use crate::wire::{ClientError, Hello, SLOWEST_INTERVAL, TICKS_PER_SECOND, UnitName};

/// What a client can have, each unit with its interval.
type Units = Vec<(UnitName, i64)>;

/// The source of all frames.
pub enum Source {
    /// The sea is computed.
    Engine(Engine),
    /// It was.
    Recording(Player),
}

impl Source {
    /// The timeline from the next step on.
    pub fn set_timeline(&self, timeline: Arc<Timeline>) {
        if let Self::Engine(engine) = self {
            engine.set_timeline(timeline);
        }
    }

    /// What is wanted from now on.
    pub fn set_demand(&self, demand: Demand) {
        match self {
            Self::Engine(engine) => engine.set_demand(demand),
            Self::Recording(player) => player.set_wanted(!demand.is_empty()),
        }
    }

    /// Somebody begins to follow these units. In a recording they begin with each second.
    pub fn join(&self, units: Vec<UnitName>) {
        if let Self::Engine(engine) = self {
            engine.join(units);
        }
    }

    /// Points whose water is told; a recording has none.
    pub fn set_points(&self, points: Vec<PointsWish>) {
        if let Self::Engine(engine) = self {
            engine.set_points(points);
        }
    }

    /// Whether points can be followed.
    pub fn has_points(&self) -> bool {
        matches!(self, Self::Engine(_))
    }

    /// Makes no tick from this one on until told otherwise.
    pub fn hold(&self, tick: Option<i64>) {
        if let Self::Engine(engine) = self {
            engine.hold(tick);
        }
    }

    /// What has been done so far.
    pub fn counters(&self) -> Counters {
        match self {
            Self::Engine(engine) => engine.counters(),
            Self::Recording(player) => player.counters(),
        }
    }

    /// Whether there are frames to come.
    pub fn is_alive(&self) -> bool {
        match self {
            Self::Engine(engine) => engine.is_alive(),
            Self::Recording(player) => player.is_alive(),
        }
    }

    /// Whether the sea can be changed.
    pub fn can_change(&self) -> bool {
        matches!(self, Self::Engine(_))
    }

    /// What of this can be had.
    ///
    /// # Errors
    /// Index of the first unit that can't.
    pub fn grant(&self, asked: &[(UnitName, i64)]) -> Result<Units, usize> {
        match self {
            Self::Engine(_) => Ok(asked.to_vec()),
            Self::Recording(player) => player.offer.grant(asked),
        }
    }

    /// Why the unit of this index can't be had; at most `most` units are live at a time.
    pub fn refusal(&self, index: usize, most: usize) -> ClientError {
        match self {
            Self::Engine(_) => requests::unavailable(index, most),
            Self::Recording(player) => requests::not_recorded(index, &player.offer.units()),
        }
    }

    /// Says in a client's first message only what can be had.
    pub fn narrow(&self, hello: &mut Hello) {
        if let Self::Recording(player) = self {
            player.offer.narrow(hello);
        }
    }

    /// Ticks between moments at which a client can begin with a unit that is predicted.
    pub fn grid(&self) -> i64 {
        match self {
            Self::Engine(_) => SLOWEST_INTERVAL,
            Self::Recording(_) => TICKS_PER_SECOND,
        }
    }

    /// Waits until there is nothing more to come; an engine goes on for ever.
    pub async fn over(&self) {
        match self {
            Self::Engine(_) => std::future::pending().await,
            Self::Recording(player) => player.over().await,
        }
    }
}
