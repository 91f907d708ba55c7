#!/usr/bin/env bash
# Makes the pictures of README and docs from real runs: deploy/pictures.sh [TASK...], by default bunny ship statue treehouse.
# Of the bunny: what the robot saw, the model from all sides, the state machine, the report's page. Of the others (any task of
# deploy/tasks will do): the robot in all its postures, what is still unknown, the model after each look; for a run of your own,
#   build/release/bin/periplus report RUN_FOLDER --figures FOLDER
# Installs what is missing, chromium too.
set -euo pipefail
cd "$(dirname "$0")/.."
bin=build/release/bin
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }
tasks=("$@")
[ $# -gt 0 ] || tasks=(bunny ship statue treehouse)
deploy/setup.sh
deploy/build.sh
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for task in "${tasks[@]}"; do
  $bin/periplus run "deploy/tasks/$task.yaml" --output "$out/$task"
  run=$(ls -d "$out/$task"/*/ | tail -1)
  if [ "$task" != bunny ]; then
    $bin/periplus-report "${run%/}" --figures docs/img >/dev/null
    continue
  fi
  command -v chromium >/dev/null || as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends chromium >/dev/null
  $bin/periplus-report "${run%/}" --pictures docs/img >/dev/null
  $bin/periplus states | dot -Tsvg >docs/img/states.svg
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1100,3400 --screenshot=docs/img/report.png "file://${run%/}/report.html" 2>/dev/null
done
ls docs/img
