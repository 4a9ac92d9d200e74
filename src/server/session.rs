//! One stream client, in one task: reads its requests, sends what is due. Control first, then frames.
//!
//! Invariant: nothing is queued for a client but its own answers, and those are bounded. Changes, status and frames
//! are read from where they are shared, when its socket can take them.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::sync::Arc;
use std::task::Poll;

use tokio_websockets::Message;

use super::allowance::Allowance;
use super::bulletin::Reader;
use super::client::Client;
use super::egress::Admitted;
use super::farewell::{End, OVERFLOW};
use super::flows::{Flows, Granted, at_quality, first_tick};
use super::hello::reach;
use super::ocean::Ocean;
use super::quality::Ladder;
use super::requests;
use super::ring::Cursor;
use super::socket::Socket;
use super::stream::Stream;
use crate::engine::interval_of_rate;
use crate::sea::Layout;
use crate::wire::{
    ClientError, ClientMessage, ErrorCode, MAX_MESSAGE_BYTES, Points, PointsSubscribed, Quality, RATES_HZ,
    ServerMessage, Subscribe, Subscribed, TICKS_PER_SECOND, TimeAnswer, UnitName, UnitRate,
};

/// Most answers that wait for the socket; a client that asks for more without reading is closed.
const LANE: usize = 64;
/// After this many messages that can't be parsed, the connection ends.
const MALFORMED: u32 = 16;
/// Subscriptions that may come at once, and how fast that allowance grows back: each is weighed against all clients'.
const SUBSCRIPTIONS: i64 = 32;
const TICKS_PER_SUBSCRIPTION: i64 = TICKS_PER_SECOND / 4;
/// Messages of any kind that may come at once, and how fast that allowance grows back: 64 a second.
const MESSAGES: i64 = 256;
const TICKS_PER_MESSAGE: i64 = TICKS_PER_SECOND / 64;
/// Frames handed to the socket in one go: small ones share a system call.
const BURST: usize = 64 << 10;
/// Frames for a tick this long past are not worth sending: 250 ms.
const STALE: i64 = TICKS_PER_SECOND / 4;

