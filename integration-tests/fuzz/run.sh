#!/usr/bin/env bash
# integration-tests/fuzz/run.sh [--seconds N] [TARGET...]: builds the fuzzers by clang into build/fuzz and runs each for N seconds (60), from its
# committed corpus and what earlier runs found (build/fuzz/found/TARGET). A line a target: name, executions, edges covered, findings,
# by tabs. Exit status 1 after a finding (its input and log in build/fuzz/runs/TARGET), 77 without clang-14, nor root or sudo to install it.
set -euo pipefail
cd "$(dirname "$0")/../.."
all=(model_file model_import calibration_file task_yaml scene_yaml image_message object_message robot_yaml urdf)
seconds=60 targets=()
while [ $# -gt 0 ]; do
  case $1 in
    --seconds) seconds=${2:?run.sh: --seconds needs a number}; shift ;;
    *) [[ " ${all[*]} " == *" $1 "* ]] || { echo "run.sh: there is no target $1; there are: ${all[*]}" >&2; exit 2; }; targets+=("$1") ;;
  esac
  shift
done
[ ${#targets[@]} -gt 0 ] || targets=("${all[@]}")

has_clang() { [ -x /usr/bin/clang++-14 ] && compgen -G '/usr/lib/llvm-14/lib/clang/*/lib/linux/libclang_rt.fuzzer-*.a' >/dev/null; }
if ! has_clang; then
  as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }
  { as_root apt-get update -q && as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends clang-14 libclang-rt-14-dev; } >/dev/null 2>&1 || true
  has_clang || { echo "SKIPPED: the fuzzers need clang-14 and libclang-rt-14-dev (apt-get install clang-14 libclang-rt-14-dev)"; exit 77; }
fi
[ -f build/fuzz/build.ninja ] || cmake --preset fuzz >/dev/null
ninja -C build/fuzz "${targets[@]/#/fuzz_}" >build/fuzz/build.log 2>&1 || { tail -20 build/fuzz/build.log >&2; echo "run.sh: the fuzzers could not be built" >&2; exit 2; }

# What Debian's own libraries were built without, they cannot be held to: sized deletion across their border.
export ASAN_OPTIONS=new_delete_type_mismatch=0:detect_leaks=1:quarantine_size_mb=32 UBSAN_OPTIONS=print_stacktrace=1
status=0
for target in "${targets[@]}"; do
  run=$PWD/build/fuzz/runs/$target found=$PWD/build/fuzz/found/$target options=()
  rm -rf "$run" && mkdir -p "$run" "$found"
  [ ! -f "integration-tests/fuzz/dictionaries/$target" ] || options+=("-dict=integration-tests/fuzz/dictionaries/$target")
  build/fuzz/bin/fuzz_"$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=65536 -seed=1 -print_final_stats=1 "${options[@]}" \
    -artifact_prefix="$run/" "$found" "integration-tests/fuzz/corpora/$target" >"$run/log" 2>&1 && ended=0 || ended=$?
  findings=$(find "$run" -type f ! -name log ! -name 'slow-unit-*' | wc -l)
  [ "$ended" = 0 ] || [ "$findings" -gt 0 ] || findings=1  # an end that left no input
  executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$run/log")
  edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$run/log" | tail -1)
  printf '%s\t%s\t%s\t%s\n' "$target" "${executions:-0}" "${edges:-0}" "$findings"
  if [ "$findings" != 0 ]; then
    status=1
    grep -m5 -E 'finding:|ERROR:|runtime error:|SUMMARY:|terminate called|what\(\)' "$run/log" >&2 || tail -5 "$run/log" >&2
    echo "run.sh: $target: see $run" >&2
  fi
done
exit $status
