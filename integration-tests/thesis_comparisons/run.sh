#!/usr/bin/env bash
# The thesis' comparisons, from nothing: fetches the objects, builds, runs, and puts the page into docs/ (some minutes).
# Arguments as of periplus-thesis-comparisons.
set -euo pipefail
cd "$(dirname "$0")/../.."
deploy/setup.sh >&2
deploy/fetch-assets.sh --benchmark >&2
[ -f build/release/build.ninja ] || cmake --preset release >/dev/null
cmake --build build/release --target thesis_comparisons >&2
PERIPLUS_COMMIT=$(git rev-parse --short HEAD 2>/dev/null || echo unknown)
[ -z "$(git status --porcelain -- . ':!docs' 2>/dev/null)" ] || PERIPLUS_COMMIT=$PERIPLUS_COMMIT-dirty
export PERIPLUS_COMMIT
exec build/release/bin/periplus-thesis-comparisons --output docs "$@"
