//! Laws of the shared clock, on a simulated network: no sleeping, no real clock.

use swellcast::client::{Exchange, SharedClock};

use crate::random::Random;

/// A network and a server whose clock runs `drift` faster than ours and is `offset_us` ahead.
struct Link {
    random: Random,
    offset_us: f64,
    drift: f64,
    /// Least and most delay of a request and of an answer, microseconds.
    up_us: [f64; 2],
    down_us: [f64; 2],
}

impl Link {
    fn server_us(&self, ours: f64) -> f64 {
        ours * (1.0 + self.drift) + self.offset_us
    }

    fn exchange(&mut self, t0: f64) -> Exchange {
        let mut delay = |[least, most]: [f64; 2]| least + (most - least) * self.random.unit();
        let (up, down) = (delay(self.up_us), delay(self.down_us));
        let (read, written) = (t0 + up, t0 + up + 50.0);
        let server = |ours| self.server_us(ours) as i64;
        Exchange { t0: t0 as i64, t1: server(read), t2: server(written), t3: (written + down) as i64 }
    }
}

/// 20 exchanges 100 ms apart, then one a second, as the connection makes them.
fn schedule(seconds: f64) -> impl Iterator<Item = f64> {
    let quick = (0..20).map(|i| f64::from(i) * 1e5);
    quick.chain((2..).map(|i| f64::from(i) * 1e6).take_while(move |t| *t <= seconds * 1e6))
}

#[test]
fn clock_converges_under_jitter() {
    // 20 +- 10 ms each way, server time a century on, clocks up to 100 ppm apart: p99 of 300 runs.
    for (seconds, most_us) in [(10.0, 3000), (30.0, 3000), (120.0, 2000)] {
        let mut errors = Vec::new();
        for seed in 0..300 {
            let drift = (Random(seed + 1000).unit() - 0.5) * 200e-6;
            let delays = [10e3, 30e3];
            let mut link = Link { random: Random(seed), offset_us: 3.15e15, drift, up_us: delays, down_us: delays };
            let mut clock = SharedClock::new();
            schedule(seconds).for_each(|t| assert!(clock.observe(link.exchange(t))));
            let now = seconds * 1e6 + 5e5;
            let error = clock.server_us(now as i64).unwrap() - link.server_us(now) as i64;
            assert!(error.abs() <= clock.error_bound_us(now as i64).unwrap() + 100, "{error} beyond its bound");
            errors.push(error.abs());
        }
        errors.sort_unstable();
        let p99 = errors[errors.len() * 99 / 100];
        assert!(p99 <= most_us, "p99 after {seconds} s is {p99} us");
    }
}

#[test]
fn a_quiet_network_gives_microseconds() {
    let mut link =
        Link { random: Random(1), offset_us: -7e9, drift: 40e-6, up_us: [90.0, 400.0], down_us: [90.0, 400.0] };
    let mut clock = SharedClock::new();
    for t in schedule(120.0) {
        clock.observe(link.exchange(t));
        let error = clock.server_us(t as i64 + 1000).unwrap() - link.server_us(t + 1000.0) as i64;
        assert!(error.abs() < 400, "{error} us at {t}");
    }
    assert!((clock.drift() - 40e-6).abs() < 3e-6, "drift {}", clock.drift());
}

#[test]
fn the_truth_lies_within_the_bound_however_uneven_the_ways() {
    for (up_us, down_us) in [([0.0, 1e3], [60e3, 90e3]), ([60e3, 90e3], [0.0, 1e3]), ([5e3, 5e3], [5e3, 5e3])] {
        let mut link = Link { random: Random(3), offset_us: 1e12, drift: 0.0, up_us, down_us };
        let mut clock = SharedClock::new();
        for t in schedule(60.0) {
            clock.observe(link.exchange(t));
            let error = clock.server_us(t as i64).unwrap() - link.server_us(t) as i64;
            assert!(error.abs() <= clock.error_bound_us(t as i64).unwrap() + 10, "{error} at {t}");
        }
    }
}

