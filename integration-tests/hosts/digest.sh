# For the tests of this folder: the digest over grid, views and features that a run's report.json tells.
digest_of() {
  local digest
  digest=$(sed -n 's/^ *"model_digest": "\([0-9a-f]\{64\}\)".*/\1/p' "$1")
  [ ${#digest} = 64 ] || { echo "there is no model digest in $1" >&2; return 1; }
  echo "$digest"
}

# same_run FOLDER STATUS REFERENCE: exits with 1 unless the one run in FOLDER ended like the reference, with the same model.
same_run() {
  local reports=("$1"/*/report.json)
  [ -f "${reports[0]}" ] && [ ${#reports[@]} = 1 ] || { echo "FAILED: expected one run with a report in $1"; exit 1; }
  [ "$2" = "$(cat "$3/status")" ] || { echo "FAILED: exit status $2, on one host $(cat "$3/status")"; exit 1; }
  local digest
  digest=$(digest_of "${reports[0]}")
  [ "$digest" = "$(cat "$3/digest")" ] || { echo "FAILED: digest $digest, on one host $(cat "$3/digest")"; exit 1; }
  echo "same as on one host: status $2, digest $digest"
}
