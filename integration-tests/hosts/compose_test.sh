#!/usr/bin/env bash
# The loop in containers, with two planners, builds the same model:   compose_test.sh BUILD TASK_NAME REFERENCE OUTPUT
# Makes the packages of the build folder and an image of them. Exit status 77: no docker here, which is a failure with
# PERIPLUS_REQUIRE_DOCKER=1. PERIPLUS_BASE names another base image.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
source "$root/integration-tests/hosts/digest.sh"
build=$1 reference=$3 output=$4

missing() {
  if [ "${PERIPLUS_REQUIRE_DOCKER:-0}" = 1 ]; then echo "FAILED: $1"; exit 1; fi
  echo "SKIPPED: $1"
  exit 77
}
if command -v docker-compose >/dev/null; then compose=(docker-compose); else compose=(docker compose); fi
docker info >/dev/null 2>&1 || missing "no docker engine answers; install docker.io"
"${compose[@]}" version >/dev/null 2>&1 || missing "there is no docker-compose"

export PERIPLUS_TASK=$2 PERIPLUS_RUNS=$output PERIPLUS_IMAGE=periplus-test COMPOSE_PROJECT_NAME=periplus-test-$$
cd "$root"
clean_up() { "${compose[@]}" down --volumes --timeout 5 >/dev/null 2>&1 || true; }
trap clean_up EXIT
rm -rf "$output"

deploy/package.sh "$build" >/dev/null
[ -n "${PERIPLUS_BASE:-}" ] || deploy/docker/base-image.sh
"${compose[@]}" build run >"$build/compose-build.log" 2>&1 || { tail -n 30 "$build/compose-build.log"; echo "FAILED: the image was not built"; exit 1; }

"${compose[@]}" run --rm periplus version || { echo "FAILED: the client does not run in its container"; exit 1; }
status=0
"${compose[@]}" up --no-color --scale nbv-planner=2 --exit-code-from run >"$build/compose-up.log" 2>&1 || status=$?
grep -E '^run_1|-run-1' "$build/compose-up.log" || tail -n 30 "$build/compose-up.log"
same_run "$output" "$status" "$reference"

run=("$output"/*/)
grep -q '"coverage_reachable"' "${run[0]}/report.json" || { echo "FAILED: the run was not evaluated in its container"; exit 1; }
[ "$(ls "${run[0]}/logs" | wc -l)" -ge 8 ] || { echo "FAILED: the run's folder lacks logs of services"; exit 1; }
grep -q '"tasks_elsewhere":"[1-9]' "${run[0]}"/logs/nbv_planner.jsonl || { echo "FAILED: the two planners shared no request"; exit 1; }
[ -s "${run[0]}/report.html" ] || { echo "FAILED: there is no report.html"; exit 1; }
owner=$(stat -c %u:%g "$root")
strangers=$(find "$output" -printf '%U:%G %p\n' | grep -v "^$owner " || true)
[ -z "$strangers" ] || { echo "FAILED: not owned by the project's owner $owner: $strangers"; exit 1; }
