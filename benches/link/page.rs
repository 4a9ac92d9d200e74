//! The page docs/link.md: what was asked, what was reached, and how it was measured.

use std::fmt::Write;
use std::ops::Range;

use super::{DISPLAY_HZ, Off, Seen, Truth};

/// Errors of server time asked for, milliseconds, and the share of display frames between two frames of the sea.
const QUIET_MS: f64 = 1.0;
const JITTERED_MS: f64 = 3.0;
const APART_MS: f64 = 2.0;
const BETWEEN: f64 = 0.999;

/// The whole page. Clients without a link, with jitter, and by their rate those with jitter and stalls.
pub fn page(truth: &Truth, direct: &[Seen], jittered: &[Seen], stalled: [(u32, &[Seen]); 2]) -> String {
    let mut page = String::new();
    let put = &mut page;
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    let seconds = truth.frames as i64 / DISPLAY_HZ;
    let [slow, fast] = stalled.map(|(_, clients)| clients.len());
    let (quiet, bad) = (direct.len(), jittered.len());
    write!(
        put,
        "\
# Clients over real links

`just link` writes this page (`cargo bench --bench link -- --write`), on {cores} cores, {}.

One process holds a server, the links between (`swellcast load`'s emulator of one: [load.md](load.md)), and {} Rust \
clients, for {seconds} s: {quiet} on loopback, {bad} behind 20 +- 10 ms each way, {slow} and {fast} at 15 and 30 frames a \
second behind a link that also stalls. All follow displacement, slopes and foam of one cascade of 64 x 64, codec `rans`, \
and all are asked at 90 Hz. Links add no rate, and lose nothing. The clocks of two clients in three run 50 ppm fast or \
slow, as quartz does.

## Server time

Server and clients read the same clock of the machine, each from a beginning of its own. How far these lie apart is found \
before all else by reading the server's tick between two readings of the other clock, many times: here to {} us. So the \
error of a client's server time is known at any instant. Clients make 20 exchanges in the first two seconds, then one a \
second. What limits them: nothing tells a slow request from a slow answer, so server time is off by half of what the \
quickest request and the quickest answer of late differ; and where clocks run apart, old exchanges are worth less.

| link | from, after connecting | asked: p99 | p50 | p99 | max | reached | bound that clients state, p50 | beyond it |
|---|---|---|---|---|---|---|---|---|
",
        std::env::consts::ARCH,
        quiet + bad + slow + fast,
        truth.within_us
    )
    .unwrap();
    let (all, later) = (2..usize::MAX, 30..usize::MAX);
    row(put, "loopback", direct, &all, "2 s", Some(QUIET_MS));
    row(put, "20 +- 10 ms", jittered, &(5..6), "5 s, for 1 s", None);
    row(put, "20 +- 10 ms", jittered, &(10..11), "10 s, for 1 s", None);
    row(put, "20 +- 10 ms", jittered, &later, "30 s", Some(JITTERED_MS));
    row(put, "of these, clocks alike", jittered.iter().filter(|client| client.ppm == 0), &later, "30 s", None);
    row(put, "of these, 50 ppm apart", jittered.iter().filter(|client| client.ppm != 0), &later, "30 s", None);
    row(put, "20 to 51.6 ms, stalls", stalled.iter().flat_map(|(_, clients)| *clients), &later, "30 s", None);
    let mut apart: Vec<i64> = Vec::new();
    for (a, b) in direct.iter().flat_map(|a| jittered.iter().map(move |b| (a, b))) {
        let begin = a.connected.max(b.connected) + 30 * DISPLAY_HZ as usize;
        let both = a.off.iter().zip(&b.off).skip(begin).filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?)));
        apart.extend(both.map(|(a, b)| (a.us - b.us).abs()));
    }
    apart.sort_unstable();
    let p95 = at(&apart, 0.95);
    write!(
        put,
        "
Figures are milliseconds, of all display frames of all clients of a kind. Beyond it: how often the truth lay outside the \
bound.

## Two displays

A client on loopback and one behind 20 +- 10 ms, from 30 s on: what server time they show at the same instant differs by \
{p95:.2} ms at the 95th percentile (asked: {APART_MS} ms; {}), {:.2} ms at the median, {:.2} ms at most, over all {} pairs.

## Playback

Each way takes 20 ms and evenly 0 to 31.6 ms more, so that 95 % of bytes take less than 30 ms more; the round trip is 40 ms \
at least, 72 ms on average. Nothing is overtaken, so what comes soon after late bytes is late as well. Each way stalls for \
100 ms once in 5 s. At each display frame the client takes server time from its own clock and asks `Playback` how each \
tile stands; the worst one counts. Between: there are frames on both sides of now. Cubic: two on either side, the best \
that there is. Starved: the newest frame is held; the Rust client never extrapolates. From 3 s after connecting.

Frames leave 233 ms before their tick, those between two of 15 Hz together with the later one, so a display lacks a frame \
when one takes more than 166 ms from the server's clock to the ring. The link alone takes up to 152 ms, when a stall meets \
the longest delay; what is left is for computing, coding and a busy machine.

| frames a second | display frames | asked: between | between | of these cubic | starved | reached | newest frame ahead of now, ms | wrong messages | changes of quality |
|---|---|---|---|---|---|---|---|---|---|
",
        if p95 <= APART_MS { "reached" } else { "not reached" },
        at(&apart, 0.5),
        at(&apart, 1.0),
        direct.len() * jittered.len(),
    )
    .unwrap();
    for (rate, clients) in stalled {
        let sum = |of: fn(&Seen) -> u64| clients.iter().map(of).sum::<u64>();
        let (cubic, line, starved) = (sum(|c| c.shown.cubic), sum(|c| c.shown.line), sum(|c| c.shown.starved));
        let total = (cubic + line + starved) as f64;
        let between = (cubic + line) as f64 / total;
        let least = clients.iter().map(|c| c.shown.least_ahead_ms).fold(f64::INFINITY, f64::min);
        let most = clients.iter().map(|c| c.shown.most_ahead_ms).fold(0.0, f64::max);
        writeln!(
            put,
            "| {rate} | {total} | {:.1} % | {:.3} % | {:.1} % | {:.3} % | {} | {least:.0} to {most:.0} | {} | {} |",
            BETWEEN * 100.0,
            between * 100.0,
            cubic as f64 / (cubic + line).max(1) as f64 * 100.0,
            starved as f64 / total * 100.0,
            yes(between >= BETWEEN),
            sum(|c| c.wrong),
            sum(|c| c.qualities),
        )
        .unwrap();
    }
    let others = || direct.iter().chain(jittered);
    writeln!(
        put,
        "\nThe other clients had {} wrong messages and {} changes of quality; {:.2} % of all display frames came more than \
         one frame late and were left out.",
        others().map(|client| client.wrong).sum::<u64>(),
        others().map(|client| client.qualities).sum::<u64>(),
        missed(others().chain(stalled[0].1).chain(stalled[1].1)) * 100.0
    )
    .unwrap();
    page
}

