#!/usr/bin/env bash
# Makes the pictures of docs/next-best-view.md: the statue of two metres perceived twice by the simulated robot, then
# `periplus nbv` on its model, with its terms mapped as in the thesis' Fig. 3.4. Installs and builds what is missing.
# deploy/nbv-pictures.sh [MODEL]: of a model.periplus that is there already, in the statue's scene.
set -euo pipefail
cd "$(dirname "$0")/.."
bin=build/release/bin
model=${1:-}
if [ -z "$model" ]; then
  deploy/setup.sh
  deploy/build.sh
  out=$(mktemp -d)
  trap 'rm -rf "$out"' EXIT
  status=0
  $bin/periplus run deploy/tasks/statue.yaml --set stop.most_looks=2 --output "$out" || status=$?
  [ "$status" = 3 ] || { echo "the run of two looks ended with status $status; 3 (looks spent) was expected" >&2; exit 1; }
  model=$(ls "$out"/*/model.periplus)
fi
plan=("$bin/periplus" nbv "$model" deploy/cameras/hrp2like-pair.yaml --scene deploy/scenes/statue.yaml)
"${plan[@]}" --picture docs/img/nbv-view.png
# The first answer forbidden, so that K_forbidden has something to show.
answer=$("${plan[@]}" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["view"]["text"])')
"${plan[@]}" --forbid "$answer" --map all docs/img/nbv-maps.png --map-height 1.3 --map-half-width 3.3 --map-step 0.04
