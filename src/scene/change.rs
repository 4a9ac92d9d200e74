//! A change of the sea while it runs: what the control log is made of.

use serde::{Deserialize, Deserializer, Serialize};

use super::bound::{SceneError, within};
use super::fade::MIN_FADE_TICKS;
use super::file::CascadesFile;
use super::water::Water;
use super::wind::WindSea;
use super::{CrossFade, Scene};
use crate::wire::{MAX_TICK, TICKS_PER_SECOND};

/// Longest transition: an hour.
pub const MAX_TRANSITION_TICKS: i64 = 3600 * TICKS_PER_SECOND;

/// What a change sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ChangeKind {
    /// The wind of a wind-driven sea.
    Wind {
        /// Speed 10 m above the water, m/s.
        speed_mps: f64,
        /// Where it comes from, degrees clockwise from north.
        direction_from_deg: f64,
    },
    /// The water body; what is `None` stays as it is.
    Water {
        /// Metres; infinity, which JSON writes as null, for the open ocean.
        #[serde(default, deserialize_with = "depth", skip_serializing_if = "Option::is_none")]
        depth_m: Option<f64>,
        /// Gravity, m/s^2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        gravity: Option<f64>,
    },
    /// How the sea is cut into cascades, and which winds it must serve.
    Layout {
        /// All of it, defaults included: a later version may have others.
        cascades: CascadesFile,
        /// `None`: as it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        wind_range_mps: Option<[f64; 2]>,
    },
}

/// Null is a depth, too.
fn depth<'de, D: Deserializer<'de>>(value: D) -> Result<Option<f64>, D::Error> {
    Ok(Some(Option::<f64>::deserialize(value)?.unwrap_or(f64::INFINITY)))
}

/// One entry of the control log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Checks the numbers by themselves, and brings equal ones into one form.
    ///
    /// # Errors
    /// [`SceneError::Bound`].
    pub fn check(self) -> Result<Self, SceneError> {
        match self {
            Self::Wind { speed_mps, direction_from_deg } => Ok(Self::Wind {
                speed_mps: WindSea::check_speed("speed_mps", speed_mps)?,
                direction_from_deg: WindSea::check_direction("direction_from_deg", direction_from_deg)?,
            }),
            Self::Water { depth_m: None, gravity: None } => {
                Err(SceneError::bound("depth_m", "absent", "there, or gravity: the change sets nothing"))
            }
            Self::Water { depth_m, gravity } => Ok(Self::Water {
                depth_m: depth_m.map(|depth_m| Water::check_depth("depth_m", depth_m)).transpose()?,
                gravity: gravity.map(|gravity| Water::check_gravity("gravity", gravity)).transpose()?,
            }),
            Self::Layout { cascades, wind_range_mps } => {
                cascades.check().map_err(|error| match error {
                    // Here they stand by themselves, not in a table of the scene.
                    SceneError::Bound { field, value, bound } => {
                        SceneError::bound(field.trim_start_matches("cascades."), value, bound)
                    }
                    error => error,
                })?;
                Ok(Self::Layout {
                    cascades,
                    wind_range_mps: wind_range_mps
                        .map(|range| WindSea::check_range("wind_range_mps", range))
                        .transpose()?,
                })
            }
        }
    }

    /// Checks that the scene in effect has what the change sets, and room for it.
    ///
    /// # Errors
    /// [`SceneError::Bound`]; the field `wind` when the sea is not wind-driven.
    pub fn fits(&self, scene: &Scene) -> Result<(), SceneError> {
        let driven = scene.sea.wind.zip(scene.wind_range_mps);
        if let (Self::Layout { cascades, .. }, Some(replay)) = (self, &scene.replay) {
            replay.check_size(&cascades.check()?)?;
        }
        match self {
            Self::Wind { speed_mps, .. } => {
                let Some((_, [low, high])) = driven else {
                    return Err(SceneError::bound("wind", "absent", "part of the scene: this sea is not wind-driven"));
                };
                within("speed_mps", *speed_mps, low, high).map(drop)
            }
            Self::Layout { wind_range_mps: Some(range), .. } => {
                let Some((wind, _)) = driven else {
                    let bound = "absent: this sea is not wind-driven";
                    return Err(SceneError::bound("wind_range_mps", format!("{range:?}"), bound));
                };
                if (range[0]..=range[1]).contains(&wind.speed_mps) {
                    return Ok(());
                }
                let bound = format!("a range that holds the wind in effect, {} m/s", wind.speed_mps);
                Err(SceneError::bound("wind_range_mps", format!("{range:?}"), bound))
            }
            Self::Water { .. } | Self::Layout { wind_range_mps: None, .. } => Ok(()),
        }
    }

    /// Makes the scene what it is after the change.
    pub fn apply(&self, scene: &mut Scene) {
        match self {
            Self::Wind { speed_mps, direction_from_deg } => {
                if let Some(wind) = &mut scene.sea.wind {
                    (wind.speed_mps, wind.direction_from_deg) = (*speed_mps, *direction_from_deg);
                }
            }
            Self::Water { depth_m, gravity } => {
                let water = &mut scene.sea.water;
                water.depth_m = depth_m.unwrap_or(water.depth_m);
                water.gravity = gravity.unwrap_or(water.gravity);
            }
            Self::Layout { cascades, wind_range_mps } => {
                // Checked before it was accepted: what can't be is left as it was.
                if let Ok(request) = cascades.check() {
                    scene.cascades = request;
                }
                scene.wind_range_mps = wind_range_mps.filter(|_| scene.sea.wind.is_some()).or(scene.wind_range_mps);
            }
        }
    }

    /// Shortest transition of such a change, ticks.
    fn least_transition(&self) -> i64 {
        if let Self::Layout { .. } = self { MIN_FADE_TICKS } else { 0 }
    }
}

