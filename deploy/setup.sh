#!/usr/bin/env bash
# Installs from apt what is missing to build, test and run Periplus (deploy/packages.txt), and fetches the demo's meshes and
# textures out of Debian packages. Runs as root or with sudo, asks nothing, may be run again.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }

missing=()
while read -r package; do
  case $package in ''|\#*) continue ;; esac
  [ "$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null)" = "install ok installed" ] || missing+=("$package")
done <"$here/packages.txt"
if [ ${#missing[@]} -gt 0 ]; then
  echo "installing ${#missing[@]} packages: ${missing[*]}"
  as_root env DEBIAN_FRONTEND=noninteractive apt-get update -q >/dev/null
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" >/dev/null
fi
"$here/fetch-assets.sh"
