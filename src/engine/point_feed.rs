//! The water at points that clients subscribe to: one message a client and tick, from the surface of that tick.
//!
//! Frames of the tick leave together with them, so the work is shared out evenly among the threads and bounded: a point
//! that a few steps don't find is told as folded.

use std::sync::Arc;

use bytes::Bytes;
use rayon::prelude::*;

use super::answer::{ProbeAnswer, ProbeFields, from_grids, from_trochoids};
use crate::backend::Surface;
use crate::pass::trochoid::Trochoids;
use crate::plan::FieldSet;
use crate::scene::{Effects, Model, Normals, Scene};
use crate::sea::Layout;
use crate::tile::Stamp;
use crate::wire::{FLAG_JACOBIAN, FLAG_NORMAL, FLAG_VELOCITY, PointRecord, PointsHeader, write_points};

/// Most steps of the search for a point. Where the surface doesn't fold a handful is enough.
const STEPS: u32 = 20;
/// Points that one thread takes at a time, whoever follows them.
const CHUNK: usize = 256;

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

/// Fields of a surface that points are read from; none where the model is evaluated at the points themselves.
pub fn fields_of_points(scene: &Scene) -> FieldSet {
    match scene.model {
        Model::Fft => ProbeFields::of(&scene.effects).needed(scene.effects.choppiness),
        Model::Trochoid(_) => FieldSet::NONE,
    }
}

/// What points are read from.
#[derive(Clone, Copy)]
pub(super) enum Water<'a> {
    /// Grids of the cascades of a layout.
    Grids(&'a Surface, &'a Layout),
    /// Trochoids, one for each cascade.
    Trochoids(&'a [Trochoids]),
}

impl Water<'_> {
    fn at(self, tick: i64, points: &[[f64; 2]], wanted: ProbeFields) -> Vec<PointRecord> {
        let answers = match self {
            Self::Grids(surface, layout) => {
                let patches = layout.cascades.iter().map(|cascade| cascade.patch_m);
                from_grids(surface, patches, points, wanted, Some(STEPS))
            }
            Self::Trochoids(cascades) => from_trochoids(cascades, tick, points, wanted),
        };
        answers.iter().map(record).collect()
    }
}

/// The messages of these wishes; `None` in place of one with a value that is not finite. Call it on the threads that are
/// to do it.
pub(super) fn messages(
    wishes: &[PointsWish],
    water: Water,
    wanted: ProbeFields,
    stamp: Stamp,
) -> Vec<Option<PointsMessage>> {
    // Chunks of all wishes at once: one client with many points must not be one thread's work.
    let chunks: Vec<&[[f64; 2]]> = wishes.iter().flat_map(|wish| wish.points.chunks(CHUNK)).collect();
    let mut read: Vec<Vec<PointRecord>> = Vec::new();
    chunks.into_par_iter().map(|points| water.at(stamp.tick, points, wanted)).collect_into_vec(&mut read);
    let mut read = read.as_slice();
    let shares = wishes.iter().map(|wish| {
        let (here, rest) = read.split_at(wish.points.len().div_ceil(CHUNK));
        read = rest;
        (wish, here)
    });
    let shares: Vec<(&PointsWish, &[Vec<PointRecord>])> = shares.collect();
    shares.into_par_iter().map(|(wish, records)| message(wish, records, wanted, stamp)).collect()
}

fn message(
    wish: &PointsWish,
    records: &[Vec<PointRecord>],
    wanted: ProbeFields,
    stamp: Stamp,
) -> Option<PointsMessage> {
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
    let bytes = write_points(&header, records.iter().flatten().copied());
    if bytes.is_none() {
        tracing::error!(tick = stamp.tick, client = wish.client, id = wish.id, "points refused: a value is not finite");
    }
    Some(PointsMessage { client: wish.client, id: wish.id, tick: stamp.tick, bytes: bytes?.into() })
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