/// Serves one client until it, or the server, ends the connection.
pub async fn serve(ocean: Arc<Ocean>, socket: Socket, admitted: Admitted) {
    let stream = Stream::new(socket, MAX_MESSAGE_BYTES);
    let Some(client) = ocean.join() else {
        ocean.metrics.refused();
        return stream.part(Some(End::Close(1013, "the server is full"))).await;
    };
    let mut session = Session::new(ocean, client, stream);
    let end = session.run().await;
    let Session { client, mut stream, mut lane, ocean, .. } = session;
    // Its units may rest now: the close itself takes time.
    drop((client, admitted));
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
    /// What it was granted, and what of that is sent.
    granted: Granted,
    flows: Flows,
    keys: bool,
    ladder: Ladder,
    cursor: Cursor,
    /// When what was handed to the socket last was ready.
    on_its_way: Option<i64>,
    /// It follows points.
    follows: bool,
    subscriptions: Allowance,
    messages: Allowance,
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
            granted: Granted::new(),
            flows: Flows::default(),
            keys: false,
            ladder: Ladder::new(RATES_HZ[0], beats),
            cursor: Cursor::default(),
            on_its_way: None,
            follows: false,
            subscriptions: Allowance::new(SUBSCRIPTIONS, TICKS_PER_SUBSCRIPTION),
            messages: Allowance::new(MESSAGES, TICKS_PER_MESSAGE),
            malformed: 0,
            heard: beats,
            pinged: beats,
        }
    }

    async fn run(&mut self) -> Option<End> {
        let (mut pulse, closing) = (self.ocean.bulletin.pulse(), self.ocean.bulletin.closing());
        // Something may be due that was not looked for yet.
        let mut due = true;
        loop {
            // Whatever happens from here on wakes the wait below. An error: nothing more will happen.
            due |= pulse.has_changed().unwrap_or(true);
            pulse.mark_unchanged();
            if *closing.borrow() {
                return Some(End::Close(1001, "the server shuts down"));
            }
            let beats = self.ocean.bulletin.beats();
            if beats - self.heard > self.ocean.settings.silence.as_secs() {
                return None;
            }
            if due && !self.stream.flushing() {
                match self.fill(beats) {
                    Ok(more) => due = more,
                    Err(end) => return Some(end),
                }
            }
            let (stream, on_its_way, ocean) = (&mut self.stream, &mut self.on_its_way, &self.ocean);
            let look = poll_fn(|cx| match stream.look(cx) {
                // All is with the system and nothing is due; the look has asked for what comes next already.
                Poll::Ready(Ok(None)) if !due => {
                    sent(ocean, on_its_way);
                    Poll::Pending
                }
                seen => seen,
            });
            let seen = tokio::select! {
                biased;
                seen = look => seen,
                _ = pulse.changed() => {
                    due = true;
                    continue;
                }
            };
            match seen {
                Ok(Some(message)) => {
                    self.heard = beats;
                    due = true;
                    if let Err(end) = self.hear(&message) {
                        return Some(end);
                    }
                }
                Ok(None) => sent(&self.ocean, &mut self.on_its_way),
                Err(end) => return end,
            }
        }
    }

    /// Hands the idle socket what is due; whether there is more.
    fn fill(&mut self, beats: u64) -> Result<bool, End> {
        sent(&self.ocean, &mut self.on_its_way);
        while let Some(answer) = self.lane.pop_front() {
            let message = answer.stamped(&self.ocean);
            self.stream.send(message);
        }
        if let Some(news) = self.ocean.bulletin.news(&mut self.reader) {
            if news.missed {
                return Err(OVERFLOW);
            }
            // Its units so far are of layouts before: those of a number that the new one has are of one long gone.
            let stays = |unit: &UnitName| !news.layouts.iter().any(|new| Layout::numbers(*new, unit.cascade));
            self.flows.retain(stays);
            self.granted.retain(|(unit, _)| stays(unit));
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
        if self.flows.is_empty() {
            return Ok(false);
        }
        if self.ladder.squeeze(self.ocean.egress.squeeze()) {
            self.change_quality();
        }
        let (flows, stream) = (&mut self.flows, &mut self.stream);
        let stale = self.ocean.tick() - STALE;
        let taken = self.ocean.ring.take(
            &mut self.cursor,
            stale,
            BURST,
            |frame| flows.takes(frame),
            |frame| {
                stream.send(Message::binary(frame));
            },
        );
        match taken.ready_us {
            // The last of it is with the system already; what followed was for others.
            Some(ready_us) if taken.frames == 0 => {
                self.ocean.metrics.sending.observe(self.ocean.clock.now_us() - ready_us);
            }
            ready_us => self.on_its_way = ready_us,
        }
        if taken.frames > 0 {
            self.ocean.metrics.sent(taken.frames, taken.bytes as u64);
        }
        if taken.jumped {
            self.ocean.metrics.jumped();
            if self.ladder.fell_behind(beats) {
                self.change_quality();
            }
        }
        let lost = self.flows.lost();
        self.client.join_units(lost);
        // What didn't fit into one go, and what a change of quality has to say.
        Ok(taken.more || !self.lane.is_empty())
    }

    fn hear(&mut self, message: &Message) -> Result<(), End> {
        if !self.messages.take(self.ocean.tick()) {
            return Err(End::Close(1008, "more than 256 messages at once, or 64 a second for long"));
        }
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
            Ok(ClientMessage::Report(report)) => {
                if report.lost {
                    // Beginning anew is as dear as subscribing.
                    match self.allow(self.ocean.tick()) {
                        Ok(()) => self.flows.forget(),
                        Err(error) => self.answer(&requests::refusal(error, None)),
                    }
                }
                if !self.flows.is_empty() && self.ladder.heard(&report, self.ocean.bulletin.beats()) {
                    self.change_quality();
                }
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
        if self.subscriptions.take(now) {
            return Ok(());
        }
        let detail = format!("more than {SUBSCRIPTIONS} subscriptions at once, or 4 a second for long");
        Err(ClientError { code: ErrorCode::Unavailable, field: None, detail })
    }

    fn follow(&mut self, points: Points) -> Result<PointsSubscribed, ClientError> {
        let interval = requests::check_points(&points)?;
        if !self.ocean.source.has_points() && !points.points.is_empty() {
            return Err(requests::no_points());
        }
        self.allow(self.ocean.tick())?;
        let Points { id, rate_hz, points } = points;
        let count = points.len();
        let from_tick = self.client.follow(id, interval, points);
        let from_tick = from_tick.map_err(|left| requests::no_room_for_points(count, left))?;
        self.follows = count > 0;
        Ok(PointsSubscribed { id, rate_hz, from_tick, count: count as u32 })
    }

    /// Sends from now on what the ladder says, and tells the client.
    fn change_quality(&mut self) {
        let quality = self.ladder.quality();
        let timeline = self.ocean.current().timeline;
        let levels = |cascade| timeline.life_of(cascade).map_or(1, |(_, life)| life.cascade.levels());
        let units = |quality| self.client.subscribe(&at_quality(&self.granted, quality, levels));
        // Where coarser units can't be had, fewer frames of the finer ones can.
        let finer = Quality { coarser: 0, ..quality };
        let asked = [quality, finer].into_iter().find_map(|quality| Some((quality, units(quality).ok()?)));
        let Some((quality, units)) = asked else { return };
        let begun = self.ocean.tick() + reach();
        let new = self.flows.replace(&units, self.keys, begun, self.ocean.source.grid());
        self.client.join_units(new);
        self.ocean.metrics.changed_quality();
        self.answer(&ServerMessage::Quality(quality));
    }

    fn subscribe(&mut self, subscribe: Subscribe) -> Result<Subscribed, ClientError> {
        let now = self.ocean.tick();
        let asked = requests::check(&subscribe, &self.ocean.current().timeline, now)?;
        self.allow(now)?;
        let granted = self.client.subscribe(&asked);
        let granted = granted.map_err(|index| self.ocean.source.refusal(index, self.ocean.settings.live_units))?;
        // Read after the engine was told: frames up to here may have left without the new units.
        let (begun, grid) = (self.ocean.tick() + reach(), self.ocean.source.grid());
        let idle = self.flows.is_empty();
        let new = self.flows.replace(&granted, subscribe.keys, begun, grid);
        self.client.join_units(new);
        let slowest = interval_of_rate(subscribe.rate_hz);
        let from_tick = granted.iter().map(|(unit, interval)| first_tick(unit, *interval, begun, grid)).min();
        let from_tick = from_tick.unwrap_or((begun / slowest + 1) * slowest);
        if idle {
            self.cursor = self.ocean.ring.at(from_tick);
        }
        let fastest = granted.iter().map(|(_, interval)| *interval).min().unwrap_or(slowest);
        self.ladder = Ladder::new((TICKS_PER_SECOND / fastest) as u32, self.ocean.bulletin.beats());
        (self.granted, self.keys) = (granted.clone(), subscribe.keys);
        let rate = |interval: i64| Some((TICKS_PER_SECOND / interval) as u32).filter(|rate| *rate != subscribe.rate_hz);
        let units = granted.into_iter().map(|(unit, interval)| UnitRate { unit, rate_hz: rate(interval) }).collect();
        Ok(Subscribed { id: subscribe.id, rate_hz: subscribe.rate_hz, units, from_tick })
    }
}

/// Counts what is with the system now.
fn sent(ocean: &Ocean, on_its_way: &mut Option<i64>) {
    if let Some(ready_us) = on_its_way.take() {
        ocean.metrics.sending.observe(ocean.clock.now_us() - ready_us);
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
