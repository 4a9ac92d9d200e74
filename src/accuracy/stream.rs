//! What is sent: floats and counts of every error class, predicted or each frame by itself.

use std::ops::Range;

use super::axis::{Draft, axis};
use super::errors::{Errors, Particle};
use super::ground::{Ground, LOOKED_AT, Made, fields_on_grid, particles, sampled_on_grid};
use super::received::{planes, received};
use super::report::{Axis, Cost, Measure};
use crate::backend::Surface;
use crate::engine::Times;
use crate::plan::{Field, fields_of};
use crate::sea::{CascadeModes, Sea};
use crate::tile::{Stamp, UnitEncoder};
use crate::wire::{Codec, ErrorClass, Group, SLOWEST_INTERVAL, TICKS_PER_SECOND, UnitName};

/// What is sent of every cascade: displacement, and what exact normals are made of.
const GROUPS: [Group; 3] = [Group::Displacement, Group::Slopes, Group::Derivatives];
/// Ticks between frames: 30 Hz.
const INTERVAL: i64 = 240;

/// One way to send the sea.
#[derive(Clone, Copy)]
struct Way {
    codec: Codec,
    class: ErrorClass,
    /// Every frame is a key frame.
    keys: bool,
}

impl Way {
    fn unit(self, cascade: u8, group: Group) -> UnitName {
        UnitName { cascade, level: 0, class: self.class, group, codec: self.codec }
    }

    fn name(self) -> String {
        match (self.codec, self.keys) {
            (Codec::F32 | Codec::F16, _) => self.codec.name().to_owned(),
            (Codec::I16, _) => format!("{}, counts uncoded", self.class.name()),
            (_, true) => format!("{}, key frames alone", self.class.name()),
            (_, false) => format!("{}, predicted", self.class.name()),
        }
    }
}

/// Every way.
fn ways() -> Vec<Way> {
    let way = |codec, class, keys| Way { codec, class, keys };
    let finest = ErrorClass::HalfMillimetre;
    let mut ways = vec![way(Codec::F32, finest, false), way(Codec::F16, finest, false), way(Codec::I16, finest, false)];
    for class in ErrorClass::ALL {
        ways.extend([way(Codec::Rans, class, true), way(Codec::Rans, class, false)]);
    }
    ways
}

/// What one way has sent so far.
struct Sender {
    way: Way,
    units: Vec<UnitName>,
    encoders: Vec<UnitEncoder>,
    bytes: usize,
    times: Vec<f64>,
}

impl Sender {
    fn new(way: Way, sea: &Sea) -> Self {
        let of = |modes: &CascadeModes| GROUPS.map(|group| way.unit(modes.cascade.index, group));
        let units: Vec<UnitName> = sea.cascades.iter().flat_map(of).collect();
        Self {
            way,
            encoders: units.iter().map(|unit| UnitEncoder::new(*unit)).collect(),
            units,
            bytes: 0,
            times: Vec::new(),
        }
    }

    /// Sends a surface; of the bytes those of frames in `counted`, and the time, count.
    fn send(&mut self, surface: &Surface, counted: &Range<i64>, ground: &Ground) {
        // What is predicted from nothing has no use for frames before and after.
        if (self.way.keys || !self.way.codec.predicts()) && !counted.contains(&surface.tick) {
            return;
        }
        // Whoever has nothing to predict from makes key frames, and those are of the lowest rate.
        let tick = if self.way.keys { surface.tick * (SLOWEST_INTERVAL / INTERVAL) } else { surface.tick };
        if self.way.keys {
            self.encoders = self.units.iter().map(|unit| UnitEncoder::new(*unit)).collect();
        }
        let (stamp, started) = (Stamp { tick, epoch: 1, sequence: 0, layout: 0 }, ground.clock.now_us());
        let surfaces = surface.cascades.iter().flat_map(|cascade| [cascade; GROUPS.len()]);
        let mut sent = Vec::new();
        for ((cascade, unit), encoder) in surfaces.zip(&self.units).zip(&mut self.encoders) {
            let planes = planes(cascade, *unit).unwrap_or_default();
            sent.push(encoder.take(cascade.n, &planes, stamp).unwrap_or_default());
        }
        let ms = (ground.clock.now_us() - started) as f64 / 1e3;
        let counts = |sent: i64| counted.contains(&if self.way.keys { surface.tick } else { sent });
        self.times.extend(counts(surface.tick).then_some(ms));
        for frames in &sent {
            // Of one tick the deepest predictions stand first; the others are for whoever joins.
            for (i, frame) in frames.iter().enumerate() {
                let first = frames[..i].iter().all(|before| before.tick != frame.tick || before.depth == frame.depth);
                self.bytes += if first && counts(frame.tick) { frame.bytes.len() } else { 0 };
            }
        }
    }
}

/// Every way to send all cascades.
pub fn stream(ground: &Ground) -> Axis {
    let sea = &ground.sea;
    let truth = particles(&fields_on_grid(sea, ground.tick, &ground.spots));
    let mut made = Made::new(sea.clone(), LOOKED_AT, &ground.scene.effects);
    let mut senders: Vec<Sender> = ways().into_iter().map(|way| Sender::new(way, sea)).collect();
    // Predictions reach back, and frames between two wait for the second of them.
    let frames = if ground.quick { 8 } else { 60 };
    let begin = ground.tick / TICKS_PER_SECOND * TICKS_PER_SECOND;
    let counted = begin..begin + frames * INTERVAL;
    for tick in (begin - 4 * SLOWEST_INTERVAL..counted.end + 2 * SLOWEST_INTERVAL).step_by(INTERVAL as usize) {
        let surface = made.step(tick);
        senders.iter_mut().for_each(|sender| sender.send(surface, &counted, ground));
    }
    let lasted = (counted.end - counted.start) as f64 / TICKS_PER_SECOND as f64;
    let draft = |sender: Sender| {
        let errors = Errors::of(&decoded(made.step(ground.tick), sea, sender.way, ground), &truth, ground.hs_m);
        Draft::new(sender.way.name(), errors).sending(sender.bytes as f64 / lasted).timed(Times::of(sender.times))
    };
    let drafts = senders.into_iter().map(draft).collect();
    let about = "What is sent of every cascade: displacement, slopes and derivatives, at 30 Hz. Predicted frames decode to the \
                 same counts as key frames. The time is that of encoding a frame of all, on one thread.";
    axis(ground, "codec", about, (Measure::Height, Cost::Bytes), drafts)
}

/// Particles that a client has after decoding.
fn decoded(surface: &Surface, sea: &Sea, way: Way, ground: &Ground) -> Vec<Particle> {
    let mut fields = vec![[(); Field::ALL.len()].map(|()| Vec::new()); sea.cascades.len()];
    for (fields, (cascade, modes)) in fields.iter_mut().zip(surface.cascades.iter().zip(&sea.cascades)) {
        for group in GROUPS {
            let planes = received(cascade, way.unit(modes.cascade.index, group)).unwrap_or_default();
            for (field, plane) in fields_of(group).iter().zip(planes) {
                fields[*field as usize] = plane;
            }
        }
    }
    let plane = |cascade: usize, field: Field| Some(fields[cascade][field as usize].as_slice());
    let plane = |cascade, field| plane(cascade, field).filter(|plane| !plane.is_empty());
    sampled_on_grid(plane, sea, &ground.spots).iter().map(Particle::of).collect()
}
