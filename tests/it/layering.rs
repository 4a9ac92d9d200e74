//! The order of the house: what each room may import, how a file begins, and how long it may grow.

use std::fs;
use std::path::{Path, PathBuf};

/// The rooms in the order the data flows. A room imports only rooms before it ...
const ORDER: [&str; 17] = [
    "wire",
    "scene",
    "sea",
    "plan",
    "pass",
    "backend",
    "reference",
    "tile",
    "engine",
    "body",
    "accuracy",
    "control",
    "recording",
    "server",
    "client",
    "load",
    "cli",
];

/// ... and of those not these: what each must not know.
const MUST_NOT_KNOW: [(&str, &[&str]); 7] = [
    // The reference checks the fast path, and shares none of it.
    ("reference", &["pass", "backend"]),
    ("tile", &["backend", "reference"]),
    // Read, and no more.
    ("body", &["sea", "plan", "pass", "backend", "reference", "tile"]),
    ("control", &["pass", "backend", "reference", "tile", "engine"]),
    // A file of frames and messages.
    ("recording", &["scene", "sea", "plan", "pass", "backend", "reference", "tile", "engine", "control"]),
    // A thin client has the protocol, a decoder and a clock.
    ("client", &["scene", "sea", "plan", "pass", "backend", "reference", "control", "server"]),
    // The load test sees a server as clients do.
    ("load", &["scene", "sea", "plan", "pass", "backend", "reference", "control"]),
];

const MOST_LINES: usize = 400;

/// What a source file of a room (its path below `src/`) imports against the order.
fn breaches(path: &str, text: &str) -> Vec<String> {
    let room = path.split(['/', '.']).next().unwrap_or_default();
    let Some(place) = ORDER.iter().position(|r| *r == room) else {
        return vec![format!("src/{path}: {room} is no room of tests/it/layering.rs")];
    };
    let hidden = MUST_NOT_KNOW.iter().find(|(r, _)| *r == room).map_or(&[][..], |(_, hidden)| hidden);
    let wrong = |import: &&str| {
        let at = ORDER.iter().position(|r| r == import);
        *import != room && at.is_some_and(|at| at > place || hidden.contains(import))
    };
    imports(path, text).iter().map(String::as_str).filter(wrong).map(|i| format!("src/{path} imports {i}")).collect()
}

/// The first name of every path from the root of the crate, `crate::a`, `crate::{a, b::c}` or `super` up to the root.
fn imports(path: &str, text: &str) -> Vec<String> {
    let code: String = text.lines().map(|l| l.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join(" ");
    // src/room/mod.rs is one `super` below the root, src/room/file.rs two.
    let parts = path.split('/').count();
    let depth = if path.ends_with("/mod.rs") { parts - 1 } else { parts };
    let mut found = Vec::new();
    for root in ["crate::".to_owned(), "super::".repeat(depth)] {
        for (at, _) in code.match_indices(&root) {
            if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let rest = code[at + root.len()..].trim_start();
            found.extend(match rest.strip_prefix('{') {
                Some(list) => names_of(list),
                None => vec![name(rest)],
            });
        }
    }
    found
}

/// The first names of a `use` list, up to its closing brace.
fn names_of(list: &str) -> Vec<String> {
    let (mut names, mut depth, mut start) = (Vec::new(), 0, true);
    for (at, c) in list.char_indices() {
        match c {
            '}' if depth == 0 => break,
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => start = true,
            c if start && !c.is_whitespace() => {
                names.push(name(&list[at..]));
                start = false;
            }
            _ => {}
        }
    }
    names
}

fn name(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Every file below a folder of the package, as paths relative to it; nothing built, fetched or borrowed.
fn files(folder: &str) -> Vec<String> {
    fn walk(at: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(at).into_iter().flatten().flatten() {
            let (path, name) = (entry.path(), entry.file_name());
            let skipped = ["node_modules", "target", "vendor", "dist", "Library", ".git"];
            if path.is_dir() && !skipped.iter().any(|s| name == *s) {
                walk(&path, found);
            } else if path.is_file() {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut found = Vec::new();
    walk(&root, &mut found);
    let relative = |path: &PathBuf| path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
    let mut names: Vec<String> = found.iter().map(relative).collect();
    names.sort();
    names
}

fn read(folder: &str, path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join(path)).unwrap()
}

#[test]
fn a_room_imports_only_rooms_before_it() {
    let rooms = files("src").into_iter().filter(|path| path.ends_with(".rs") && path.contains('/'));
    let wrong: Vec<String> = rooms.flat_map(|path| breaches(&path, &read("src", &path))).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_breach_of_the_order_is_seen() {
    for (path, text) in [
        ("wire/frame.rs", "use crate::scene::Scene;"),
        ("tile/encode.rs", "use crate::{wire::Group, backend::{Backend, cpu}};"),
        ("tile/mod.rs", "fn f() { crate::backend::select() }"),
        ("control/log.rs", "use crate::engine::Clock;"),
        ("sea/timeline.rs", "use super::super::engine::Clock;"),
        ("sea/mod.rs", "use super::engine::Clock;"),
        ("backend/gpu/mod.rs", "pub(crate) use super::super::engine::Clock;"),
        ("client/watch.rs", "use crate::\n    {wire, server};"),
        ("attic/mod.rs", ""),
    ] {
        assert_eq!(breaches(path, text).len(), 1, "{path}: {text}");
    }
    for (path, text) in [
        ("engine/step.rs", "use crate::{backend::Backend, sea::{Layout, engine}, wire};"),
        ("engine/mod.rs", "// use crate::server::Server;\n//! [`crate::server`]"),
        ("sea/timeline.rs", "use super::engine; use not_crate::engine; use swellcast_crate::server;"),
        ("sea/a/b.rs", "use super::super::engine; use crate::sea::draw;"),
    ] {
        assert_eq!(breaches(path, text), Vec::<String>::new(), "{path}: {text}");
    }
}

#[test]
fn every_source_file_says_first_what_it_owns() {
    for path in files("src").into_iter().filter(|path| path.ends_with(".rs")) {
        assert!(read("src", &path).starts_with("//! "), "src/{path} doesn't begin with //!");
    }
}

#[test]
fn no_file_grows_beyond_reading() {
    for folder in ["src", "tests", "benches", "clients"] {
        for path in files(folder) {
            let ending = path.rsplit('.').next().unwrap_or_default();
            if ["rs", "wgsl", "js", "mjs", "ts", "py", "cs", "html", "css"].contains(&ending) {
                let lines = read(folder, &path).lines().count();
                assert!(lines <= MOST_LINES, "{folder}/{path} has {lines} lines, at most {MOST_LINES}: split it");
            }
        }
    }
}

#[test]
fn bincode_is_named_in_one_file() {
    let named = |path: &String| read("src", path).contains("bincode");
    let named: Vec<String> = files("src").into_iter().filter(|p| p.ends_with(".rs")).filter(named).collect();
    assert_eq!(named, ["wire/frame.rs"], "deny.toml says so");
}
