//! The client messages that a server must refuse, with the code and the field of its answer.

use serde_json::json;

/// A text to refuse.
pub struct BadMessage {
    /// What is wrong with it.
    pub why: &'static str,
    /// `code` of the answer.
    pub code: &'static str,
    /// `field` of the answer; `None` when it has none.
    pub field: Option<&'static str>,
    /// The message.
    pub text: String,
}

/// Every text that must be refused.
pub fn bad_messages() -> Vec<BadMessage> {
    let mut all = Vec::new();
    let mut bad = |code, field, why, text: &str| all.push(BadMessage { why, code, field, text: text.to_owned() });
    not_objects(&mut |why, text| bad("malformed", None, why, text));

    bad("malformed", Some("type"), "no type", r#"{"t0":1}"#);
    bad("malformed", Some("type"), "the type is a number", r#"{"type":7,"t0":1}"#);
    bad("malformed", Some("type"), "the type is null", r#"{"type":null,"t0":1}"#);
    bad("malformed", Some("type"), "the type stands twice", r#"{"type":"time","type":"time","t0":1}"#);
    for text in ["hello", "Time", "time ", "", "status"] {
        bad("unknown_type", Some("type"), "no such message from a client", &json!({"type":text,"t0":1}).to_string());
    }

    let malformed = "malformed";
    bad(malformed, Some("t0"), "no t0", r#"{"type":"time"}"#);
    bad(malformed, Some("t0"), "t0 is a string", r#"{"type":"time","t0":"1"}"#);
    bad(malformed, Some("t0"), "t0 is null, as JavaScript writes NaN", r#"{"type":"time","t0":null}"#);
    bad(malformed, Some("t0"), "t0 stands twice", r#"{"type":"time","t0":1,"t0":2}"#);
    bad(malformed, Some("t1"), "a field that is not known", r#"{"type":"time","t0":1,"t1":2}"#);
    bad(malformed, Some("T0"), "names are case-sensitive", r#"{"type":"time","T0":1}"#);

    let subscribe = |id: &str, rate: &str, units: &str| {
        format!(r#"{{"type":"subscribe","id":{id},"rate_hz":{rate},"units":{units}}}"#)
    };
    bad(malformed, Some("id"), "no id", r#"{"type":"subscribe","rate_hz":15,"units":[]}"#);
    bad(malformed, Some("rate_hz"), "no rate_hz", r#"{"type":"subscribe","id":1,"units":[]}"#);
    bad(malformed, Some("units"), "no units", r#"{"type":"subscribe","id":1,"rate_hz":15}"#);
    bad(malformed, Some("unit"), "a misspelt field", r#"{"type":"subscribe","id":1,"rate_hz":15,"unit":[]}"#);
    bad(malformed, Some("units"), "units stands twice", {
        r#"{"type":"subscribe","id":1,"rate_hz":15,"units":[],"units":[]}"#
    });
    bad(malformed, Some("id"), "the id is a string", &subscribe("\"1\"", "15", "[]"));
    bad(malformed, Some("rate_hz"), "the rate is a boolean", &subscribe("1", "true", "[]"));
    bad(malformed, Some("units"), "units is an object", &subscribe("1", "15", "{}"));
    bad(malformed, Some("units"), "units is null", &subscribe("1", "15", "null"));
    for id in ["9007199254740992", "18446744073709551615", "18446744073709551616", "-1", "0.5", "1e300"] {
        bad("invalid", Some("id"), "the id is no whole number from 0 to 2^53 - 1", &subscribe(id, "15", "[]"));
    }
    for rate in ["-15", "4294967296", "29.97", "1e18"] {
        bad("invalid", Some("rate_hz"), "the rate is no whole number of 32 bits", &subscribe("1", rate, "[]"));
    }

    let unit = |unit: &str| subscribe("1", "15", &format!("[{unit}]"));
    bad(malformed, Some("units[0]"), "a unit is an array", &unit(r#"[0,0,"1mm","foam"]"#));
    bad(malformed, Some("units[0]"), "a unit is a number", &unit("0"));
    bad(malformed, Some("units[0].group"), "a unit without group", &unit(r#"{"cascade":0,"level":0,"class":"1mm"}"#));
    for (field, why, wrong) in [
        ("units[0].rate", "a unit with a field that is not known", {
            r#"{"cascade":0,"level":0,"class":"1mm","group":"foam","rate":15}"#
        }),
        ("units[0].rate_hz", "a unit's rate is a string", {
            r#"{"cascade":0,"level":0,"class":"1mm","group":"foam","rate_hz":"15"}"#
        }),
        ("units[0].level", "a level stands twice", r#"{"cascade":0,"level":0,"level":1,"class":"1mm","group":"foam"}"#),
        ("units[0].class", "a class is an object", r#"{"cascade":0,"level":0,"class":{"1mm":null},"group":"foam"}"#),
        ("units[0].class", "a class by its number", r#"{"cascade":0,"level":0,"class":1,"group":"foam"}"#),
    ] {
        bad(malformed, Some(field), why, &unit(wrong));
    }
    for (field, why, wrong) in [
        ("units[0].cascade", "a cascade of 256", r#"{"cascade":256,"level":0,"class":"1mm","group":"foam"}"#),
        ("units[0].cascade", "a cascade of 0.5", r#"{"cascade":0.5,"level":0,"class":"1mm","group":"foam"}"#),
        ("units[0].level", "a level of -1", r#"{"cascade":0,"level":-1,"class":"1mm","group":"foam"}"#),
        ("units[0].class", "no such class", r#"{"cascade":0,"level":0,"class":"2mm","group":"foam"}"#),
        ("units[0].group", "no such group", r#"{"cascade":0,"level":0,"class":"1mm","group":"Foam"}"#),
        ("units[0].codec", "no such codec", {
            r#"{"cascade":0,"level":0,"class":"1mm","group":"foam","codec":"zstd"}"#
        }),
    ] {
        bad("invalid", Some(field), why, &unit(wrong));
    }
    bad(
        malformed,
        Some("units[0].codec"),
        "a codec by its number",
        &unit(r#"{"cascade":0,"level":0,"class":"1mm","group":"foam","codec":1}"#),
    );
    bad(malformed, Some("keys"), "keys is a number", r#"{"type":"subscribe","id":1,"rate_hz":15,"units":[],"keys":1}"#);
    bad(malformed, Some("buffer_ms"), "a report without buffer_ms", r#"{"type":"report","tick":0,"decode_ms":1}"#);
    bad(malformed, Some("lost"), "lost is a string", {
        r#"{"type":"report","tick":0,"decode_ms":1,"buffer_ms":1,"lost":"no"}"#
    });
    bad("invalid", Some("tick"), "a report of a tick below 0", {
        r#"{"type":"report","tick":-1,"decode_ms":1,"buffer_ms":1}"#
    });
    let points = |points: &str| format!(r#"{{"type":"points","id":1,"rate_hz":15,"points":{points}}}"#);
    bad(malformed, Some("points"), "no points", r#"{"type":"points","id":1,"rate_hz":15}"#);
    bad(malformed, Some("points"), "points is an object", &points("{}"));
    bad(malformed, Some("units"), "points have no units", r#"{"type":"points","id":1,"rate_hz":15,"units":[]}"#);
    bad(malformed, Some("points[0]"), "a point is a number", &points("[1,2]"));
    bad(malformed, Some("points[1]"), "a point of three numbers", &points("[[1,2],[1,2,3]]"));
    bad(malformed, Some("points[0]"), "a point of one number", &points("[[1]]"));
    bad(malformed, Some("points[0][1]"), "a coordinate is null", &points("[[1,null]]"));
    bad("invalid", Some("points[0][0]"), "a point beyond a million kilometres", &points("[[-1.1e9,0]]"));
    bad("invalid", Some("id"), "the id of points below 0", r#"{"type":"points","id":-1,"rate_hz":15,"points":[]}"#);
    let good = r#"{"cascade":0,"level":0,"class":"1mm","group":"foam"}"#;
    bad(malformed, Some("units[1]"), "the second unit is null", &unit(&format!("{good},null")));
    all
}

/// Texts that are no JSON object at all; their refusal names no field.
fn not_objects(bad: &mut impl FnMut(&'static str, &str)) {
    bad("no text", "");
    bad("only white space", " \n");
    bad("not JSON", "subscribe");
    bad("JSON cut short", r#"{"type":"time","t0":"#);
    bad("something follows the object", r#"{"type":"time","t0":1} {}"#);
    bad("a trailing comma", r#"{"type":"time","t0":1,}"#);
    bad("single quotes", "{'type':'time','t0':1}");
    bad("a comment", "{\"type\":\"time\",\"t0\":1} // now");
    bad("NaN is not JSON", r#"{"type":"time","t0":NaN}"#);
    bad("Infinity is not JSON", r#"{"type":"time","t0":-Infinity}"#);
    bad("a number above any double", r#"{"type":"time","t0":1e999}"#);
    bad("a leading zero", r#"{"type":"time","t0":01}"#);
    bad("a control character in a string", "{\"type\":\"ti\u{1}me\",\"t0\":1}");
    bad("half of a surrogate pair", r#"{"type":"\ud800","t0":1}"#);
    bad("an array", r#"["time",1]"#);
    bad("a string", r#""time""#);
    bad("a number", "1");
    bad("null", "null");
    bad("two thousand arrays in one another", &format!("{}{}", "[".repeat(2000), "]".repeat(2000)));
    bad("five hundred objects in one another", &format!("{}1{}", "{\"a\":".repeat(500), "}".repeat(500)));
    bad("an array of 2000 zeros", &format!("[{}0]", "0,".repeat(1999)));
    let long = format!(r#"{{"type":"time","t0":1{}}}"#, " ".repeat(131_072));
    bad("above 131072 bytes (a server closes with 1009 before it parses)", &long);
}

/// `invalid/messages.json`.
pub fn text() -> String {
    let line = |bad: &BadMessage| {
        let (why, code, field) = (json!(bad.why), json!(bad.code), json!(bad.field));
        format!("  {{\"why\": {why}, \"code\": {code}, \"field\": {field}, \"text\": {}}}", json!(bad.text))
    };
    format!("[\n{}\n]\n", bad_messages().iter().map(line).collect::<Vec<_>>().join(",\n"))
}
