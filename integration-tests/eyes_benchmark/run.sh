#!/usr/bin/env bash
# The benchmark of the eyes, from nothing: fetches objects and pairs, builds, runs. Arguments as of periplus-eyes-benchmark.
set -euo pipefail
cd "$(dirname "$0")/../.."
deploy/setup.sh >&2
deploy/fetch-assets.sh --stereo >&2
[ -f build/release/build.ninja ] || cmake --preset release >/dev/null
cmake --build build/release --target eyes_benchmark >&2
PERIPLUS_COMMIT=$(git rev-parse --short HEAD 2>/dev/null || echo unknown)
[ -z "$(git status --porcelain -- . ':!docs/results' 2>/dev/null)" ] || PERIPLUS_COMMIT=$PERIPLUS_COMMIT-dirty
export PERIPLUS_COMMIT
exec build/release/bin/periplus-eyes-benchmark "$@"
