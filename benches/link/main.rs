//! How well clients keep server time, and how steadily they have frames, over links that delay, jitter and stall.
//!
//! `cargo bench --bench link` (`just link`); `-- --write` also writes docs/link.md, `-- --seconds N` measures for N
//! seconds in place of 90. Server, links and clients share one process, so one machine clock tells how far off each is.

mod page;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use swellcast::client::{Connection, Event, Footing, Playback};
use swellcast::control::{Epoch, Store};
use swellcast::engine::Clock;
use swellcast::load::{Direction, Link, LinkSettings};
use swellcast::scene::SceneFile;
use swellcast::server::{self, Ocean, Settings};
use swellcast::wire::{Codec, ErrorClass, Group, Hello, TICKS_PER_SECOND, UnitName};

const SCENE: &str = "name = \"one\"\n[wind]\nspeed_mps = 8\n[cascades]\nn = 64\npatches_m = [100]\n";
const GROUPS: [Group; 3] = [Group::Displacement, Group::Slopes, Group::Foam];
/// Frames a second of every display.
const DISPLAY_HZ: i64 = 90;
/// By how much clients' clocks run fast, millionths: quartz is off by up to 50.
const PPM: [i64; 3] = [0, 50, -50];
/// 20 +- 10 ms each way.
const JITTERED: Direction =
    Direction { delay_ms: 20.0, jitter_ms: 10.0, rate_mbps: 0.0, stall_ms: 0.0, stall_every_ms: 0.0 };
/// At least 20 ms each way, and evenly 0 to 31.6 ms more, 30 ms of which is the 95th percentile; stalls.
const STALLED: Direction =
    Direction { delay_ms: 35.8, jitter_ms: 15.8, rate_mbps: 0.0, stall_ms: 100.0, stall_every_ms: 5000.0 };

/// What a client of the bench is.
#[derive(Clone, Copy)]
struct Member {
    link: Option<Direction>,
    rate_hz: u32,
    ppm: i64,
    seed: u64,
}

/// What all measure against.
#[derive(Clone, Copy)]
struct Truth {
    clock: Clock,
    /// Server time less the time of `clock`, microseconds, and how far that can be off.
    ahead_us: i64,
    within_us: i64,
    /// Display frames are counted from here, by `clock`: all displays show their frames at the same instants.
    begin_us: i64,
    frames: usize,
}

/// How far server time is off at a display frame, and how far the client says that it can be.
#[derive(Clone, Copy)]
struct Off {
    us: i64,
    bound_us: i64,
}

/// What a client saw.
#[derive(Default)]
struct Seen {
    ppm: i64,
    /// When its connection stood, display frames after the beginning.
    connected: usize,
    /// For each display frame; `None` before the first exchange, and where the display itself came too late.
    off: Vec<Option<Off>>,
    /// Display frames with tiles of all groups, by how the worst of them stands.
    shown: Shown,
    /// What came that should not, and how often the server said that it gives another quality.
    wrong: u64,
    qualities: u64,
}

#[derive(Clone, Copy, Default)]
struct Shown {
    cubic: u64,
    line: u64,
    starved: u64,
    /// How far the newest frame was ahead of what is shown, milliseconds: least of all tiles, most of all tiles.
    least_ahead_ms: f64,
    most_ahead_ms: f64,
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let seconds = arguments.iter().position(|argument| argument == "--seconds").and_then(|at| arguments.get(at + 1));
    let seconds: usize = seconds.map_or(90, |text| text.parse().expect("seconds is a whole number"));
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().expect("a runtime");
    let page = runtime.block_on(measure(seconds + 2));
    println!("{page}");
    if arguments.iter().any(|argument| argument == "--write") {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/link.md"), &page).expect("docs can be written");
    }
}

/// All clients at once, for so many seconds: they are many so that rare events show, and light.
async fn measure(seconds: usize) -> String {
    let (ocean, server) = start().await;
    let clock = Clock::start(Clock::unix_now_ns() - 3_600_000_000_000);
    let (ahead_us, within_us) = offset(&ocean, clock);
    let frames = seconds * DISPLAY_HZ as usize;
    let truth = Truth { clock, ahead_us, within_us, begin_us: clock.now_us(), frames };
    let of = |link, rate_hz, seeds: std::ops::Range<u64>| {
        seeds.map(|seed| Member { link, rate_hz, ppm: PPM[seed as usize % PPM.len()], seed }).collect::<Vec<_>>()
    };
    let groups = [
        of(None, 15, 0..3),
        of(Some(JITTERED), 15, 10..22),
        of(Some(STALLED), 15, 30..36),
        of(Some(STALLED), 30, 40..46),
    ];
    let mut seen = Vec::new();
    for group in groups.map(|group| group.into_iter().map(|member| tokio::spawn(visit(server, member, truth)))) {
        seen.push(group.collect::<Vec<_>>());
    }
    let mut all = Vec::new();
    for group in seen {
        let mut of_group = Vec::new();
        for client in group {
            of_group.push(client.await.expect("a client comes to its end"));
        }
        all.push(of_group);
    }
    let [direct, jittered, slow, fast] = all.try_into().ok().expect("four groups");
    page::page(&truth, &direct, &jittered, [(15, &slow), (30, &fast)])
}

async fn start() -> (Arc<Ocean>, SocketAddr) {
    let scene = SceneFile::from_toml(SCENE).and_then(|file| file.check(None)).expect("a scene");
    let store = Store::in_memory().expect("a store");
    let begun = store.begin(&scene, Epoch::begin(Clock::unix_now_ns() - 7_200_000_000_000)).expect("an epoch");
    let ocean = Ocean::start(store, begun, Settings::default());
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.expect("a port");
    let address = listener.local_addr().expect("an address");
    // Ends with the program.
    tokio::spawn(server::run(listener, Arc::clone(&ocean), std::future::pending()));
    (ocean, address)
}

