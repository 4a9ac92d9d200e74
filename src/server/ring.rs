//! The newest two seconds of frames, shared by all clients: each has a cursor, none has a queue.

use std::collections::VecDeque;
use std::sync::{PoisonError, RwLock};

use bytes::Bytes;

use crate::engine::Batch;
use crate::tile::SentFrame;
use crate::wire::TICKS_PER_SECOND;

/// How far back the ring reaches, ticks.
const SPAN: i64 = 2 * TICKS_PER_SECOND;

/// Frames that are on their way to clients. Invariant: frames are never copied, only counted references are.
#[derive(Debug)]
pub struct Ring {
    most_bytes: usize,
    held: RwLock<Held>,
}

#[derive(Debug, Default)]
struct Held {
    /// Serial number of the first batch.
    first: u64,
    batches: VecDeque<Ready>,
    bytes: usize,
}

#[derive(Debug)]
struct Ready {
    batch: Batch,
    /// Server time at which it was, microseconds.
    at_us: i64,
}

/// Where a client stands: a batch by serial number, and a frame in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cursor {
    batch: u64,
    frame: usize,
    /// Something of that batch was given.
    given: bool,
}

/// What [`Ring::take`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taken {
    /// Frames given.
    pub frames: u64,
    /// Their bytes.
    pub bytes: usize,
    /// The client had fallen behind and was moved to the newest batch.
    pub jumped: bool,
    /// There is more, which the budget did not reach.
    pub more: bool,
    /// When the first batch was ready of which all that is wanted has been given, microseconds of server time.
    pub ready_us: Option<i64>,
}

impl Ring {
    /// An empty ring that holds at most `most_bytes`, but always the newest batch.
    pub fn new(most_bytes: usize) -> Self {
        Self { most_bytes, held: RwLock::default() }
    }

