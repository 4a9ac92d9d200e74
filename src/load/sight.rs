//! What one client makes of what it receives: subscription, ages, gaps, faults. Knows no socket.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use super::figures::{Continuity, Histogram, Row};
use super::reader::{BadFrame, Head};
use super::stage::Stage;
use super::viewer::{Manner, Plan};
use crate::tile::Decoder;
use crate::wire::{
    ClientMessage, Hello, ServerMessage, Subscribe, Subscribed, TICKS_PER_SECOND, Time, UnitName, UnitRate, lead_of,
};

/// Samples of one moment that a client which decodes keeps for predictions: nine channels of three patches of 1024.
const MOST_SAMPLES: usize = 1 << 25;

/// What a client counted, and those that it replaced, from its first frame to its last; what `measured_` names, in the window alone.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// How it behaved.
    pub manner: Manner,
    /// It was granted a subscription.
    pub subscribed: bool,
    /// Why it ended before the end.
    pub ended: Option<String>,
    /// Frames in the window.
    pub measured_frames: u64,
    /// Their bytes, whole messages without the WebSocket's own few.
    pub measured_bytes: u64,
    /// Those of them that were late.
    pub measured_late: u64,
    /// Those of them that were of a coarser level than granted, as the server had said.
    pub measured_coarser: u64,
    /// The oldest of them, microseconds.
    pub measured_worst_us: i64,
    /// Different frames that came.
    pub came: u64,
    /// Ticks of its units' grids that never came.
    pub gaps: u64,
    /// What was wrong.
    pub faults: Faults,
    /// Frames that were decoded in full.
    pub decoded: u64,
    /// From waking to the first frame in time, microseconds.
    pub live_again_us: Option<i64>,
    /// It read on after a stall.
    pub woke: bool,
    /// Round trips of its time exchanges.
    pub round_trips: Histogram,
    /// What frames of each tile looked like, if it was to note that.
    pub noted: Vec<Noted>,
}

/// Things that are never right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Faults {
    /// Binary messages without a proper header, or not of the length it says.
    pub header: u64,
    /// Frames whose checksum is wrong.
    pub checksum: u64,
    /// Frames that could not be decoded.
    pub decode: u64,
    /// Frames of a unit, tick or timeline that was not subscribed.
    pub stray: u64,
    /// Frames that came twice.
    pub repeated: u64,
    /// Texts that are no message.
    pub text: u64,
}

impl Faults {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.header + self.checksum + self.decode + self.stray + self.repeated + self.text
    }

    /// Adds those of another client.
    pub fn add(&mut self, other: &Self) {
        self.header += other.header;
        self.checksum += other.checksum;
        self.decode += other.decode;
        self.stray += other.stray;
        self.repeated += other.repeated;
        self.text += other.text;
    }
}

/// Frames of one tile as a client saw them.
#[derive(Clone, Debug)]
pub struct Noted {
    /// The header of one.
    pub head: Head,
    /// Ticks between two.
    pub interval: i64,
    /// How many came.
    pub frames: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// A unit that was granted, or what comes in its place.
#[derive(Debug)]
struct Flow {
    interval: i64,
    coarser: bool,
    tiles: BTreeMap<[u16; 2], (Continuity, Option<Noted>)>,
}

/// A client's view of its stream, over all its connections.
pub struct Sight {
    plan: Plan,
    stage: Arc<Stage>,
    outcome: Outcome,
    decoder: Decoder,
    hello: Option<Box<Hello>>,
    epoch: u64,
    /// By cascade, level, class and group, with the interval.
    granted: Vec<([u8; 4], i64)>,
    /// By the same.
    flows: BTreeMap<[u8; 4], Flow>,
    subscriptions: u64,
    settled: bool,
    /// It came in the place of one that left, and has no subscription yet.
    replaces: bool,
    /// A stalled client: it has its subscription and stops reading.
    stalls: bool,
    woke_us: Option<i64>,
    /// Its frames count.
    live: bool,
    row: i64,
    part: Row,
}

impl Sight {
    /// The view of a client that has not connected yet.
    pub fn new(plan: Plan, stage: Arc<Stage>) -> Self {
        let outcome = Outcome {
            manner: plan.manner,
            subscribed: false,
            ended: None,
            measured_frames: 0,
            measured_bytes: 0,
            measured_late: 0,
            measured_coarser: 0,
            measured_worst_us: 0,
            came: 0,
            gaps: 0,
            faults: Faults::default(),
            decoded: 0,
            live_again_us: None,
            woke: false,
            round_trips: Histogram::default(),
            noted: Vec::new(),
        };
        Self {
            live: !matches!(plan.manner, Manner::Stalled(_)),
            plan,
            stage,
            outcome,
            decoder: Decoder::new(MOST_SAMPLES),
            hello: None,
            epoch: 0,
            granted: Vec::new(),
            flows: BTreeMap::new(),
            subscriptions: 0,
            settled: false,
            replaces: false,
            stalls: false,
            woke_us: None,
            row: 0,
            part: Row::default(),
        }
    }

