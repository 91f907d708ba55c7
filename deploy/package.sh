#!/usr/bin/env bash
# Makes one Debian package per service in build/packages.   deploy/package.sh [BUILD_FOLDER]
# Without a folder it builds first, into build/release.
set -euo pipefail
cd "$(dirname "$0")/.."
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }
if ! { command -v dpkg-shlibdeps && command -v file; } >/dev/null; then
  as_root env DEBIAN_FRONTEND=noninteractive apt-get update -q >/dev/null
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends dpkg-dev file >/dev/null
fi
folder=${1:-build/release}
# cpack itself would only build after it has read what to pack
if [ $# -gt 0 ]; then cmake --build "$folder" >/dev/null; else deploy/build.sh; fi
packages=$PWD/build/packages
rm -rf "$packages"
mkdir -p "$packages"
log=$packages/cpack.log
(cd "$folder" && cpack -G DEB -B "$packages") >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
rm -rf "$packages/_CPack_Packages" "$log"
ls "$packages"