#[test]
fn server_time_never_goes_back_and_is_bent_by_one_per_cent() {
    let mut link =
        Link { random: Random(4), offset_us: 5e9, drift: -30e-6, up_us: [0.0, 150e3], down_us: [0.0, 150e3] };
    let mut clock = SharedClock::new();
    let (mut last, mut last_t): (Option<i64>, i64) = (None, 0);
    let mut exchanges: Vec<Exchange> = schedule(60.0).map(|t| link.exchange(t)).collect();
    exchanges.sort_by_key(|e| e.t3);
    for pair in exchanges.windows(2) {
        clock.observe(pair[0]);
        for t in (pair[0].t3..pair[1].t3).step_by(997) {
            let now = clock.server_us(t).unwrap();
            if let Some(last) = last {
                let (server, ours) = ((now - last) as f64, (t - last_t) as f64);
                assert!((server - ours).abs() <= ours * 0.0106 + 3.0, "{server} us in {ours} us of ours at {t}");
            }
            (last, last_t) = (Some(now), t);
        }
    }
}

#[test]
fn a_jump_is_followed_at_once_and_a_wild_answer_is_not() {
    let mut link = Link { random: Random(5), offset_us: 1e9, drift: 0.0, up_us: [1e3, 3e3], down_us: [1e3, 3e3] };
    let mut clock = SharedClock::new();
    schedule(30.0).for_each(|t| assert!(clock.observe(link.exchange(t))));
    let error =
        |clock: &SharedClock, link: &Link, t: f64| clock.server_us(t as i64).unwrap() - link.server_us(t) as i64;

    let mut wild = link.exchange(31e6);
    (wild.t1, wild.t2) = (wild.t1 + 3_600_000_000, wild.t2 + 3_600_000_000);
    clock.observe(wild);
    assert!(error(&clock, &link, 31.1e6).abs() < 2000, "one wild answer moved the clock");
    clock.observe(link.exchange(32e6));

    link.offset_us += 7e6;
    clock.observe(link.exchange(33e6));
    clock.observe(link.exchange(34e6));
    assert!(error(&clock, &link, 34.1e6).abs() < 2000, "7 s were not stepped over");

    // A small move is bent to: 50 ms take 5 s.
    link.offset_us -= 50e3;
    clock.observe(link.exchange(35e6));
    let lag = error(&clock, &link, 35.1e6);
    assert!((40_000..52_000).contains(&lag), "{lag}");
    (36..42).for_each(|s| assert!(clock.observe(link.exchange(f64::from(s) * 1e6))));
    assert!(error(&clock, &link, 42e6).abs() < 2000);
}

#[test]
fn impossible_exchanges_change_nothing() {
    let mut clock = SharedClock::new();
    assert_eq!(clock.server_us(0), None);
    let wrong = [
        [0, 0, 0, -1],
        [0, 10, 5, 20],
        [0, 0, 100, 50],
        [i64::MIN, 0, 0, i64::MAX],
        [0, i64::MIN, i64::MAX, 1],
        [0, i64::MAX, i64::MAX, 1],
    ];
    for [t0, t1, t2, t3] in wrong {
        assert!(!clock.observe(Exchange { t0, t1, t2, t3 }));
    }
    assert_eq!((clock.server_us(0), clock.samples()), (None, 0));
    assert!(clock.observe(Exchange { t0: 0, t1: 1 << 60, t2: 1 << 60, t3: 0 }));
    for now in [i64::MIN, i64::MAX, 0] {
        assert!(clock.server_us(now).is_some(), "no time makes it panic");
    }
    let mut random = Random(6);
    for _ in 0..10_000 {
        let mut any = || (random.bits() >> random.below(64)) as i64 * if random.below(2) == 0 { 1 } else { -1 };
        let (t0, t1) = (any() / 4, any() / 4);
        clock.observe(Exchange { t0, t1, t2: t1 + any().rem_euclid(99), t3: t0 + any().rem_euclid(99_999) });
        clock.server_us(any());
        assert!(clock.samples() <= 128);
    }
}
