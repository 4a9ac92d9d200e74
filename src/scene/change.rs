//! A change of the sea while it runs: what the control log is made of.

use serde::{Deserialize, Serialize};

use super::bound::{SceneError, within};
use super::sea_state::SeaState;
use super::water::Water;
use super::wind::WindSea;
use crate::wire::{MAX_TICK, TICKS_PER_SECOND};

/// Longest transition: an hour.
pub const MAX_TRANSITION_TICKS: i64 = 3600 * TICKS_PER_SECOND;

/// What a change sets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ChangeKind {
    /// The wind of a wind-driven sea.
    Wind {
        /// Speed 10 m above the water, m/s.
        speed_mps: f64,
        /// Where it comes from, degrees clockwise from north.
        direction_from_deg: f64,
    },
    /// The depth of the water.
    Water {
        /// Metres; `None` for the open ocean.
        depth_m: Option<f64>,
    },
}

/// One entry of the control log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Place in the log, from 1.
    pub sequence: u64,
    /// The tick at which it begins to act.
    pub effective_tick: i64,
    /// How long the sea takes to follow.
    pub transition_ticks: i64,
    /// What it sets.
    pub kind: ChangeKind,
}

impl ChangeKind {
    /// Checks the numbers, and that the sea has what the change sets.
    ///
    /// # Errors
    /// [`SceneError::Bound`]; the field `wind` when the sea is not wind-driven.
    pub fn check(self, sea: &SeaState, wind_range_mps: Option<[f64; 2]>) -> Result<Self, SceneError> {
        match self {
            Self::Wind { speed_mps, direction_from_deg } => {
                let (Some(_), Some([low, high])) = (sea.wind, wind_range_mps) else {
                    return Err(SceneError::bound("wind", "absent", "part of the scene: this sea is not wind-driven"));
                };
                Ok(Self::Wind {
                    speed_mps: within("speed_mps", speed_mps, low, high)?,
                    direction_from_deg: WindSea::check_direction("direction_from_deg", direction_from_deg)?,
                })
            }
            Self::Water { depth_m: Some(depth_m) } => {
                let depth_m = Water::check_depth("depth_m", depth_m)?;
                Ok(Self::Water { depth_m: depth_m.is_finite().then_some(depth_m) })
            }
            Self::Water { depth_m: None } => Ok(self),
        }
    }

    /// The sea after the change.
    pub fn apply(self, sea: &SeaState) -> SeaState {
        let mut next = sea.clone();
        match self {
            Self::Wind { speed_mps, direction_from_deg } => {
                if let Some(wind) = &mut next.wind {
                    (wind.speed_mps, wind.direction_from_deg) = (speed_mps, direction_from_deg);
                }
            }
            Self::Water { depth_m } => next.water.depth_m = depth_m.unwrap_or(f64::INFINITY),
        }
        next
    }
}

impl Change {
    /// Checks the ticks of an entry.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for a tick beyond the last or a transition above [`MAX_TRANSITION_TICKS`].
    pub fn check_ticks(effective_tick: i64, transition_ticks: i64) -> Result<(), SceneError> {
        if !(0..=MAX_TICK).contains(&effective_tick) {
            return Err(SceneError::bound("effective_tick", effective_tick, "from 0 to 2^53 - 1"));
        }
        if !(0..=MAX_TRANSITION_TICKS).contains(&transition_ticks) {
            let bound = format!("from 0 to {MAX_TRANSITION_TICKS}");
            return Err(SceneError::bound("transition_ticks", transition_ticks, bound));
        }
        Ok(())
    }

    /// Checks when a change acts.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for a tick beyond the last or a transition above [`MAX_TRANSITION_TICKS`].
    pub fn check_time(effective_tick: i64, transition_s: f64) -> Result<(i64, i64), SceneError> {
        Self::check_ticks(effective_tick, 0)?;
        let seconds = within("transition_s", transition_s, 0.0, (MAX_TRANSITION_TICKS / TICKS_PER_SECOND) as f64)?;
        Ok((effective_tick, (seconds * TICKS_PER_SECOND as f64).round() as i64))
    }
}
