#!/usr/bin/env bash
# Makes the pictures of README and docs from a real run: models the bunny, then writes docs/img (what the robot saw, the model
# from all sides, the state machine and, where chromium is installed, the report's page).
set -euo pipefail
cd "$(dirname "$0")/.."
bin=build/release/bin
[ -x $bin/periplus ] || deploy/build.sh
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
$bin/periplus run deploy/tasks/bunny.yaml --output "$out"
run=$(ls -d "$out"/*/ | tail -1)
$bin/periplus-report "${run%/}" --pictures docs/img >/dev/null
$bin/periplus states | dot -Tsvg >docs/img/states.svg
if command -v chromium >/dev/null; then
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1100,3400 --screenshot=docs/img/report.png "file://${run%/}/report.html" 2>/dev/null
fi
ls docs/img
