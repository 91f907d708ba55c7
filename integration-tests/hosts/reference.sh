#!/usr/bin/env bash
# One host, for the others to be compared with:   reference.sh BIN TASK FOLDER
# Leaves the digest of the model in FOLDER/digest and the exit status in FOLDER/status.
set -euo pipefail
source "$(dirname "$0")/digest.sh"
bin=$1 task=$2 folder=$3
rm -rf "$folder" && mkdir -p "$folder"
status=0
"$bin/periplus" run "$task" -o "$folder/runs" || status=$?
[ $status = 0 ] || [ $status = 3 ] || { echo "the run on one host ended with status $status"; exit 1; }
echo $status >"$folder/status"
digest_of "$folder"/runs/*/report.json >"$folder/digest"
echo "one host: status $status, digest $(cat "$folder/digest")"