    /// Adds the newest batch, ready at a time of the server, and lets go of the oldest.
    pub fn push(&self, batch: Batch, at_us: i64) {
        let mut held = self.held.write().unwrap_or_else(PoisonError::into_inner);
        let oldest = batch.tick.saturating_sub(SPAN);
        held.bytes += size(&batch);
        held.batches.push_back(Ready { batch, at_us });
        while held.batches.len() > 1
            && (held.bytes > self.most_bytes || held.batches.front().is_some_and(|ready| ready.batch.tick < oldest))
        {
            held.bytes -= held.batches.pop_front().map_or(0, |ready| size(&ready.batch));
            held.first += 1;
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.held.read().unwrap_or_else(PoisonError::into_inner).bytes
    }

    /// The cursor of a client that wants everything from `tick` on.
    pub fn at(&self, tick: i64) -> Cursor {
        let held = self.held.read().unwrap_or_else(PoisonError::into_inner);
        let before = held.batches.iter().rev().take_while(|ready| ready.batch.tick >= tick).count();
        Cursor { batch: held.first + (held.batches.len() - before) as u64, ..Cursor::default() }
    }

    /// Gives wanted frames from the cursor on, until `budget` bytes are reached or there are no more. A client whose
    /// next batch is gone, or is for a tick before `stale`, is moved to the newest batch.
    pub fn take(
        &self,
        cursor: &mut Cursor,
        stale: i64,
        budget: usize,
        mut wants: impl FnMut(&SentFrame) -> bool,
        mut give: impl FnMut(Bytes),
    ) -> Taken {
        let held = self.held.read().unwrap_or_else(PoisonError::into_inner);
        let newest = (held.first + held.batches.len() as u64).saturating_sub(1);
        let mut taken = Taken::default();
        if cursor.batch < held.first {
            (*cursor, taken.jumped) = (Cursor { batch: newest, ..Cursor::default() }, true);
        }
        while let Some(Ready { batch, at_us }) = held.batches.get((cursor.batch - held.first) as usize) {
            if batch.tick < stale && cursor.batch < newest {
                (*cursor, taken.jumped) = (Cursor { batch: newest, ..Cursor::default() }, true);
                continue;
            }
            while let Some(frame) = batch.frames.get(cursor.frame) {
                if taken.bytes >= budget {
                    return Taken { more: true, ..taken };
                }
                cursor.frame += 1;
                if wants(frame) {
                    cursor.given = true;
                    taken.frames += 1;
                    taken.bytes += frame.bytes.len();
                    give(frame.bytes.clone());
                }
            }
            if cursor.given {
                taken.ready_us.get_or_insert(*at_us);
            }
            *cursor = Cursor { batch: cursor.batch + 1, ..Cursor::default() };
        }
        taken
    }
}

fn size(batch: &Batch) -> usize {
    batch.frames.iter().map(|frame| frame.bytes.len()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Work;
    use crate::wire::{Codec, ErrorClass, Group, UnitName};

    const UNIT: UnitName =
        UnitName { cascade: 0, level: 0, class: ErrorClass::Millimetre, group: Group::Slopes, codec: Codec::I16 };

    fn push(ring: &Ring, tick: i64) {
        let bytes = Bytes::from(tick.to_le_bytes().to_vec());
        let frame = SentFrame { unit: UNIT, tick, depth: 0, bytes };
        ring.push(
            Batch {
                tick,
                frames: vec![frame.clone(), frame],
                points: Vec::new(),
                backend: "cpu",
                refused: 0,
                work: Work::default(),
                step_ms: 0.0,
            },
            tick,
        );
    }

    fn ticks(ring: &Ring, cursor: &mut Cursor, stale: i64, budget: usize) -> (Vec<i64>, bool) {
        let mut got = Vec::new();
        let give = |frame: Bytes| got.push(i64::from_le_bytes(frame[..8].try_into().unwrap()));
        let taken = ring.take(cursor, stale, budget, |frame| frame.tick % 240 == 0, give);
        (got, taken.jumped)
    }

    #[test]
    fn a_client_that_keeps_up_gets_every_wanted_frame_once() {
        let ring = Ring::new(1 << 20);
        let mut cursor = ring.at(0);
        let mut got = Vec::new();
        for tick in (0..=1200).step_by(120) {
            push(&ring, tick);
            // A budget below one frame: one frame at a time.
            for _ in 0..2 {
                got.extend(ticks(&ring, &mut cursor, 0, 1).0);
            }
        }
        assert_eq!(got, [0, 0, 240, 240, 480, 480, 720, 720, 960, 960, 1200, 1200]);
    }

    #[test]
    fn a_client_that_falls_behind_jumps_to_the_newest() {
        let ring = Ring::new(100 * 16);
        let mut cursor = ring.at(0);
        for tick in (0..=48_000).step_by(120) {
            push(&ring, tick);
        }
        assert_eq!(ring.bytes(), 100 * 16, "bounded by bytes");
        assert_eq!(ticks(&ring, &mut cursor, 0, usize::MAX), (vec![48_000; 2], true));
        assert_eq!(ticks(&ring, &mut cursor, 0, usize::MAX), (vec![], false));
        let mut cursor = ring.at(45_000);
        assert_eq!(ticks(&ring, &mut cursor, 47_000, usize::MAX), (vec![48_000; 2], true), "stale frames are not sent");
        let mut cursor = ring.at(47_000);
        assert_eq!(ticks(&ring, &mut cursor, 47_000, 1).0, [47_040]);
    }

    #[test]
    fn a_batch_is_told_when_the_last_that_is_wanted_of_it_was_given() {
        let ring = Ring::new(1 << 20);
        (0..=360).step_by(120).for_each(|tick| push(&ring, tick));
        let mut cursor = ring.at(0);
        let mut ready = || ring.take(&mut cursor, 0, 1, |frame| frame.tick % 240 == 0, |_| {}).ready_us;
        // Of 120 and 360 nothing is wanted.
        assert_eq!([ready(), ready(), ready(), ready()], [None, Some(0), None, Some(240)]);
    }

    #[test]
    fn the_ring_reaches_two_seconds_back_and_no_further() {
        let ring = Ring::new(usize::MAX);
        for tick in (0..72_000).step_by(120) {
            push(&ring, tick);
        }
        assert_eq!(ring.bytes() / 16, 121);
    }
}
