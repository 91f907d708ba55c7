#!/usr/bin/env bash
# Makes the image debian:bookworm with mmdebstrap, from Debian's own packages, for machines that can pull no image. Does nothing
# if the image is there. Runs as root or with sudo; installs mmdebstrap if it is missing.
set -euo pipefail
image=debian:bookworm
docker image inspect "$image" >/dev/null 2>&1 && { echo "$image is there"; exit 0; }
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }
if ! command -v mmdebstrap >/dev/null; then
  as_root env DEBIAN_FRONTEND=noninteractive apt-get update -q >/dev/null
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends mmdebstrap >/dev/null
fi
folder=$(mktemp -d)
trap 'as_root rm -rf "$folder"' EXIT
as_root mmdebstrap --quiet --variant=minbase --include=ca-certificates bookworm "$folder/base.tar"
as_root chmod a+r "$folder/base.tar"
docker import "$folder/base.tar" "$image" >/dev/null
echo "$image made"
