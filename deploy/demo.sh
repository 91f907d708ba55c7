#!/usr/bin/env bash
# The demo: installs what is missing, builds, and has the simulated robot model the Stanford bunny. The result stands in runs/.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
"$here/setup.sh"
"$here/build.sh"
cd "$here/.."
exec build/release/bin/periplus run "${1:-deploy/tasks/bunny.yaml}"