    /// What the client is.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// A new connection begins; what was held is forgotten, but for what it counts.
    pub fn connect_anew(&mut self) {
        (self.hello, self.stalls) = (None, false);
        self.decoder = Decoder::new(MOST_SAMPLES);
        let flows = std::mem::take(&mut self.flows);
        self.close_books(flows);
    }

    /// It left as it was told to, and another takes its place.
    pub fn give_place(&mut self) {
        self.stage.turnover.left.fetch_add(1, Relaxed);
        (self.outcome.subscribed, self.replaces) = (false, true);
        self.connect_anew();
    }

    /// Whether it was granted its subscription.
    pub fn is_granted(&self) -> bool {
        self.outcome.subscribed
    }

    /// Whether it has just been granted what it will not read; once a connection.
    pub fn begins_to_stall(&mut self) -> bool {
        std::mem::take(&mut self.stalls)
    }

    /// It reads on.
    pub fn wake(&mut self, now_us: i64) {
        self.woke_us = Some(now_us);
        self.outcome.woke = true;
    }

    /// A request for the time, once there is a subscription.
    pub fn ask_time(&self, now_us: i64) -> Option<String> {
        let text = serde_json::to_string(&ClientMessage::Time(Time { t0: now_us as f64 }));
        text.ok().filter(|_| self.outcome.subscribed)
    }

    /// Takes a text; what to answer.
    ///
    /// # Errors
    /// Why nothing more can come.
    pub fn text(&mut self, text: &str, now_us: i64) -> Result<Option<String>, String> {
        match ServerMessage::parse(text) {
            Ok(Some(ServerMessage::Hello(hello))) => return self.greet(hello).map(Some),
            Ok(Some(ServerMessage::Subscribed(granted))) => self.subscribed(&granted),
            // Fewer frames are gaps in what was granted.
            Ok(Some(ServerMessage::Quality(quality))) => self.flow_at(quality.coarser),
            Ok(Some(ServerMessage::Time(answer))) => {
                if self.stage.ledger.measures(self.stage.ledger.row(now_us)) {
                    self.outcome.round_trips.add(now_us - answer.t0 as i64);
                }
            }
            Ok(Some(ServerMessage::Error { detail, .. })) => return Err(format!("refused: {detail}")),
            Ok(_) => {}
            Err(_) => self.outcome.faults.text += 1,
        }
        Ok(None)
    }

    /// The sea is this, or its layout changes: asks for what is wanted of it.
    fn greet(&mut self, hello: Box<Hello>) -> Result<String, String> {
        self.epoch = u64::from_str_radix(&hello.epoch, 16).unwrap_or_default();
        let units: Vec<UnitRate> = self.plan.choice.units(&hello).into_iter().map(UnitRate::from).collect();
        let rate_hz = self.plan.choice.rate_hz(&hello).ok_or("the server offers no rate")?;
        if units.is_empty() {
            return Err("the server has none of the units asked for".to_owned());
        }
        self.hello = Some(hello);
        self.subscriptions += 1;
        let subscribe = ClientMessage::Subscribe(Subscribe { id: self.subscriptions, rate_hz, units, keys: false });
        serde_json::to_string(&subscribe).map_err(|e| e.to_string())
    }

    fn subscribed(&mut self, granted: &Subscribed) {
        let unit = |UnitRate { unit, rate_hz }: &UnitRate| {
            let UnitName { cascade, level, class, group, .. } = unit;
            let rate_hz = i64::from(rate_hz.unwrap_or(granted.rate_hz));
            let interval = TICKS_PER_SECOND / rate_hz.clamp(1, TICKS_PER_SECOND);
            ([*cascade, *level, class.id(), group.id()], interval)
        };
        self.granted = granted.units.iter().map(unit).collect();
        self.flow_at(0);
        self.stalls = matches!(self.plan.manner, Manner::Stalled(_)) && self.woke_us.is_none();
        self.outcome.subscribed = true;
        if std::mem::take(&mut self.replaces) {
            self.stage.turnover.came.fetch_add(1, Relaxed);
        }
        self.settle();
    }

