#!/usr/bin/env bash
# Builds everything and runs the tests; SWELLCAST_BIN names the server for those that need one (skipped without, which
# SWELLCAST_REQUIRE_LIVE=1 turns into a failure). Usage: test.sh [OUT [NAME]]
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
out="${1:-$(mktemp -d)}"
"$here/build.sh" "$out"
"$here/meta.sh" --check
if [ -z "${SWELLCAST_BIN:-}" ]; then
    echo "SKIPPED: tests against a server, since SWELLCAST_BIN names none" >&2
    [ "${SWELLCAST_REQUIRE_LIVE:-0}" != 1 ] || exit 1
fi
mono --debug "$out/Tests.exe" "$here/../../proto/vectors" ${2:+"$2"}
