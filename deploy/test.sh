#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests of every change: units, four pairs of DDS vendors, failure paths, short
# loops on each vendor configuration, the forbidden scene, two killed services. With PERIPLUS_FULL=1 those with the label
# `acceptance` too: the other services killed, two hosts, containers. Arguments go to ctest.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
"$here/setup.sh"
"$here/fetch-assets.sh" --calibration
"$here/build.sh"
cd "$here/.."
left_out=(-LE acceptance)
[ "${PERIPLUS_FULL:-0}" = 1 ] && left_out=()
exec ctest --preset release --timeout 900 "${left_out[@]}" "$@"
