//! The valid text messages of the vectors, of both sides.

use serde_json::json;
use swellcast::wire::{
    ClientMessage, Codec, ErrorClass, ErrorCode, Group, Hello, HelloCascade, HelloDetail, HelloLayout, Limits,
    MAX_MESSAGE_BYTES, MAX_TICK, Points, PointsSubscribed, Quality, Report, ServerMessage, Status, Subscribe,
    Subscribed, TICKS_PER_SECOND, Time, TimeAnswer, UnitName, UnitRate, WindStatus, WireChange, WireChangeKind,
};

fn unit(cascade: u8, level: u8, class: ErrorClass, group: Group) -> UnitName {
    UnitName { cascade, level, class, group, codec: Codec::I16 }
}

/// What a client may say, and the same as text.
pub fn from_clients() -> Vec<(&'static str, ClientMessage, String)> {
    let units = vec![
        unit(0, 0, ErrorClass::Millimetre, Group::Displacement),
        unit(0, 0, ErrorClass::HalfMillimetre, Group::Slopes),
        unit(1, 2, ErrorClass::FiveMillimetres, Group::Derivatives),
        unit(255, 255, ErrorClass::TwentyMillimetres, Group::Foam),
        unit(0, 1, ErrorClass::Millimetre, Group::Height),
        unit(0, 1, ErrorClass::Millimetre, Group::Velocity),
        unit(0, 1, ErrorClass::Millimetre, Group::Jacobian),
        unit(0, 1, ErrorClass::Millimetre, Group::Stretch),
        unit(0, 1, ErrorClass::Millimetre, Group::Normals),
    ];
    let units: Vec<UnitRate> = units.into_iter().map(UnitRate::from).collect();
    let rates: Vec<UnitRate> =
        units.iter().zip([Some(60), None, Some(15)]).map(|(unit, rate_hz)| UnitRate { rate_hz, ..*unit }).collect();
    let subscribe = |id, rate_hz, units| ClientMessage::Subscribe(Subscribe { id, rate_hz, units, keys: false });
    let points = |id, rate_hz, points| ClientMessage::Points(Points { id, rate_hz, points });
    let report = |tick, decode_ms, buffer_ms, lost| ClientMessage::Report(Report { tick, decode_ms, buffer_ms, lost });
    let time = |t0| ClientMessage::Time(Time { t0 });
    let written = |name, message: ClientMessage| {
        let text = serde_json::to_string(&message).expect("plain data");
        (name, message, text)
    };
    vec![
        written("subscribe to every class and group", subscribe(1, 15, units.clone())),
        written("subscribe to units at rates of their own", subscribe(4, 30, rates)),
        written("stop the flow", subscribe(2, 30, vec![])),
        written("the largest id", subscribe(MAX_TICK as u64, 60, vec![])),
        written("points", points(5, 15, vec![[0.0, -0.5], [1e9, -1e9], [12.25, 3.5]])),
        written("no more points", points(6, 30, vec![])),
        written("a report", report(7200, 1.25, 180.5, false)),
        written("a report of one that has lost its place", report(0, 0.0, -20.0, true)),
        written("units of every codec, and key frames", {
            let coded = |codec| UnitRate::from(UnitName { codec, ..unit(1, 0, ErrorClass::Millimetre, Group::Slopes) });
            let units = Codec::ALL.map(coded).to_vec();
            ClientMessage::Subscribe(Subscribe { id: 7, rate_hz: 60, units, keys: true })
        }),
        written("a time of microseconds", time(1_234_567.0)),
        written("a time with a fraction", time(1_234.567_800_001)),
        written("a time below zero", time(-0.5)),
        (
            "any order of fields, any white space, escapes",
            subscribe(3, 15, units[..1].to_vec()),
            "\n{ \"units\" : [ {\"group\":\"displacement\", \"class\":\"1mm\",\t\"level\":0,\"cascade\":0} ],\r\n \
             \"rate_hz\":15, \"id\":3, \"\\u0074ype\":\"subscribe\" }\n"
                .to_owned(),
        ),
        ("a whole number as time", time(7.0), r#"{"type":"time","t0":7}"#.to_owned()),
        ("an exponent as time", time(1500.0), r#"{"type":"time","t0":1.5e3}"#.to_owned()),
    ]
}

/// What a server says.
pub fn from_server() -> Vec<(&'static str, ServerMessage)> {
    let cascade = |index, patch_m, n, levels| HelloCascade {
        index,
        patch_m,
        n,
        levels,
        wavelength_min_m: 1.0,
        wavelength_max_m: patch_m,
        from_tick: 0,
        until_tick: None,
        detail: vec![],
    };
    let hello = Hello {
        protocol: 1,
        server: "swellcast 0.1.0".to_owned(),
        scene: "beaufort-5".to_owned(),
        epoch: "0123456789abcdef".to_owned(),
        seed: u64::MAX.to_string(),
        ticks_per_second: TICKS_PER_SECOND,
        tick: 86_400 * TICKS_PER_SECOND,
        lead_ticks: 1680,
        sequence: 1,
        layout: HelloLayout {
            generation: 2,
            cascades: vec![
                HelloCascade { wavelength_min_m: 8.0, wavelength_max_m: 250.0, ..cascade(0, 250.0, 256, 4) },
                HelloCascade { wavelength_min_m: 0.25, wavelength_max_m: 8.0, ..cascade(1, 19.5, 512, 5) },
            ],
        },
        choppiness: 1.0,
        rates_hz: vec![15, 30, 60],
        classes: Hello::all_classes(),
        groups: Hello::groups(|_| true),
        foam_step_ticks: 240,
        limits: Limits { message_bytes: MAX_MESSAGE_BYTES as u32, units: 32, live_units: 64, points: 2000 },
    };
    let status = Status {
        tick: MAX_TICK,
        sequence: 3,
        hs_m: 2.125,
        wind: Some(WindStatus { speed_mps: 9.5, direction_from_deg: 225.0 }),
        wind_range_mps: Some([4.0, 16.0]),
        depth_m: None,
        clients: 12,
        backend: "cpu".to_owned(),
        step_ms: 1.75,
        skipped_frames: 0,
    };
    let swell = Status { wind: None, wind_range_mps: None, depth_m: Some(20.0), ..status.clone() };
    let change = |sequence, change| {
        ServerMessage::Change(WireChange { sequence, effective_tick: 72_000, transition_ticks: 216_000, change })
    };
    let error = |code, detail: &str, field: Option<&str>, id| ServerMessage::Error {
        code,
        detail: detail.to_owned(),
        field: field.map(str::to_owned),
        id,
    };
    let units = vec![
        unit(0, 0, ErrorClass::HalfMillimetre, Group::Displacement).into(),
        UnitRate { unit: unit(1, 1, ErrorClass::Millimetre, Group::Normals), rate_hz: Some(60) },
    ];
    let (begins, ends) = (hello.tick + 7200, hello.tick + 7200 + 72_000 + 1440);
    let old = HelloCascade { until_tick: Some(ends), ..cascade(0, 250.0, 256, 4) };
    let detail = |group, finest_level, rate_hz| HelloDetail { group, finest_level, rate_hz };
    let detail = vec![detail(Group::Displacement, 1, Some(15)), detail(Group::Slopes, 2, None)];
    let new = HelloCascade { from_tick: begins, detail, ..cascade(8, 120.0, 128, 3) };
    let changing =
        Hello { layout: HelloLayout { generation: 3, cascades: vec![old, new] }, sequence: 2, ..hello.clone() };
    let patches = WireChangeKind::Layout {
        n: Some(128),
        band_limit: 0.5,
        finest_wavelength_m: 0.3,
        patches_m: vec![120.0],
        wind_range_mps: Some([2.0, 12.0]),
    };
    let automatic = WireChangeKind::Layout {
        n: None,
        band_limit: 0.25,
        finest_wavelength_m: 0.5,
        patches_m: vec![],
        wind_range_mps: None,
    };
    vec![
        ("hello", ServerMessage::Hello(Box::new(hello))),
        ("a further hello, while the layout changes", ServerMessage::Hello(Box::new(changing))),
        ("subscribed", ServerMessage::Subscribed(Subscribed { id: 1, rate_hz: 15, units, from_tick: 7200 })),
        (
            "points_subscribed",
            ServerMessage::PointsSubscribed(PointsSubscribed { id: 5, rate_hz: 15, from_tick: 7200, count: 3 }),
        ),
        (
            "time",
            ServerMessage::Time(TimeAnswer { t0: 1_234.567_800_001, t1_us: 86_400_000_000, t2_us: 86_400_000_017 }),
        ),
        ("quality", ServerMessage::Quality(Quality { rate_hz: 15, coarser: 1 })),
        ("status with wind", ServerMessage::Status(status)),
        ("status of a sea without wind", ServerMessage::Status(swell)),
        ("a change of wind", change(2, WireChangeKind::Wind { speed_mps: 12.5, direction_from_deg: 359.5 })),
        ("a change of depth", change(3, WireChangeKind::Water { depth_m: Some(8.0), gravity: None })),
        ("infinitely deep", change(4, WireChangeKind::Water { depth_m: Some(f64::INFINITY), gravity: None })),
        ("a change of gravity", change(5, WireChangeKind::Water { depth_m: None, gravity: Some(3.72) })),
        ("a change of layout", change(6, patches)),
        ("an automatic layout", change(7, automatic)),
        ("an error with all its fields", error(ErrorCode::Invalid, "id is -1", Some("id"), Some(7))),
        ("an error with none", error(ErrorCode::Malformed, "not JSON", None, None)),
    ]
}

/// Texts of a later server that a client must take: name, text, and whether to ignore the whole message.
pub fn from_later_servers() -> Vec<(&'static str, &'static str, bool)> {
    vec![
        ("a type of a later version", r#"{"type":"tide","height_m":0.5}"#, true),
        ("a field of a later version", r#"{"type":"error","code":"invalid","detail":"-","since":[{"a":null}]}"#, false),
    ]
}

/// `messages.json`.
pub fn valid() -> String {
    let mut lines = Vec::new();
    for (name, _, text) in from_clients() {
        lines.push(json!({ "from": "client", "about": name, "text": text }).to_string());
    }
    for (name, message) in from_server() {
        lines.push(json!({ "from": "server", "about": name, "text": message.to_json() }).to_string());
    }
    for (name, text, ignore) in from_later_servers() {
        lines.push(json!({ "from": "server", "about": name, "text": text, "ignore": ignore }).to_string());
    }
    format!("[\n  {}\n]\n", lines.join(",\n  "))
}