/// Server time less that of `clock`, and how far that can be off, microseconds. Both read the same monotonic clock of
/// the machine, so it is a constant. Each reading of the tick between two of `clock` bounds it from both sides; those
/// around a change of the tick do so within a microsecond or two.
fn offset(ocean: &Ocean, clock: Clock) -> (i64, i64) {
    let first_us_of = |tick: i64| -(-tick * 1_000_000).div_euclid(TICKS_PER_SECOND);
    let (mut least, mut most) = (i64::MIN, i64::MAX);
    for _ in 0..200_000 {
        let before = clock.now_us();
        let tick = ocean.tick();
        let after = clock.now_us();
        // Clocks drop fractions of a microsecond: `after` may be all but one more.
        least = least.max(first_us_of(tick) - after - 1);
        most = most.min(first_us_of(tick + 1) - before);
    }
    assert!(least <= most, "server and clients read the same clock");
    ((least + most) / 2, (most - least + 1) / 2)
}

/// One client: connects, subscribes, and asks its clock and its playback at every frame of its display.
async fn visit(server: SocketAddr, member: Member, truth: Truth) -> Seen {
    let Truth { clock, begin_us, frames, .. } = truth;
    let settings = |direction| LinkSettings { up: direction, down: direction, seed: member.seed };
    let link = match member.link {
        Some(direction) => Some(Link::start(server, settings(direction), clock).await.expect("a link")),
        None => None,
    };
    let url = format!("http://{}", link.as_ref().map_or(server, |link| link.address));
    let ours = move |us: i64| us + us * member.ppm / 1_000_000;
    let mut connection = Connection::open(&url, move || ours(clock.now_us())).await.expect("the server is there");
    let due = |frame: usize| begin_us + frame as i64 * 1_000_000 / DISPLAY_HZ;
    let next = || ((clock.now_us() - begin_us) * DISPLAY_HZ / 1_000_000 + 1) as usize;
    let mut seen = Seen { ppm: member.ppm, connected: next(), off: vec![None; frames], ..Seen::default() };
    seen.shown.least_ahead_ms = f64::INFINITY;
    let (mut playback, mut hello, mut frame) = (Playback::default(), None, seen.connected);
    while frame < frames {
        let wait = Duration::from_micros((due(frame) - clock.now_us()).max(0) as u64);
        tokio::select! {
            biased;
            () = tokio::time::sleep(wait) => {
                let now = clock.now_us();
                // At the instant of the frame, not when this task got to it: so all clients are asked at the same time.
                let (time, at) = (connection.clock(), ours(due(frame)));
                if let Some((us, bound_us)) = time.server_us(at).zip(time.error_bound_us(at)) {
                    seen.off[frame] = Some(Off { us: us - due(frame) - truth.ahead_us, bound_us });
                }
                // Frames, though, are there or not when the picture is made.
                if let Some(server_us) = time.server_us(ours(now)) {
                    if frame >= seen.connected + 3 * DISPLAY_HZ as usize {
                        show(&playback, server_us, &mut seen.shown);
                    }
                    playback.forget_before(server_us);
                }
                frame = next().max(frame + 1);
            }
            event = connection.next() => {
                take(event, &mut connection, member.rate_hz, &mut hello, &mut playback, &mut seen).await;
            }
        }
    }
    connection.close_politely().await;
    seen
}

async fn take(
    event: Event,
    connection: &mut Connection<impl Fn() -> i64>,
    rate_hz: u32,
    hello: &mut Option<Box<Hello>>,
    playback: &mut Playback,
    seen: &mut Seen,
) {
    match event {
        Event::Hello(told) => {
            *hello = Some(told);
            let class = ErrorClass::Millimetre;
            let unit = |group| UnitName { cascade: 0, level: 0, class, group, codec: Codec::Rans };
            connection.subscribe(rate_hz, GROUPS.map(unit).to_vec(), false).await;
        }
        Event::Subscribed(granted) => {
            let units: Vec<_> = granted.units.iter().map(|unit| unit.unit).collect();
            *playback = Playback::new(hello.as_ref().expect("hello comes first"), &units);
        }
        Event::Frame(frame, _) => seen.wrong += u64::from(playback.insert(frame).is_err()),
        Event::Quality(_) => seen.qualities += 1,
        Event::Status(_) => {}
        Event::Change(_) | Event::Error { .. } | Event::BadFrame(_) | Event::BadText(_) => seen.wrong += 1,
        Event::Closed(closed) => panic!("{closed}"),
    }
}

/// Counts a display frame by the tile that stands worst.
fn show(playback: &Playback, server_us: i64, shown: &mut Shown) {
    let now = server_us as f64 * TICKS_PER_SECOND as f64 / 1e6;
    let (mut tiles, mut between, mut cubic) = (0, 0, 0);
    for key in playback.keys() {
        let ticks = || playback.ticks(key).map(|tick| tick as f64);
        let passed = ticks().filter(|tick| *tick <= now).count();
        tiles += 1;
        between += usize::from(playback.footing(key, server_us) == Some(Footing::Between));
        cubic += usize::from(passed >= 2 && ticks().count() >= passed + 2);
        let ahead_ms = (ticks().fold(f64::NEG_INFINITY, f64::max) - now) * 1e3 / TICKS_PER_SECOND as f64;
        shown.least_ahead_ms = shown.least_ahead_ms.min(ahead_ms);
        shown.most_ahead_ms = shown.most_ahead_ms.max(ahead_ms);
    }
    if tiles < GROUPS.len() || between < tiles {
        shown.starved += 1;
    } else if cubic == tiles {
        shown.cubic += 1;
    } else {
        shown.line += 1;
    }
}
