//! One stream client, in one task: reads its requests, sends what is due. Control first, then frames.
//!
//! Invariant: nothing is queued for a client but its own answers, and those are bounded. Changes, status and frames
//! are read from where they are shared, when its socket can take them.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::sync::Arc;

use tokio_websockets::Message;

use super::bulletin::Reader;
use super::farewell::{End, OVERFLOW};
use super::flow::Flow;
use super::hello::lead;
use super::ocean::{Client, Ocean};
use super::requests;
use super::ring::Cursor;
use super::socket::Socket;
use super::stream::Stream;
use crate::engine::interval_of_rate;
use crate::sea::Layout;
use crate::tile::SentFrame;
use crate::wire::{
    ClientError, ClientMessage, ErrorCode, MAX_MESSAGE_BYTES, Points, PointsSubscribed, SLOWEST_INTERVAL,
    ServerMessage, Subscribe, Subscribed, TICKS_PER_SECOND, TimeAnswer, UnitName, UnitRate,
};

/// Most answers that wait for the socket; a client that asks for more without reading is closed.
const LANE: usize = 64;
/// After this many messages that can't be parsed, the connection ends.
const MALFORMED: u32 = 16;
/// Subscriptions that may come at once, and how fast that allowance grows back: each is weighed against all clients'.
const SUBSCRIPTIONS: i64 = 32;
const TICKS_PER_SUBSCRIPTION: i64 = TICKS_PER_SECOND / 4;
/// Frames handed to the socket in one go: small ones share a system call.
const BURST: usize = 64 << 10;
/// Frames for a tick this long past are not worth sending: 250 ms.
const STALE: i64 = TICKS_PER_SECOND / 4;

/// Serves one client until it, or the server, ends the connection.
pub async fn serve(ocean: Arc<Ocean>, socket: Socket) {
    let stream = Stream::new(socket, MAX_MESSAGE_BYTES);
    let Some(client) = ocean.join() else {
        ocean.metrics.refused();
        return stream.part(Some(End::Close(1013, "the server is full"))).await;
    };
    let mut session = Session::new(ocean, client, stream);
    let end = session.run().await;
    let Session { client, mut stream, mut lane, ocean, .. } = session;
    // Its units may rest now: the close itself takes time.
    drop(client);
    while let Some(answer) = lane.pop_front() {
        stream.send(answer.stamped(&ocean));
    }
    stream.part(end).await;
}

enum Answer {
    Text(Message),
    /// Its second stamp is taken when it is written.
    Time {
        t0: f64,
        t1_us: i64,
    },
}

struct Session {
    ocean: Arc<Ocean>,
    client: Client,
    stream: Stream,
    reader: Reader,
    lane: VecDeque<Answer>,
    /// In order.
    units: Vec<Flow>,
    cursor: Cursor,
    /// It follows points.
    follows: bool,
    /// The tick up to which the allowance of subscriptions is used up.
    subscribed_until: i64,
    malformed: u32,
    /// Beats of the server at which the client was last heard, and pinged.
    heard: u64,
    pinged: u64,
}

impl Session {
    fn new(ocean: Arc<Ocean>, client: Client, stream: Stream) -> Self {
        let hello = ocean.hello();
        let (reader, beats) = (ocean.bulletin.reader(hello.sequence), ocean.bulletin.beats());
        let hello = ServerMessage::Hello(Box::new(hello)).to_json();
        Self {
            ocean,
            client,
            stream,
            reader,
            lane: VecDeque::from([Answer::Text(Message::text(hello))]),
            units: Vec::new(),
            cursor: Cursor::default(),
            follows: false,
            subscribed_until: i64::MIN,
            malformed: 0,
            heard: beats,
            pinged: beats,
        }
    }

