//! The vectors in `proto/vectors`: what they hold stands here, and the files are held to it byte for byte.
//!
//! `SWELLCAST_BLESS=1 cargo test --release --test it vectors` writes them anew.

mod bad_frames;
mod bad_messages;
mod clock;
mod frames;
mod messages;
mod points;
mod streams;

use std::fs;
use std::path::PathBuf;

pub use bad_messages::bad_messages;
pub use frames::{describe, samples};
pub use messages::{from_clients, from_later_servers, from_server};

/// Where the vectors lie.
pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("proto/vectors")
}

/// Where files lie below it.
const FOLDERS: [&str; 5] = ["", "invalid", "invalid/payloads", "points", "streams"];

/// Every file of the vectors and what it must hold.
fn all() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for sample in samples() {
        files.push((format!("{}.bin", sample.name), sample.bytes()));
        files.push((format!("{}.json", sample.name), describe(&sample).into_bytes()));
    }
    for sample in points::samples() {
        files.push((format!("points/{}.bin", sample.0), points::bytes(&sample)));
        files.push((format!("points/{}.json", sample.0), points::describe(&sample).into_bytes()));
    }
    for stream in streams::all() {
        files.push((format!("streams/{}.frames", stream.name), streams::bytes(&stream)));
        files.push((format!("streams/{}.json", stream.name), streams::describe(&stream).into_bytes()));
    }
    for (name, _, bytes) in streams::damaged() {
        files.push((format!("invalid/payloads/{name}.bin"), bytes));
    }
    files.push(("invalid/payloads/index.json".to_owned(), streams::index().into_bytes()));
    files.push(("clock.json".to_owned(), clock::text().into_bytes()));
    files.push(("messages.json".to_owned(), messages::valid().into_bytes()));
    let bad = bad_frames::all();
    for (name, _, _, bytes) in &bad {
        files.push((format!("invalid/{name}.bin"), bytes.clone()));
    }
    files.push(("invalid/index.json".to_owned(), bad_frames::index(&bad).into_bytes()));
    files.push(("invalid/messages.json".to_owned(), bad_messages::text().into_bytes()));
    files
}

#[test]
fn vectors_are_what_the_code_says() {
    let bless = std::env::var_os("SWELLCAST_BLESS").is_some();
    let files = all();
    if bless {
        let _ = fs::remove_dir_all(folder());
        FOLDERS.iter().for_each(|name| fs::create_dir_all(folder().join(name)).unwrap());
    }
    for (name, bytes) in &files {
        let path = folder().join(name);
        if bless {
            fs::write(&path, bytes).unwrap();
        }
        let held = fs::read(&path).unwrap_or_else(|e| panic!("{name}: {e}; run `just bless`"));
        assert!(held == *bytes, "{name} differs from what the code says; if that is meant, run `just bless`");
    }
    let mut expected: Vec<_> = files.iter().map(|(name, _)| folder().join(name)).collect();
    let mut found: Vec<_> = FOLDERS
        .iter()
        .flat_map(|name| fs::read_dir(folder().join(name)).unwrap().map(|entry| entry.unwrap().path()))
        .filter(|path| path.is_file())
        .collect();
    expected.sort();
    found.sort();
    assert_eq!(found, expected, "files nobody describes, or missing ones");
    let total: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    assert!(total < 600_000, "the vectors are {total} bytes");
}
