# Recipes of Swellcast; `.ci/run` calls the same ones' commands.

# What can be asked for.
default:
    @just --list

# Serve the default scene.
run *args:
    cargo run --release -- {{args}}

# Formatting, lints, documentation, purity of the core, dependencies.
check: fmt lint doc purity deny

fmt:
    cargo fmt --all --check
    cargo fmt --manifest-path tests/fuzz/Cargo.toml --check
    cargo fmt --manifest-path benches/peers/Cargo.toml --check

lint:
    cargo clippy --release --all-targets -- -D warnings

doc:
    RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps

# The core builds with neither network nor GPU.
purity:
    cargo check --release --lib --no-default-features
    ! cargo tree --no-default-features --edges normal --prefix none | grep -E '^(tokio|axum|hyper|wgpu|clap|anyhow) '

# Licences, sources, bans; advisories where their database can be fetched.
deny:
    .ci/deny

# Every test of the Rust side.
test:
    cargo test --release

# Whitecaps of 20 seeds and a minute each, at four winds.
foam:
    SWELLCAST_FULL=1 cargo test --release --test it foam::whitecaps -- --nocapture

# Write docs/stability.md anew, from the table of hard cases.
stability:
    SWELLCAST_BLESS=1 cargo test --release --test it stability::page

# Write docs/normals.md anew: errors and costs of the ways of normals, on this machine.
normals:
    cargo bench --bench normals -- --write

# Fuzz everything that comes from outside, for so many seconds a target.
fuzz seconds="60":
    .ci/fuzz {{seconds}}

# Conformance to RFC 6455, by the Autobahn test suite: all of it, or cases ("7.*"); --write writes docs/conformance.md.
autobahn *args:
    .ci/autobahn {{args}}

# The web client's own tests, and its types.
test-web:
    cd clients/web && SWELLCAST_REQUIRE_VECTORS=1 npm test && npm run check

# Whether the web client's WebAssembly is what its sources compile to; `write` writes it anew.
kernels *args:
    .ci/kernels {{args}}

# The Python client's tests, in an environment of its own.
test-python:
    .ci/python

# The C# client's tests, on Mono.
test-unity:
    .ci/unity

# One server and every client: the same digests of the same ticks, also after the server was killed.
interop seconds="60":
    .ci/interop {{seconds}}

# The viewer and the three.js example in headless Chromium, against servers started for it; `pace` measures what a page spends.
browser *args:
    .ci/browser {{args}}

# The README's pictures, made by the browser tests.
picture:
    .ci/browser docs

# Write the vectors anew, after a change of the protocol that is meant.
bless:
    SWELLCAST_BLESS=1 cargo test --release --test it vectors

# Every bench.
bench *args:
    cargo bench {{args}}

# Write docs/accuracy.html anew, and its still for the README: what accuracy costs on this machine; two minutes.
accuracy:
    cargo run --release -- accuracy --html docs/accuracy.html --still docs/accuracy.png

# Write docs/budget.md anew: what budgets of milliseconds pick on this machine, and whether that holds.
budget:
    cargo bench --bench budget -- --write

# Write docs/effects.md anew: what a running server spends on each demand, and how soon a joiner has frames.
effects:
    cargo bench --bench demand -- --write

# Write the GPU's part of docs/performance.md anew: the step by pass, beside the bytes that it must move.
bench-gpu:
    cargo bench --bench step_gpu -- --write

# Write the CPU's part of docs/performance.md anew: the step beside the bare transforms of FFTW; needs libfftw3-dev.
peers rounds="60":
    CARGO_TARGET_DIR=target cargo run --release --manifest-path benches/peers/Cargo.toml --bin fftw -- {{rounds}} docs/performance.md

# Write the codec's part of docs/codec.md anew: bytes, times and errors, on whole seconds of sea.
codec:
    cargo bench --bench encode -- --write

# Write the other part of docs/codec.md anew: the codec beside zfp, LERC and others; needs libzfp-dev and liblerc-dev.
codec-peers seconds="2":
    CARGO_TARGET_DIR=target cargo run --release --manifest-path benches/peers/Cargo.toml --bin codecs -- {{seconds}} docs/codec.md

# Write docs/fanout.md anew: fan-out beside raw sockets and axum's own WebSocket; ten minutes.
fanout *args="8 docs/fanout.md":
    CARGO_TARGET_DIR=target cargo run --release --manifest-path benches/peers/Cargo.toml --features fanout --bin fanout -- {{args}}

# Write docs/link.md anew: how well clients keep server time and playback over links that delay, jitter and stall; 95 s.
link:
    cargo bench --bench link -- --write

# Write the table of docs/trochoid.md anew.
trochoid:
    cargo bench --bench trochoid -- --write

# How many clients this machine holds, for three demands; `just load write` puts it into docs/load.md.
load *args:
    .ci/load {{args}}

# A long load: clients come and leave, the wind changes, memory stays; for so many seconds.
soak seconds="1800":
    .ci/soak {{seconds}}

# 100 of 1,000 clients stall, in pairs of runs with and without; `just stalled write` puts it into docs/load.md.
stalled *args:
    .ci/stalled {{args}}

# Everything, as on a fresh machine.
ci:
    .ci/run
