//! Vectors of the shared clock: exchanges over simulated networks, and what server time is then held to be. The web
//! client keeps the same clock, and is held to the same numbers.

use std::fmt::Write as _;

use serde_json::json;
use swellcast::client::{Exchange, SharedClock};

use crate::random::Random;

/// A network and a server; whole microseconds throughout, so that every machine makes the same numbers.
struct Link {
    name: &'static str,
    about: &'static str,
    seconds: i64,
    /// Least and most delay of a request and of an answer.
    up_us: [i64; 2],
    down_us: [i64; 2],
    /// Millionths by which the server's clock is faster.
    drift_ppm: i64,
    /// What the server's clock is moved by, at a time of ours.
    moved: fn(i64) -> i64,
    /// What becomes of an exchange on its way: its number, and itself.
    touched: fn(usize, Exchange) -> Exchange,
}

const SECOND: i64 = 1_000_000;
const OFFSET_US: i64 = 86_400_000_000;

fn links() -> Vec<Link> {
    let quiet = Link {
        name: "lan",
        about: "0.1 to 0.4 ms each way, drift of 15 ppm",
        seconds: 60,
        up_us: [100, 400],
        down_us: [100, 400],
        drift_ppm: 15,
        moved: |_| 0,
        touched: |_, exchange| exchange,
    };
    vec![
        Link {
            name: "jitter",
            about: "20 +- 10 ms each way, drift of 40 ppm, more exchanges than are kept",
            seconds: 150,
            up_us: [10_000, 30_000],
            down_us: [10_000, 30_000],
            drift_ppm: 40,
            ..quiet
        },
        Link {
            name: "step",
            about: "the server's clock is set 5 s ahead after 30 s",
            moved: |t| if t >= 30 * SECOND { 5 * SECOND } else { 0 },
            ..quiet
        },
        Link {
            name: "restart",
            about: "the server begins anew after 30 s, an hour back",
            moved: |t| if t >= 30 * SECOND { -3600 * SECOND } else { 0 },
            ..quiet
        },
        Link {
            name: "nudge",
            about: "the server's clock is set 50 ms back after 30 s: server time is bent to it",
            moved: |t| if t >= 30 * SECOND { -50_000 } else { 0 },
            up_us: [500, 3000],
            down_us: [500, 3000],
            ..quiet
        },
        Link {
            name: "wild",
            about: "one answer is an hour off, and some are impossible",
            seconds: 40,
            touched: |number, e| match number {
                30 => Exchange { t1: e.t1 + 3600 * SECOND, t2: e.t2 + 3600 * SECOND, ..e },
                33 => Exchange { t3: e.t0 - 1, ..e },
                36 => Exchange { t2: e.t1 - 1, ..e },
                39 => Exchange { t2: e.t1 + SECOND, ..e },
                _ => e,
            },
            ..quiet
        },
        Link {
            name: "uneven",
            about: "requests take 1 to 2 ms, answers 60 to 90",
            up_us: [1000, 2000],
            down_us: [60_000, 90_000],
            drift_ppm: -70,
            ..quiet
        },
        Link {
            name: "stalls",
            about: "every fifth answer waits for 300 ms more",
            up_us: [5000, 6000],
            down_us: [5000, 6000],
            touched: |number, e| if number % 5 == 0 { Exchange { t3: e.t3 + 300_000, ..e } } else { e },
            ..quiet
        },
        Link {
            name: "suspend",
            about: "the client sleeps for ten minutes after 30 s, and its clock with it; one answer comes after the sleep",
            moved: |t| if t >= 30 * SECOND { 600 * SECOND } else { 0 },
            touched: |number, e| if number == 48 { Exchange { t3: e.t3 + 700_000, ..e } } else { e },
            ..quiet
        },
        quiet,
    ]
}

impl Link {
    fn server_us(&self, ours: i64) -> i64 {
        ours + (ours * self.drift_ppm).div_euclid(1_000_000) + OFFSET_US + (self.moved)(ours)
    }

    /// 20 exchanges 100 ms apart, then one a second, as the connection makes them.
    fn exchanges(&self) -> Vec<Exchange> {
        let mut random = Random(7);
        let mut between = |[least, most]: [i64; 2]| least + random.below((most - least + 1) as usize) as i64;
        let starts = (0..20).map(|i| i * SECOND / 10).chain((2..self.seconds).map(|i| i * SECOND));
        let exchange = |(number, t0): (usize, i64)| {
            let (up, served, down) = (between(self.up_us), between([20, 80]), between(self.down_us));
            let (t1, t2) = (self.server_us(t0 + up), self.server_us(t0 + up + served));
            (self.touched)(number, Exchange { t0, t1, t2, t3: t0 + up + served + down })
        };
        starts.enumerate().map(exchange).collect()
    }
}

/// The file.
pub fn text() -> String {
    let mut text = String::from("[\n");
    let links = links();
    for (number, link) in links.iter().enumerate() {
        let exchanges = link.exchanges();
        let rows: Vec<[i64; 4]> = exchanges.iter().map(|e| [e.t0, e.t1, e.t2, e.t3]).collect();
        let mut clock = SharedClock::new();
        let mut queries = vec![query(&clock, 0, 0)];
        for (before, exchange) in exchanges.iter().enumerate() {
            clock.observe(*exchange);
            let after = before + 1;
            // All that come while the clock finds its way, then some; at once, between two exchanges, and much later.
            let told = after < 6 || after % 9 == 0 || (28..40).contains(&before) || (47..52).contains(&before);
            if told || after == exchanges.len() {
                let wait = [0, 400_000, 1_000_000, 10_000_000][after % 4];
                queries.push(query(&clock, after, exchange.t0.max(exchange.t3) + wait));
            }
        }
        let (name, about) = (json!(link.name), json!(link.about));
        let queries: Vec<String> = queries.iter().map(ToString::to_string).collect();
        let end = if number + 1 < links.len() { "," } else { "" };
        let _ = writeln!(
            text,
            "  {{\n    \"name\": {name},\n    \"about\": {about},\n    \"exchanges\": {},\n    \"queries\": [\n      {}\n    ]\n  }}{end}",
            json!(rows),
            queries.join(",\n      ")
        );
    }
    text + "]\n"
}

fn query(clock: &SharedClock, after: usize, at: i64) -> serde_json::Value {
    json!({ "after": after, "at": at, "server_us": clock.server_us(at), "error_bound_us": clock.error_bound_us(at) })
}

#[test]
fn the_sequences_hold_what_they_are_named_for() {
    for link in links() {
        let mut clock = SharedClock::new();
        let taken = link.exchanges().into_iter().filter(|exchange| clock.observe(*exchange)).count();
        let refused = link.exchanges().len() - taken;
        assert_eq!(refused, if link.name == "wild" { 3 } else { 0 }, "{}", link.name);
        // What was set is followed in the end, whatever happened before; an uneven network errs by half of what it is.
        let now = link.seconds * SECOND;
        let error = (clock.server_us(now).unwrap() - link.server_us(now)).abs();
        let most = if link.name == "uneven" { 40_000 } else { 3000 };
        assert!(error < most, "{}: {error} us", link.name);
        assert!(error <= clock.error_bound_us(now).unwrap() + 100, "{}: {error} us is beyond the bound", link.name);
    }
}
