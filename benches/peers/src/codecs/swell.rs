//! Swellcast's own codecs: the predicted stream as its clients get it, and 16-bit floats.

use std::ops::Range;

use swellcast::tile::{Decoder, Plane, SentFrame, Stamp, UnitEncoder, decode};
use swellcast::wire::{Codec, ErrorClass, Group, SLOWEST_INTERVAL, TICKS_PER_SECOND, UnitName};

use crate::{CHANNELS, GROUPS, N, Peer, Score, Sea, miss, timed};

/// Encoders of the three groups.
struct Encoders([UnitEncoder; 3]);

impl Encoders {
    fn new(codec: Codec, class: ErrorClass) -> Self {
        Self(GROUPS.map(|group| UnitEncoder::new(UnitName { cascade: 0, level: 0, class, group, codec })))
    }

    /// The frames that leave when this tick comes in; `key` asks for one that stands by itself.
    fn take(&mut self, tick: i64, channels: &[Vec<f32>], key: bool) -> Vec<SentFrame> {
        let stamp = Stamp { tick, epoch: 1, sequence: 0, layout: 0 };
        let mut frames = Vec::new();
        for (encoder, group) in self.0.iter_mut().zip(GROUPS) {
            if key {
                encoder.join();
            }
            let planes: Vec<Plane> = channels[span(group)].iter().map(|channel| Plane::Samples(channel)).collect();
            frames.extend(encoder.take(N, &planes, stamp).expect("finite"));
        }
        frames
    }
}

/// Where a group's channels stand.
fn span(group: Group) -> Range<usize> {
    let first = GROUPS.iter().take_while(|other| **other != group).map(|other| other.channels().len()).sum();
    first..first + group.channels().len()
}

/// What the headers of a class promise of each channel, and the step of its counts.
pub fn promises(class: ErrorClass, channels: &[Vec<f32>]) -> ([f32; CHANNELS], [f32; CHANNELS]) {
    let (mut bounds, mut steps) = ([0.0; CHANNELS], [0.0; CHANNELS]);
    for frame in Encoders::new(Codec::Rans, class).take(0, channels, true) {
        let header = decode(&frame.bytes).expect("a key frame").header;
        let (span, count) = (span(frame.unit.group), header.channels as usize);
        bounds[span.clone()].copy_from_slice(&header.max_error[..count]);
        steps[span].copy_from_slice(&header.step[..count]);
    }
    (bounds, steps)
}

/// The predicted stream. Who follows takes the deepest prediction of each tick; who asked for keys takes those too.
pub struct Swell {
    encoders: Encoders,
    follower: Decoder,
    joiner: Decoder,
    pub followed: Score,
    pub keyed: Score,
}

impl Swell {
    pub fn new(class: ErrorClass) -> Self {
        Self {
            encoders: Encoders::new(Codec::Rans, class),
            follower: Decoder::new(1 << 20),
            joiner: Decoder::new(1 << 20),
            followed: Score::default(),
            keyed: Score::default(),
        }
    }

    /// Takes a tick; what leaves is often of one before it. Only those of `counted` ticks are counted.
    pub fn tick(&mut self, tick: i64, sea: &Sea, bounds: [f32; CHANNELS], counted: &Range<i64>) {
        let key = tick % TICKS_PER_SECOND == 0;
        let (frames, encode_ms) = timed(|| self.encoders.take(tick, &sea[&tick], key));
        let (mut follow_ms, mut join_ms) = (0.0, 0.0);
        let mut last = None;
        for frame in frames {
            // Of a tick's frames the deepest prediction is the first.
            let follows = last.replace((frame.unit, frame.tick)) != Some((frame.unit, frame.tick));
            if !follows && frame.depth > 0 {
                continue;
            }
            let decoder = if follows { &mut self.follower } else { &mut self.joiner };
            let (decoded, decode_ms) = timed(|| decoder.decode(&frame.bytes).expect("a frame"));
            *if follows { &mut follow_ms } else { &mut join_ms } += decode_ms;
            if !counted.contains(&frame.tick) {
                continue;
            }
            let span = span(frame.unit.group);
            let fields = decoded.planes.iter().zip(&sea[&frame.tick][span.clone()]).zip(&bounds[span]);
            let worst = fields.map(|((got, want), bound)| miss(got, want) / bound).fold(0.0, f32::max);
            for score in [Some(&mut self.keyed), follows.then_some(&mut self.followed)].into_iter().flatten() {
                score.bytes += frame.bytes.len();
                score.worst = score.worst.max(worst);
            }
        }
        if counted.contains(&tick) {
            self.keyed.encode_ms.push(encode_ms);
            self.keyed.decode_ms.push(follow_ms + join_ms);
            self.followed.decode_ms.push(follow_ms);
            // Ticks at which frames for those who join are made besides are not those of a quiet stream.
            if tick % TICKS_PER_SECOND > 2 * SLOWEST_INTERVAL {
                self.followed.encode_ms.push(encode_ms);
            }
        }
    }
}

/// 16-bit floats as Swellcast sends them. They keep no bound.
pub struct Floats {
    encoders: Encoders,
    decoder: Decoder,
    frames: Vec<SentFrame>,
}

impl Floats {
    pub fn new() -> Self {
        let encoders = Encoders::new(Codec::F16, ErrorClass::Millimetre);
        Self { encoders, decoder: Decoder::new(1 << 20), frames: Vec::new() }
    }
}

impl Peer for Floats {
    fn encode(&mut self, channels: &[Vec<f32>]) -> usize {
        self.frames = self.encoders.take(0, channels, false);
        self.frames.iter().map(|frame| frame.bytes.len()).sum()
    }

    fn decode(&mut self, channels: &mut [Vec<f32>]) {
        for frame in &self.frames {
            let planes = self.decoder.decode(&frame.bytes).expect("a frame").planes;
            channels[span(frame.unit.group)].iter_mut().zip(planes).for_each(|(channel, plane)| *channel = plane);
        }
    }
}