/// A row of errors within some seconds after connecting.
fn row<'a>(
    put: &mut String,
    link: &str,
    clients: impl IntoIterator<Item = &'a Seen>,
    seconds: &Range<usize>,
    from: &str,
    asked_ms: Option<f64>,
) {
    let frame = |second: usize| second.saturating_mul(DISPLAY_HZ as usize);
    let within = |client: &'a Seen| -> Vec<Off> {
        let begin = client.connected + frame(seconds.start);
        let count = frame(seconds.end - seconds.start);
        client.off.iter().skip(begin).take(count).flatten().copied().collect()
    };
    let all: Vec<Off> = clients.into_iter().flat_map(within).collect();
    let mut errors: Vec<i64> = all.iter().map(|off| off.us.abs()).collect();
    let mut bounds: Vec<i64> = all.iter().map(|off| off.bound_us).collect();
    errors.sort_unstable();
    bounds.sort_unstable();
    // What the truth itself can be off by is no fault of theirs, a microsecond or two.
    let beyond = all.iter().filter(|off| off.us.abs() > off.bound_us + 2).count();
    let p99 = at(&errors, 0.99);
    writeln!(
        put,
        "| {link} | {from} | {} | {:.2} | {p99:.2} | {:.2} | {} | {:.2} | {beyond} of {} |",
        asked_ms.map_or("-".to_owned(), |ms| format!("{ms} ms")),
        at(&errors, 0.5),
        at(&errors, 1.0),
        asked_ms.map_or("-", |ms| yes(p99 <= ms)),
        at(&bounds, 0.5),
        all.len()
    )
    .unwrap();
}

fn yes(reached: bool) -> &'static str {
    if reached { "yes" } else { "no" }
}

/// A percentile of sorted microseconds, in milliseconds.
fn at(sorted: &[i64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted.get((last as f64 * share).round() as usize).map_or(f64::NAN, |us| *us as f64 / 1e3)
}

/// Share of display frames after the first exchange that were not shown.
fn missed<'a>(clients: impl Iterator<Item = &'a Seen>) -> f64 {
    let (mut due, mut missed) = (0, 0);
    for client in clients {
        let shown = client.off.iter().skip_while(|off| off.is_none());
        due += shown.clone().count();
        missed += shown.filter(|off| off.is_none()).count();
    }
    missed as f64 / due.max(1) as f64
}
