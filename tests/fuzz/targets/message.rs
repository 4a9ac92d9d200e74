//! Text from clients, from servers and in the bodies of the HTTP API: refused with a reason, or what it says.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use swellcast::body::{ChangeBody, ProbeBody, Problem};
use swellcast::scene::{Change, ChangeKind, MAX_TRANSITION_TICKS, Scene, preset};
use swellcast::wire::{ClientMessage, FARTHEST_M, MAX_TICK, ServerMessage};

static SCENE: LazyLock<Scene> = LazyLock::new(|| preset("beaufort-5").expect("a preset"));
/// When the request came, and the first tick at which it could act.
const NOW: (i64, i64) = (72_000, 74_000);

fuzz_target!(|bytes: &[u8]| {
    change(ChangeBody::wind(bytes));
    change(ChangeBody::sea(bytes));
    change(ChangeBody::layout(bytes));
    probe(bytes);
    if let Ok(text) = std::str::from_utf8(bytes) {
        from_client(text);
        from_server(text);
    }
});

fn from_client(text: &str) {
    match ClientMessage::parse(text) {
        Ok(message) => {
            let again = serde_json::to_string(&message).expect("a message can be written");
            assert_eq!(ClientMessage::parse(&again), Ok(message), "{again}");
        }
        Err(error) => {
            assert!(!error.detail.is_empty() && error.detail.len() < 1000, "{} bytes of detail", error.detail.len());
        }
    }
}

fn from_server(text: &str) {
    if let Ok(Some(message)) = ServerMessage::parse(text) {
        let again = message.to_json();
        assert_eq!(ServerMessage::parse(&again).ok().flatten(), Some(message), "{again}");
    }
}

/// What the server does with a body until it asks the running sea.
fn change(body: Result<ChangeBody, Problem>) {
    let asked = match body {
        Ok(asked) => asked,
        Err(problem) => return refused(&problem),
    };
    let kind = match asked.kind.check() {
        Ok(kind) => kind,
        Err(error) => return refused(&Problem::from(error)),
    };
    assert_eq!(kind.clone().check(), Ok(kind.clone()), "what is checked stays");
    // As the log and the clients' messages hold it.
    let text = serde_json::to_string(&kind).expect("a change can be written");
    assert_eq!(serde_json::from_str::<ChangeKind>(&text).ok().as_ref(), Some(&kind), "{text}");
    let effective_tick = asked.when.tick(NOW.0, NOW.1);
    match Change::check_time(&kind, effective_tick, asked.transition_s) {
        Ok(transition_ticks) => {
            assert!((0..=MAX_TRANSITION_TICKS).contains(&transition_ticks));
            let change = Change { sequence: 1, effective_tick, transition_ticks, kind: kind.clone() };
            assert_eq!(change.check(), Ok(()));
        }
        Err(error) => refused(&Problem::from(error)),
    }
    if let Err(error) = kind.fits(&SCENE) {
        return refused(&Problem::from(error));
    }
    let mut scene = SCENE.clone();
    kind.apply(&mut scene);
    let wind = scene.sea.wind.expect("the scene has wind");
    assert!((0.0..=100.0).contains(&wind.speed_mps) && (0.0..360.0).contains(&wind.direction_from_deg));
    assert!(scene.sea.water.depth_m >= 1e-3 && (0.1..=100.0).contains(&scene.sea.water.gravity));
}

fn probe(bytes: &[u8]) {
    match ProbeBody::read(bytes, &SCENE) {
        Ok(asked) => {
            assert!((1..=10_000).contains(&asked.points.len()));
            assert!(asked.points.iter().flatten().all(|metres| metres.abs() <= FARTHEST_M));
            assert!(asked.tick.is_none_or(|tick| (0..=MAX_TICK).contains(&tick)));
        }
        Err(problem) => {
            refused(&problem);
            assert!(problem.document().len() < 2000, "what was sent is not sent back");
        }
    }
}

fn refused(problem: &Problem) {
    let document: serde_json::Value = serde_json::from_str(&problem.document()).expect("a problem is JSON");
    assert!(document["detail"].as_str().is_some_and(|detail| !detail.is_empty()), "{document}");
    assert!((400..500).contains(&document["status"].as_u64().unwrap_or_default()), "{document}");
}