    async fn run(&mut self) -> Option<End> {
        let (mut pulse, closing) = (self.ocean.bulletin.pulse(), self.ocean.bulletin.closing());
        loop {
            // Whatever happens from here on wakes the wait below.
            pulse.mark_unchanged();
            if *closing.borrow() {
                return Some(End::Close(1001, "the server shuts down"));
            }
            let beats = self.ocean.bulletin.beats();
            if beats - self.heard > self.ocean.settings.silence.as_secs() {
                return None;
            }
            if !self.stream.flushing()
                && let Err(end) = self.fill(beats)
            {
                return Some(end);
            }
            let seen = tokio::select! {
                biased;
                seen = poll_fn(|cx| self.stream.look(cx)) => seen,
                _ = pulse.changed() => continue,
            };
            match seen {
                Ok(Some(message)) => {
                    self.heard = beats;
                    if let Err(end) = self.hear(&message) {
                        return Some(end);
                    }
                }
                Ok(None) => {}
                Err(end) => return end,
            }
        }
    }

    /// Hands the idle socket what is due.
    fn fill(&mut self, beats: u64) -> Result<(), End> {
        while let Some(answer) = self.lane.pop_front() {
            let message = answer.stamped(&self.ocean);
            self.stream.send(message);
        }
        if let Some(news) = self.ocean.bulletin.news(&mut self.reader) {
            if news.missed {
                return Err(OVERFLOW);
            }
            // Its units so far are of layouts before: those of a number that the new one has are of one long gone.
            self.units.retain(|flow| !news.layouts.iter().any(|new| Layout::numbers(*new, flow.unit.cascade)));
            news.changes.into_iter().chain(news.status).for_each(|message| self.stream.send(message));
        }
        if beats - self.pinged >= self.ocean.settings.ping.as_secs() {
            self.pinged = beats;
            self.stream.send(Message::ping(""));
        }
        if let Some(water) = if self.follows { self.client.water() } else { None } {
            self.ocean.metrics.sent(1, water.len() as u64);
            self.stream.send(Message::binary(water));
        }
        if self.units.is_empty() {
            return Ok(());
        }
        let (units, stream) = (&mut self.units, &mut self.stream);
        let wants = |frame: &SentFrame| {
            let at = units.binary_search_by_key(&frame.unit, |flow| flow.unit);
            at.is_ok_and(|at| units[at].takes(frame))
        };
        let stale = self.ocean.tick() - STALE;
        let taken = self.ocean.ring.take(&mut self.cursor, stale, BURST, wants, |frame| {
            stream.send(Message::binary(frame));
        });
        if taken.frames > 0 {
            self.ocean.metrics.sent(taken.frames, taken.bytes as u64);
        }
        if taken.jumped {
            self.ocean.metrics.jumped();
        }
        self.ask_for_keys();
        Ok(())
    }

    /// Asks for key frames of the units whose frames this client can't read.
    fn ask_for_keys(&mut self) {
        let lost: Vec<UnitName> =
            self.units.iter_mut().filter_map(|flow| flow.is_lost().then_some(flow.unit)).collect();
        if !lost.is_empty() {
            self.client.join_units(lost);
        }
    }

    fn hear(&mut self, message: &Message) -> Result<(), End> {
        if message.is_binary() {
            return Err(End::Close(1003, "clients send text"));
        }
        let Some(text) = message.as_text() else { return Ok(()) };
        if self.lane.len() >= LANE {
            return Err(OVERFLOW);
        }
        let t1_us = self.ocean.clock.now_us();
        match ClientMessage::parse(text) {
            Ok(ClientMessage::Time(time)) => self.lane.push_back(Answer::Time { t0: time.t0, t1_us }),
            Ok(ClientMessage::Subscribe(subscribe)) => {
                let id = subscribe.id;
                let answer = match self.subscribe(subscribe) {
                    Ok(subscribed) => ServerMessage::Subscribed(subscribed),
                    Err(error) => requests::refusal(error, Some(id)),
                };
                self.answer(&answer);
            }
            Ok(ClientMessage::Points(points)) => {
                let id = points.id;
                let answer = match self.follow(points) {
                    Ok(subscribed) => ServerMessage::PointsSubscribed(subscribed),
                    Err(error) => requests::refusal(error, Some(id)),
                };
                self.answer(&answer);
            }
            Err(error) => {
                let parsed = matches!(error.code, ErrorCode::Invalid | ErrorCode::Unavailable);
                self.answer(&requests::refusal(error, requests::id_of(text)));
                self.malformed += u32::from(!parsed);
                if self.malformed >= MALFORMED {
                    return Err(End::Close(1008, "too many messages that can't be parsed"));
                }
            }
        }
        Ok(())
    }