impl Change {
    /// Checks an entry by itself: its ticks and its numbers.
    ///
    /// # Errors
    /// [`SceneError::Bound`].
    pub fn check(&self) -> Result<(), SceneError> {
        check_tick(self.effective_tick)?;
        let least = self.kind.least_transition();
        if !(least..=MAX_TRANSITION_TICKS).contains(&self.transition_ticks) {
            let bound = format!("from {least} to {MAX_TRANSITION_TICKS}");
            return Err(SceneError::bound("transition_ticks", self.transition_ticks, bound));
        }
        self.kind.clone().check().map(drop)
    }

    /// Ticks of a transition of so many seconds, for a change that acts at a tick.
    ///
    /// # Errors
    /// [`SceneError::Bound`] for a tick beyond the last or a transition too short or above [`MAX_TRANSITION_TICKS`].
    pub fn check_time(kind: &ChangeKind, effective_tick: i64, transition_s: f64) -> Result<i64, SceneError> {
        check_tick(effective_tick)?;
        let seconds = |ticks: i64| (ticks / TICKS_PER_SECOND) as f64;
        let (least, most) = (seconds(kind.least_transition()), seconds(MAX_TRANSITION_TICKS));
        let transition_s = within("transition_s", transition_s, least, most)?;
        Ok((transition_s * TICKS_PER_SECOND as f64).round() as i64)
    }

    /// Checks entries of a log against what is in effect when each acts: in order of (effective tick, sequence).
    ///
    /// # Errors
    /// The sequence of the first entry that can't act, and why.
    pub fn check_course<'a>(
        scene: &Scene,
        changes: impl IntoIterator<Item = &'a Self>,
    ) -> Result<(), (u64, SceneError)> {
        let mut ordered: Vec<&Self> = changes.into_iter().collect();
        ordered.sort_by_key(|change| (change.effective_tick, change.sequence));
        let (mut scene, mut free) = (scene.clone(), i64::MIN);
        for change in ordered {
            let at = |error| (change.sequence, error);
            change.check().and_then(|()| change.kind.fits(&scene)).map_err(at)?;
            if let Some(fade) = CrossFade::of(change) {
                if fade.from < free {
                    let bound = format!("{free} or later: the layout before it is not settled until then");
                    return Err(at(SceneError::bound("effective_tick", fade.from, bound)));
                }
                free = fade.over();
            }
            change.kind.apply(&mut scene);
        }
        Ok(())
    }
}

fn check_tick(effective_tick: i64) -> Result<(), SceneError> {
    if (0..=MAX_TICK).contains(&effective_tick) {
        return Ok(());
    }
    Err(SceneError::bound("effective_tick", effective_tick, "from 0 to 2^53 - 1"))
}
