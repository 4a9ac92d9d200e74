//! The water at points that clients subscribe to: one message a client and tick, from the surface of that tick.

use std::sync::Arc;

use bytes::Bytes;

use super::answer::{ProbeAnswer, ProbeFields, from_grids};
use crate::backend::Surface;
use crate::plan::FieldSet;
use crate::scene::{Effects, Normals};
use crate::sea::Timeline;
use crate::tile::Stamp;
use crate::wire::{FLAG_JACOBIAN, FLAG_NORMAL, FLAG_VELOCITY, PointRecord, PointsHeader, write_points};

/// What a client wants to know of some points, and how often.
#[derive(Clone, Debug, PartialEq)]
pub struct PointsWish {
    /// Who.
    pub client: u64,
    /// Of the subscription.
    pub id: u64,
    /// Ticks between messages.
    pub interval: i64,
    /// World positions (x, z), metres.
    pub points: Arc<[[f64; 2]]>,
}

/// A message for one client.
#[derive(Clone, Debug)]
pub struct PointsMessage {
    /// For whom.
    pub client: u64,
    /// Of which subscription.
    pub id: u64,
    /// The tick.
    pub tick: i64,
    /// As it is sent.
    pub bytes: Bytes,
}

impl ProbeFields {
    /// All that a scene has.
    pub fn of(effects: &Effects) -> Self {
        Self { normal: effects.normals != Normals::None, velocity: effects.velocity, jacobian: effects.jacobian }
    }
}

/// Fields of a surface that points are read from.
pub fn fields_of_points(effects: &Effects) -> FieldSet {
    ProbeFields::of(effects).needed(effects.choppiness)
}

/// The message of a wish; `None` where a value is not finite.
pub(super) fn message(
    wish: &PointsWish,
    surface: &Surface,
    timeline: &Timeline,
    stamp: Stamp,
) -> Option<PointsMessage> {
    let wanted = ProbeFields::of(&timeline.scene().effects);
    let patches = timeline.layout().cascades.iter().map(|cascade| cascade.patch_m);
    let flag = |wanted: bool, flag: u32| if wanted { flag } else { 0 };
    let header = PointsHeader {
        flags: flag(wanted.normal, FLAG_NORMAL)
            | flag(wanted.velocity, FLAG_VELOCITY)
            | flag(wanted.jacobian, FLAG_JACOBIAN),
        tick: u64::try_from(stamp.tick).ok()?,
        epoch: stamp.epoch,
        sequence: stamp.sequence,
        id: wish.id,
    };
    let answers = from_grids(surface, patches, &wish.points, wanted);
    let bytes = write_points(&header, answers.iter().map(record))?;
    Some(PointsMessage { client: wish.client, id: wish.id, tick: stamp.tick, bytes: bytes.into() })
}

fn record(answer: &ProbeAnswer) -> PointRecord {
    let single = |vector: Option<[f64; 3]>| vector.unwrap_or_default().map(|v| v as f32);
    PointRecord {
        height: answer.height as f32,
        normal: single(answer.normal),
        velocity: single(answer.velocity),
        jacobian: answer.jacobian.unwrap_or_default() as f32,
        residual: answer.residual as f32,
        folded: answer.folded,
    }
}