    fn answer(&mut self, message: &ServerMessage) {
        self.lane.push_back(Answer::Text(Message::text(message.to_json())));
    }

    /// Uses up a part of the allowance of subscriptions.
    fn allow(&mut self, now: i64) -> Result<(), ClientError> {
        let least = now.saturating_sub(SUBSCRIPTIONS * TICKS_PER_SUBSCRIPTION);
        let used = self.subscribed_until.max(least) + TICKS_PER_SUBSCRIPTION;
        if used > now {
            let detail = format!("more than {SUBSCRIPTIONS} subscriptions at once, or 4 a second for long");
            return Err(ClientError { code: ErrorCode::Unavailable, field: None, detail });
        }
        self.subscribed_until = used;
        Ok(())
    }

    fn follow(&mut self, points: Points) -> Result<PointsSubscribed, ClientError> {
        let interval = requests::check_points(&points)?;
        self.allow(self.ocean.tick())?;
        let Points { id, rate_hz, points } = points;
        let count = points.len();
        let from_tick = self.client.follow(id, interval, points);
        let from_tick = from_tick.map_err(|left| requests::no_room_for_points(count, left))?;
        self.follows = count > 0;
        Ok(PointsSubscribed { id, rate_hz, from_tick, count: count as u32 })
    }

    fn subscribe(&mut self, subscribe: Subscribe) -> Result<Subscribed, ClientError> {
        let now = self.ocean.tick();
        let asked = requests::check(&subscribe, &self.ocean.current().timeline, now)?;
        self.allow(now)?;
        let granted = self.client.subscribe(&asked);
        let granted = granted.map_err(|index| requests::unavailable(index, self.ocean.settings.live_units))?;
        // Read after the engine was told: frames up to here may have left without the new units.
        let begun = self.ocean.tick() + lead();
        let held = std::mem::take(&mut self.units);
        // Where frames are predicted the first is one of the lowest rate.
        let first = |unit: &UnitName, interval: i64| {
            let grid = if unit.codec.predicts() { SLOWEST_INTERVAL } else { interval };
            (begun / grid + 1) * grid
        };
        let flow = |(unit, interval): &(UnitName, i64)| {
            // A unit that goes on flows without a gap.
            let known = held.binary_search_by_key(unit, |flow| flow.unit).map(|at| held[at]);
            let flow = known.map(|flow| flow.every(*interval));
            flow.unwrap_or_else(|_| Flow::new(*unit, *interval, first(unit, *interval)))
        };
        self.units = granted.iter().map(flow).collect();
        // Of a unit that was asked for twice the shorter interval stays.
        self.units.sort_unstable_by_key(|flow| (flow.unit, flow.interval));
        self.units.dedup_by_key(|flow| flow.unit);
        let is_new = |unit: &UnitName| held.binary_search_by_key(unit, |flow| flow.unit).is_err();
        let new = granted.iter().map(|(unit, _)| *unit).filter(|unit| unit.codec.predicts() && is_new(unit));
        self.client.join_units(new.collect());
        let slowest = interval_of_rate(subscribe.rate_hz);
        let from_tick = granted.iter().map(|(unit, interval)| first(unit, *interval)).min();
        let from_tick = from_tick.unwrap_or((begun / slowest + 1) * slowest);
        if held.is_empty() {
            self.cursor = self.ocean.ring.at(from_tick);
        }
        let rate = |interval: i64| Some((TICKS_PER_SECOND / interval) as u32).filter(|rate| *rate != subscribe.rate_hz);
        let units = granted.into_iter().map(|(unit, interval)| UnitRate { unit, rate_hz: rate(interval) }).collect();
        Ok(Subscribed { id: subscribe.id, rate_hz: subscribe.rate_hz, units, from_tick })
    }
}

impl Answer {
    fn stamped(self, ocean: &Ocean) -> Message {
        match self {
            Self::Text(message) => message,
            Self::Time { t0, t1_us } => {
                let t2_us = ocean.clock.now_us();
                Message::text(ServerMessage::Time(TimeAnswer { t0, t1_us, t2_us }).to_json())
            }
        }
    }
}
