//! Laws of the load test: it counts what came, calls wrong what is wrong, and its link and figures do what they say.

mod soak;

use std::net::SocketAddr;
use std::process::{Command, Output};
use std::time::Duration;

use bytes::Bytes;
use clap::Parser;
use serde_json::Value;
use swellcast::engine::Clock;
use swellcast::load::{
    BadFrame, Continuity, Findings, Histogram, Link, LinkSettings, LoadArguments, Message, Report, StreamReader, run,
};
use swellcast::server::Settings;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::timeout;

use crate::random::Random;
use crate::served::{PATIENCE, SMALL, Served};
use crate::support::scene;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    load: LoadArguments,
}

async fn load(served: &Served, options: &str) -> Report {
    let url = format!("http://{}", served.address);
    let words = ["load", "--url", &url].into_iter().chain(options.split_whitespace());
    let arguments = Line::parse_from(words).load;
    run(&arguments, Clock::start(Clock::unix_now_ns()), |_| {}).await.unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_load_of_20_clients_counts_every_frame() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let options = "--clients 20 --seconds 3 --ramp 0.5 --rate 30 --groups displacement,slopes --codec i16 --decode 0.2 --tolerate 1";
    let report = load(&served, options).await;
    let Findings { steady, decoded, client_mbps, server, .. } = &report.load;
    assert!(report.holds, "{:?}", report.why);
    assert_eq!((steady.clients, steady.stayed, steady.faults.total(), client_mbps.len()), (20, 20, 0, 20));
    // Two units of 32 x 32 samples, three and two channels, thirty times a second.
    let skipped = served.ocean.counters().skipped_frames;
    let wanted = 20 * 2 * 30 * 3;
    assert!((wanted - 40 * (4 + skipped)..=wanted + 160).contains(&steady.frames), "{}, {skipped}", steady.frames);
    assert_eq!(steady.bytes, steady.frames / 2 * (2 * 88 + 5 * 2 * 32 * 32), "as many of one unit as of the other");
    assert!(steady.gaps <= 40 * skipped, "{} gaps, {skipped} ticks skipped", steady.gaps);
    assert!(*decoded > 4 * 2 * 30 * 2, "four of them decode, {decoded}");
    assert!(steady.age_ms.is_some_and(|age| age.p50 <= age.p99 && age.p99 <= age.p999 && age.p999 <= age.max));
    assert_eq!(server.clients, Some(21.0), "with the one that keeps the time");
    assert!(cfg!(not(target_os = "linux")) || server.cpu.is_some_and(|cpu| cpu > 0.0));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stalled_client_is_not_counted_as_gap() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let options = "--clients 4 --seconds 4 --ramp 0.1 --stalled 3 --wake 1.5 --slow 1 --slow-rate 0.2 --tolerate 1 \
        --mix 1:60:1mm:displacement --mix 1:15:5mm:slopes";
    let report = load(&served, options).await;
    let skipped = served.ocean.counters().skipped_frames;
    assert!(report.holds, "{:?}", report.why);
    assert!(report.load.steady.gaps <= 4 * skipped, "{:?}", report.load.steady);
    let stalled = report.load.stalled.unwrap();
    assert_eq!((stalled.clients, stalled.woke, stalled.live_again), (3, 3, 3));
    assert_eq!(stalled.faults.total(), 0);
    let slow = report.load.slow.unwrap();
    assert!((1, 1) == (slow.clients, slow.stayed) && slow.mbps < 0.4, "{slow:?}");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_is_refused_is_counted_and_the_load_does_not_hold() {
    let served = Served::start(&scene(SMALL), Settings { clients: 3, ..Settings::default() }).await;
    let report = load(&served, "--clients 5 --seconds 1 --ramp 0.1").await;
    assert!(!report.holds);
    // One place is taken by the connection that keeps the time.
    assert_eq!((report.load.steady.clients, report.load.steady.stayed), (5, 2));
    assert_eq!(report.load.steady.ended, [("the server closed with 1013".to_owned(), 3)]);
    served.stop().await;
}

/// The program itself.
async fn program(options: String) -> Output {
    let run = move || Command::new(env!("CARGO_BIN_EXE_swellcast")).args(options.split_whitespace()).output();
    tokio::task::spawn_blocking(run).await.unwrap().unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_program_prints_json_and_nothing_else_and_calibrates_in_the_same_run() {
    let served = Served::start(&scene(SMALL), Settings::default()).await;
    let page = tempfile::tempdir().unwrap();
    let page = page.path().join("load.html");
    let options = format!(
        "load --url http://{} --clients 4 --seconds 1 --ramp 0.1 --codec i16 --calibrate --tolerate 1 --json - --html {}",
        served.address,
        page.display()
    );
    let output = program(options).await;
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["holds"], true);
    let (here, there) = (&report["load"]["steady"], &report["calibration"]["findings"]["steady"]);
    assert_eq!((&there["stayed"], &there["faults"]), (&here["stayed"], &here["faults"]), "{there}");
    let frames = |side: &Value| side["frames"].as_f64().unwrap();
    assert!(frames(there) > 0.5 * frames(here), "as many frames: {here} {there}");
    assert_eq!(frames(here) / here["bytes"].as_f64().unwrap(), frames(there) / there["bytes"].as_f64().unwrap());
    let html = std::fs::read_to_string(page).unwrap();
    assert!(html.matches("<figure>").count() == 6 && !html.contains("NaN") && !html.contains("inf"), "{html}");
    assert!(!html.contains("http://www") && !html.contains("<script"), "nothing is fetched");
    served.stop().await;
}

#[tokio::test]
async fn bad_usage_and_an_absent_server_are_told_apart() {
    for (options, code) in [
        ("load --url http://127.0.0.1:1 --clients 0", 2),
        ("load --url http://127.0.0.1:1 --mix 1:2", 2),
        ("load --url http://127.0.0.1:1 --link jitter=5", 2),
        ("load --url http://127.0.0.1:1 --groups foam,froth", 2),
        ("load --url http://127.0.0.1:1 --churn 0", 2),
        ("load --url http://127.0.0.1:1", 1),
        ("load --url ftp://127.0.0.1:1", 1),
        ("load --url http://127.0.0.1:1 --clients 1000000", 1),
    ] {
        let output = program(options.to_owned()).await;
        assert_eq!(output.status.code(), Some(code), "{options}: {output:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{output:?}");
    }
}

/// A server's WebSocket frame.
fn ws(first: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![first];
    match payload.len() {
        n @ 0..126 => bytes.push(n as u8),
        n @ 126..=0xffff => {
            bytes.push(126);
            bytes.extend((n as u16).to_be_bytes());
        }
        n => {
            bytes.push(127);
            bytes.extend((n as u64).to_be_bytes());
        }
    }
    bytes.extend(payload);
    bytes
}

/// Everything that a reader says of a stream that comes in chunks.
fn read(stream: &[u8], mut chunk: impl FnMut() -> usize) -> Vec<String> {
    let (mut reader, mut said, mut rest) = (StreamReader::new(true), Vec::new(), stream);
    while !rest.is_empty() {
        let (part, after) = rest.split_at(chunk().clamp(1, rest.len()));
        if let Err(error) = reader.feed(part, |message| said.push(format!("{message:?}"))) {
            said.push(error.to_string());
            break;
        }
        rest = after;
    }
    said
}

fn vector(name: &str) -> Bytes {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/proto/vectors");
    let mut files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let named = |path: &std::path::PathBuf| {
        path.extension().is_some_and(|e| e == "bin") && path.to_str().unwrap().contains(name)
    };
    std::fs::read(files.find(named).unwrap_or_else(|| panic!("no vector {name}"))).unwrap().into()
}

#[test]
fn a_stream_reads_alike_in_chunks_of_any_size() {
    let frame = vector("displacement");
    let (head, tail) = frame.split_at(100);
    let messages = [
        ws(0x81, b"{\"type\":\"hello\"}"),
        ws(0x82, &frame),
        ws(0x89, b"ping"),
        // In three pieces, with a ping between, and an empty one.
        ws(0x02, &head[..40]),
        ws(0x89, b""),
        ws(0x00, &head[40..]),
        ws(0x00, b""),
        ws(0x80, tail),
        ws(0x82, b"SWP1 is no frame"),
        ws(0x82, b""),
        ws(0x81, &[b'x'; 70_000]),
        ws(0x8a, b"pong"),
        ws(0x88, &[0x03, 0xe9, b'!']),
    ];
    let stream = messages.concat();
    let whole = read(&stream, || stream.len());
    assert_eq!(whole.len(), 9);
    assert!(whole[1].starts_with("Frame") && whole[1] == whole[4], "in one piece or in many");
    assert_eq!(whole[8], "Close(1001)");
    for size in (1..200).chain([1000, 65_536]) {
        assert!(read(&stream, || size) == whole, "chunks of {size}");
    }
    let mut random = Random(7);
    for _ in 0..50 {
        assert!(read(&stream, || random.below(300)) == whole);
    }
    for wrong in [&[0x82, 0x80][..], &[0xc2, 0], &[0x80, 0], &[0x09, 0], &[0x83, 0], &[0x89, 126, 0, 126]] {
        let said = read(wrong, || 1);
        assert!(said.len() == 1 && said[0].starts_with("the server breaks"), "{wrong:?}: {said:?}");
    }
}

#[test]
fn a_corrupted_frame_is_an_error() {
    let frame = vector("displacement");
    let judge = |frame: &[u8]| {
        let mut found = None;
        let whole =
            |message: Message<'_>| found = Some(if let Message::Bad(bad) = message { Err(bad) } else { Ok(()) });
        StreamReader::new(false).feed(&ws(0x82, frame), whole).unwrap();
        found.unwrap()
    };
    assert_eq!(judge(&frame), Ok(()));
    for at in (0..84).chain((88..frame.len()).step_by(97)) {
        let mut wrong = frame.to_vec();
        wrong[at] ^= 16;
        let bad = match at {
            0..6 => BadFrame::Header,
            52..56 => BadFrame::Length,
            _ => BadFrame::Checksum,
        };
        assert_eq!(judge(&wrong), Err(bad), "byte {at}");
    }
    for length in [0, 40, 87] {
        assert_eq!(judge(&frame[..length]), Err(BadFrame::Header));
    }
    assert_eq!(judge(&frame[..frame.len() - 1]), Err(BadFrame::Length));
}

#[test]
fn percentiles_are_within_a_bucket() {
    let mut random = Random(1);
    let (mut all, mut histogram, mut halves) =
        (Vec::new(), Histogram::default(), [(); 2].map(|()| Histogram::default()));
    for n in 0..20_000 {
        // From a microsecond to a minute, alike in each octave.
        let us = 2f64.powf(random.unit() * 26.0) as i64;
        all.push(us);
        histogram.add(us);
        halves[n % 2].add(us);
    }
    all.sort_unstable();
    for share in [0.001, 0.5, 0.9, 0.99, 0.999, 1.0] {
        let exact = all[((share * all.len() as f64).ceil() as usize).max(1) - 1] as f64 / 1e3;
        let got = histogram.percentile_ms(share).unwrap();
        assert!((exact..=exact * 1.016).contains(&got), "{share}: {got}, exactly {exact}");
    }
    let [mut merged, other] = halves;
    merged.merge(&other);
    assert_eq!(merged, histogram);
    assert_eq!(Histogram::default().percentile_ms(0.5), None);
    histogram.add(-5);
    histogram.add(i64::MAX);
    assert_eq!(histogram.percentile_ms(0.0), Some(0.0));
}

#[test]
fn ticks_may_come_in_any_order_and_each_counts_once() {
    let mut random = Random(3);
    for _ in 0..200 {
        let lost = |n: i64| n % 50 == 7;
        let mut numbers: Vec<i64> = (1000..1400).filter(|n| !lost(*n)).collect();
        // Each may come up to four places early.
        for at in 0..numbers.len() - 4 {
            numbers.swap(at, at + random.below(5));
        }
        let mut continuity = Continuity::default();
        assert!(numbers.iter().all(|n| continuity.take(*n)));
        assert!(numbers.iter().rev().take(20).all(|n| !continuity.take(*n)), "none comes twice");
        assert_eq!((continuity.came(), continuity.missing()), (392, 8));
    }
    // What may still be on its way is not missed yet.
    let mut continuity = Continuity::default();
    assert!([0, 1, 2, 3, 7].into_iter().all(|n| continuity.take(n)));
    assert_eq!(continuity.missing(), 0);
    assert!((8..20).all(|n| continuity.take(n)));
    assert_eq!(continuity.missing(), 3);
}

/// Sends back what it gets, on every connection.
async fn echo() -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            tokio::spawn(async move {
                let (mut from, mut to) = stream.split();
                let _ = tokio::io::copy(&mut from, &mut to).await;
            });
        }
    });
    address
}