    /// Each unit comes so many levels coarser than granted, where its cascade has so many.
    fn flow_at(&mut self, coarser: u8) {
        let mut held = std::mem::take(&mut self.flows);
        let cascades = self.hello.iter().flat_map(|hello| &hello.layout.cascades);
        let levels: BTreeMap<u8, u8> = cascades.map(|cascade| (cascade.index, cascade.levels)).collect();
        for ([cascade, level, class, group], interval) in self.granted.clone() {
            let coarsest = levels.get(&cascade).map_or(level, |levels| levels.saturating_sub(1)).max(level);
            let sent = level.saturating_add(coarser).min(coarsest);
            let key = [cascade, sent, class, group];
            // What goes on flows without a gap.
            let flow = held.remove(&key).filter(|flow| flow.interval == interval);
            let new = || Flow { interval, coarser: sent > level, tiles: BTreeMap::new() };
            self.flows.insert(key, flow.unwrap_or_else(new));
        }
        self.close_books(held);
    }

    fn settle(&mut self) {
        if !std::mem::replace(&mut self.settled, true) {
            self.stage.settle();
        }
    }

    /// Takes a binary message that is no frame.
    pub fn bad(&mut self, bad: BadFrame) {
        match bad {
            BadFrame::Header | BadFrame::Length => self.outcome.faults.header += 1,
            BadFrame::Checksum => self.outcome.faults.checksum += 1,
        }
    }

    /// Takes a frame whose last byte was read at a time of ours.
    pub fn frame(&mut self, head: &Head, bytes: usize, whole: &[u8], now_us: i64) {
        let row = self.stage.ledger.row(now_us);
        if row != self.row {
            self.post();
            self.row = row;
        }
        self.part.bytes += bytes as u64;
        if self.plan.decodes {
            self.outcome.decoded += 1;
            self.outcome.faults.decode += u64::from(self.decoder.decode(whole).is_err());
        }
        let tick = i64::try_from(head.tick()).unwrap_or(i64::MAX);
        let flow = self.flows.get_mut(&head.unit()).filter(|flow| tick % flow.interval == 0);
        let (Some(hello), Some(flow)) = (&self.hello, flow) else {
            self.outcome.faults.stray += 1;
            return;
        };
        if head.epoch() != self.epoch {
            self.outcome.faults.stray += 1;
            return;
        }
        let server_us = self.stage.server_us(now_us);
        // Cubic interpolation needs two frames ahead of the moment that is shown.
        let late = server_us > us_of(tick - 2 * flow.interval);
        if !self.live {
            let Some(woke_us) = self.woke_us.filter(|_| !late) else { return };
            (self.live, self.outcome.live_again_us) = (true, Some(now_us - woke_us));
        }
        let (continuity, noted) = flow.tiles.entry(head.tile()).or_default();
        if !continuity.take(tick / flow.interval) {
            self.outcome.faults.repeated += 1;
            return;
        }
        if self.plan.notes {
            let noted =
                noted.get_or_insert_with(|| Noted { head: *head, interval: flow.interval, frames: 0, bytes: 0 });
            (noted.frames, noted.bytes) = (noted.frames + 1, noted.bytes + bytes as u64);
        }
        let age_us = server_us - us_of(tick - lead_of(tick, flow.interval, self.plan.choice.codec, hello.lead_ticks));
        self.part.frames += 1;
        self.part.late += u64::from(late);
        self.part.ages.add(age_us);
        if self.stage.ledger.measures(row) {
            self.outcome.measured_frames += 1;
            self.outcome.measured_bytes += bytes as u64;
            self.outcome.measured_late += u64::from(late);
            self.outcome.measured_coarser += u64::from(flow.coarser);
            self.outcome.measured_worst_us = self.outcome.measured_worst_us.max(age_us);
        }
    }

    /// Hands the row that is over to the books of all.
    fn post(&mut self) {
        let mut part = std::mem::take(&mut self.part);
        if self.plan.manner != Manner::Steady {
            if self.stage.ledger.measures(self.row) {
                self.stage.ledger.post_other(matches!(self.plan.manner, Manner::Stalled(_)), &part.ages);
            }
            part = Row { bytes: part.bytes, ..Row::default() };
        }
        if part.bytes > 0 {
            self.stage.ledger.post(self.row, &part);
        }
    }

    fn close_books(&mut self, flows: BTreeMap<[u8; 4], Flow>) {
        for (continuity, noted) in flows.into_values().flat_map(|flow| flow.tiles.into_values()) {
            self.outcome.came += continuity.came();
            self.outcome.gaps += continuity.missing();
            self.outcome.noted.extend(noted);
        }
    }

    /// The client's part is over.
    pub fn finish(mut self, ended: Option<String>) -> Outcome {
        self.post();
        self.settle();
        let flows = std::mem::take(&mut self.flows);
        self.close_books(flows);
        self.outcome.ended = ended;
        self.outcome
    }
}

/// Server time of a tick, microseconds.
fn us_of(tick: i64) -> i64 {
    (i128::from(tick) * 1_000_000 / i128::from(TICKS_PER_SECOND)) as i64
}
