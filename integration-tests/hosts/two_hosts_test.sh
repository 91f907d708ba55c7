#!/usr/bin/env bash
# The loop over two hosts without multicast builds the same model:   two_hosts_test.sh BIN TASK REFERENCE OUTPUT [ONBOARD EXTERNAL]
# ONBOARD and EXTERNAL: DDS vendor of the robot and of the other host. Exit status 77: cannot be tested here.
set -euo pipefail
folder=$(cd "$(dirname "$0")" && pwd)
source "$folder/digest.sh"
bin=$1 task=$2 reference=$3 output=$4
[ "$(id -u)" = 0 ] || { echo "SKIPPED: network namespaces need root"; exit 77; }
command -v ip >/dev/null && command -v unshare >/dev/null || { echo "SKIPPED: needs ip (iproute2) and unshare (util-linux)"; exit 77; }
rm -rf "$output"
status=0
PERIPLUS_BIN=$bin PERIPLUS_ONBOARD_DDS=${5:-fastdds} PERIPLUS_EXTERNAL_DDS=${6:-fastdds} \
  "$folder/../../deploy/hosts/two-hosts.sh" "$task" "$output" || status=$?
[ $status != 77 ] || { echo "SKIPPED: no network namespaces here"; exit 77; }
same_run "$output" "$status" "$reference"
# It was the other host's interface that they met on.
grep -q '"instance":"vision-server-robot-' "$output"/two-hosts-logs/vision_server.jsonl || { echo "FAILED: vision did not run on the robot"; exit 1; }
grep -q '"instance":"nbv-planner-external-' "$output"/two-hosts-logs/nbv_planner.jsonl || { echo "FAILED: the planner did not run on the other host"; exit 1; }
[ "$(ls "$output"/*/logs | wc -l)" -ge 8 ] || { echo "FAILED: the run's folder lacks logs of services"; exit 1; }
for left in $(ip netns list | awk '/^periplus-[0-9]+-/ {print $1}'); do
  pid=${left#periplus-}
  [ -d "/proc/${pid%%-*}" ] || { echo "FAILED: the namespace $left is left behind"; exit 1; }
done