async fn over(target: SocketAddr, settings: &str) -> (Link, TcpStream, Clock) {
    let clock = Clock::start(Clock::unix_now_ns());
    let link = Link::start(target, settings.parse().unwrap(), clock).await.unwrap();
    let stream = TcpStream::connect(link.address).await.unwrap();
    stream.set_nodelay(true).unwrap();
    (link, stream, clock)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_link_delays_within_its_jitter() {
    let (_link, mut stream, clock) = over(echo().await, "delay=20,jitter=10,up.delay=10,up.jitter=5").await;
    let mut trips = Vec::new();
    for byte in 0..30 {
        let begun = clock.now_us();
        stream.write_all(&[byte]).await.unwrap();
        assert_eq!(timeout(PATIENCE, stream.read_u8()).await.unwrap().unwrap(), byte);
        trips.push(clock.now_us() - begun);
    }
    let (least, most) = (trips.iter().min().unwrap(), trips.iter().max().unwrap());
    // A busy machine can only be slower.
    assert!((15_000..45_000).contains(least), "5 + 10 at least, 15 + 30 at most: {least}");
    assert!(most - least > 5_000, "it differs: {least} to {most}");
    // Nothing overtakes, and nothing is lost.
    let sent: Vec<u8> = (0..1_000_000u32).map(|n| (n % 251) as u8).collect();
    let (mut from, mut to) = stream.split();
    let mut got = vec![0; sent.len()];
    let (wrote, read) = tokio::join!(to.write_all(&sent), timeout(PATIENCE, from.read_exact(&mut got)));
    wrote.unwrap();
    read.unwrap().unwrap();
    assert!(got == sent);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_link_stalls_and_holds_back_the_sender() {
    // A sender that sends as fast as it can, and says how much it could.
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let target = listener.local_addr().unwrap();
    let sent = std::sync::Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let sending = std::sync::Arc::clone(&sent);
    tokio::spawn(async move {
        let (mut stream, _) = listener.accept().await.unwrap();
        while let Ok(n) = stream.write(&[0; 4096]).await {
            sending.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
        }
    });
    let (_link, mut stream, clock) = over(target, "delay=1,rate=40,stall=150/400,seed=5").await;
    let begun = clock.now_us();
    let (mut got, mut longest, mut last, mut buffer) = (0, 0, None, vec![0; 65_536]);
    while clock.now_us() - begun < 1_300_000 {
        got += timeout(PATIENCE, stream.read(&mut buffer)).await.unwrap().unwrap();
        let now = clock.now_us();
        longest = longest.max(now - last.unwrap_or(now));
        last = Some(now);
    }
    let seconds = (clock.now_us() - begun) as f64 / 1e6;
    assert!(got as f64 <= 5e6 * seconds + 65_536.0, "40 Mb/s at most: {got} bytes in {seconds} s");
    assert!(longest >= 140_000, "a stall takes 150 ms, the longest wait was {longest}");
    // It may be ahead by the link's buffer, and what the systems on both sides hold.
    let ahead = || sent.load(std::sync::atomic::Ordering::Relaxed) - got;
    assert!(ahead() < 8 << 20, "{} bytes ahead", ahead());
    // Who reads nothing holds it back altogether.
    let mut before = usize::MAX;
    for _ in 0..100 {
        if before == ahead() {
            break;
        }
        before = ahead();
        tokio::time::sleep(Duration::from_millis(500)).await;
    }
    assert_eq!(before, ahead(), "the sender waits");
    assert!(ahead() < 16 << 20, "{} bytes ahead", ahead());
}

#[test]
fn a_link_reads_its_settings_and_names_what_is_wrong() {
    let settings: LinkSettings = "delay=20,jitter=10,rate=50,stall=100/5000,up.rate=2,seed=9".parse().unwrap();
    assert_eq!((settings.up.delay_ms, settings.down.jitter_ms, settings.seed), (20.0, 10.0, 9));
    assert_eq!((settings.up.rate_mbps, settings.down.rate_mbps), (2.0, 50.0));
    assert_eq!((settings.up.stall_ms, settings.down.stall_every_ms), (0.0, 5000.0));
    for wrong in ["", "delay", "delay=-1", "delay=x", "jitter=1", "stall=5", "stall=5/5", "side.delay=1", "loss=1"] {
        assert!(wrong.parse::<LinkSettings>().is_err(), "{wrong:?}");
    }
}
