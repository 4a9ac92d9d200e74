//! The browser viewer's files, embedded: the binary alone serves them.

use std::sync::LazyLock;

use axum::response::{IntoResponse, Response};
use http::{HeaderMap, StatusCode, header};

macro_rules! files {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/clients/web/", $path)))),*]
    };
}

/// Paths under `clients/web` and their bytes. A test says what is missing here.
const FILES: &[(&str, &[u8])] = files![
    "index.html",
    "style.css",
    "src/client.js",
    "src/clock.js",
    "src/connection.js",
    "src/crc32.js",
    "src/decode.js",
    "src/deflate.js",
    "src/fares.js",
    "src/fields.js",
    "src/frame.js",
    "src/gl.js",
    "src/history.js",
    "src/index.js",
    "src/joined.js",
    "src/kernels.js",
    "src/kernels.wasm.js",
    "src/messages.js",
    "src/plan.js",
    "src/playback.js",
    "src/predict.js",
    "src/ring.js",
    "src/unit.js",
    "src/upload.js",
    "src/worker.js",
    "viewer/camera.js",
    "viewer/deck.js",
    "viewer/foam.js",
    "viewer/gputime.js",
    "viewer/grid.js",
    "viewer/lift.js",
    "viewer/main.js",
    "viewer/options.js",
    "viewer/pace.js",
    "viewer/panel.js",
    "viewer/quality.js",
    "viewer/renderer.js",
    "viewer/sky.js",
    "viewer/solids.js",
    "viewer/view.js",
    "viewer/water.js",
    "viewer/xr.js",
];

/// A strong tag for each file, in the same order.
static TAGS: LazyLock<Vec<String>> = LazyLock::new(|| {
    FILES.iter().map(|(_, bytes)| format!("\"{:08x}-{:x}\"", crc32fast::hash(bytes), bytes.len())).collect()
});

/// The file at a path of the server, or `None`.
pub fn file(path: &str, headers: &HeaderMap) -> Option<Response> {
    let path = if path == "/" { "index.html" } else { path.strip_prefix('/')? };
    let index = FILES.iter().position(|(known, _)| *known == path)?;
    let (bytes, tag) = (FILES[index].1, TAGS[index].as_str());
    // `no-cache` still lets a browser keep the file: it asks each time and is answered 304.
    let common =
        [(header::ETAG, tag), (header::CACHE_CONTROL, "no-cache"), (header::X_CONTENT_TYPE_OPTIONS, "nosniff")];
    let known = headers.get(header::IF_NONE_MATCH).and_then(|value| value.to_str().ok()).unwrap_or_default();
    if known.split(',').any(|known| matches!(known.trim(), "*") || known.trim().trim_start_matches("W/") == tag) {
        return Some((StatusCode::NOT_MODIFIED, common).into_response());
    }
    Some((common, [(header::CONTENT_TYPE, content_type(path))], bytes).into_response())
}

fn content_type(path: &str) -> &'static str {
    match path.rsplit('.').next().unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "json" => "application/json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "wasm" => "application/wasm",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::Path;

    fn walk(folder: &Path, base: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, base, found);
            } else {
                found.push(path.strip_prefix(base).unwrap().to_str().unwrap().replace('\\', "/"));
            }
        }
    }

    #[test]
    fn every_file_of_the_viewer_is_embedded() {
        let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/web");
        let mut found: Vec<String> =
            ["index.html", "style.css"].map(String::from).into_iter().filter(|name| base.join(name).exists()).collect();
        for folder in ["src", "viewer"] {
            walk(&base.join(folder), &base, &mut found);
        }
        found.sort();
        let mut embedded: Vec<String> = FILES.iter().map(|(path, _)| (*path).to_owned()).collect();
        embedded.sort();
        assert_eq!(embedded, found, "list every file of clients/web in `FILES`");
        for (path, _) in FILES {
            assert_ne!(content_type(path), "application/octet-stream", "{path} needs a content type");
        }
    }
}
