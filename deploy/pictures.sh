#!/usr/bin/env bash
# Makes the pictures of README and docs from a real run: models the bunny, then writes docs/img (what the robot saw, the model
# from all sides, the state machine, the report's page). Installs what is missing, chromium too.
set -euo pipefail
cd "$(dirname "$0")/.."
bin=build/release/bin
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }
deploy/setup.sh
command -v chromium >/dev/null || as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends chromium >/dev/null
deploy/build.sh
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
$bin/periplus run deploy/tasks/bunny.yaml --output "$out"
run=$(ls -d "$out"/*/ | tail -1)
$bin/periplus-report "${run%/}" --pictures docs/img >/dev/null
$bin/periplus states | dot -Tsvg >docs/img/states.svg
chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1100,3400 --screenshot=docs/img/report.png "file://${run%/}/report.html" 2>/dev/null
ls docs/img
