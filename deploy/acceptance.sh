#!/usr/bin/env bash
# Everything at full size, or the named checks: deploy/acceptance.sh [NAME...]. One JSON line a check
# {name, value, unit, limit, ok, baseline, commit, machine, date} on standard output and, appended, in docs/results/acceptance.jsonl.
# Exit status 0 if all are ok. Names: see `deploy/acceptance.sh --list`.
set -uo pipefail
cd "$(dirname "$0")/.."
all=(build tests demo triceratops forbidden determinism vendors honest_blank honest_mug hosts compose)
if [ "${1:-}" = --list ]; then printf '%s\n' "${all[@]}"; exit 0; fi
checks=("$@"); [ $# -gt 0 ] || checks=("${all[@]}")
for check in "${checks[@]}"; do
  [[ " ${all[*]} " == *" $check "* ]] || { echo "acceptance.sh: there is no check $check; deploy/acceptance.sh --list names them" >&2; exit 2; }
done
deploy/setup.sh || exit 1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
bin=build/release/bin
failed=0
commit=$(git rev-parse --short HEAD 2>/dev/null || echo none)
machine="$(nproc) x $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)"

# say NAME VALUE UNIT LIMIT OK [BASELINE]
say() {
  local line
  line=$(python3 - "$@" "$commit" "$machine" <<'P'
import datetime, json, sys
name, value, unit, limit, ok, baseline, commit, machine = sys.argv[1:9]
number = lambda t: float(t) if t.replace('.', '', 1).replace('-', '', 1).isdigit() else (t or None)
print(json.dumps({"name": name, "value": number(value), "unit": unit, "limit": limit, "ok": ok == "true", "baseline": number(baseline),
                  "commit": commit, "machine": machine, "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")}))
P
  )
  echo "$line" | tee -a docs/results/acceptance.jsonl
  [ "$5" = true ] || failed=1
}
# compare VALUE OP LIMIT: true or false
compare() { python3 -c "import sys; v, o, l = float(sys.argv[1]), sys.argv[2], float(sys.argv[3]); print('true' if (v >= l if o == '>=' else v <= l) else 'false')" "$@"; }
# field RUN PYTHON-EXPRESSION over r, the run's report
field() { python3 -c "import json, sys; r = json.load(open(sys.argv[1] + '/report.json')); print($2)" "$1"; }
# model NAME TASK [SED-EXPRESSION]: runs it in a folder of its own; sets run, status, seconds
model() {
  local task=$2
  if [ -n "${3:-}" ]; then
    task=$work/$1.yaml
    sed -e "s#^robot: #robot: $PWD/#; s#^scene: #scene: $PWD/#" -e "$3" "$2" >"$task"
  fi
  local start=$SECONDS
  "$bin/periplus" run "$task" --output "$work/$1" >"$work/$1.log" 2>&1
  status=$?
  seconds=$((SECONDS - start))
  run=$(ls -d "$work/$1"/*/ 2>/dev/null | tail -1)
}
judge_model() {  # NAME: the common limits of a full run
  say "$1.exit_status" "$status" "" "0" "$([ "$status" = 0 ] && echo true || echo false)" ""
  [ -n "$run" ] && [ -f "$run/report.json" ] || { say "$1.report" missing "" "" false ""; tail -5 "$work/$1.log" >&2; return; }
  local v
  v=$(field "$run" "r['views']"); say "$1.looks" "$v" looks "<= 12" "$(compare "$v" '<=' 12)" ""
  v=$(field "$run" "round(r.get('coverage_reachable', 0), 4)"); say "$1.coverage_reachable" "$v" share ">= 0.95" "$(compare "$v" '>=' 0.95)" 0.98
  v=$(field "$run" "round(1000 * r.get('surface_error', {'model_to_truth': {'mean': 1}})['model_to_truth']['mean'], 2)")
  say "$1.surface_error_mean" "$v" mm "<= 5" "$(compare "$v" '<=' 5)" 2
  say "$1.wall_time" "$seconds" s "<= 600" "$(compare "$seconds" '<=' 600)" ""
}
views='[(l["look"], l["pose_world_camera"]) for l in r["looks"]], r["model_digest"]'

for check in "${checks[@]}"; do
  case $check in
    build)
      rm -rf build/clean
      start=$SECONDS
      CCACHE_DISABLE=1 cmake --preset release -B build/clean >/dev/null && CCACHE_DISABLE=1 cmake --build build/clean >"$work/build.log" 2>&1 && built=true || built=false
      say build.clean "$((SECONDS - start))" s "<= 300" "$([ $built = true ] && compare $((SECONDS - start)) '<=' 300 || echo false)" ""
      rm -rf build/clean ;;
    tests)
      deploy/build.sh >"$work/build.log" 2>&1
      start=$SECONDS
      PERIPLUS_FULL=1 ctest --preset release --timeout 900 >"$work/tests.log" 2>&1 && ok=true || ok=false
      grep -E "tests passed|Failed|Not Run" "$work/tests.log" >&2
      say tests "$((SECONDS - start))" s "all pass" $ok "" ;;
    *) [ -x $bin/periplus ] || deploy/build.sh >"$work/build.log" 2>&1 ;;&
    demo) model demo deploy/tasks/bunny.yaml; judge_model demo ;;
    triceratops) model triceratops deploy/tasks/triceratops.yaml; judge_model triceratops ;;
    forbidden)
      model forbidden deploy/tasks/forbidden.yaml; judge_model forbidden
      v=$(field "$run" "len(r['forbidden_poses'])"); say forbidden.forbidden_poses "$v" poses ">= 1" "$(compare "$v" '>=' 1)" "" ;;
    determinism)
      model first deploy/tasks/bunny-short.yaml; first=$(field "$run" "$views")
      model second deploy/tasks/bunny-short.yaml; second=$(field "$run" "$views")
      say determinism.same_seed "$([ "$first" = "$second" ] && echo equal || echo different)" "" equal "$([ "$first" = "$second" ] && echo true || echo false)" "" ;;
    vendors)
      onboard="  simulator: A\n  model_server: A\n  posture_generator: A\n  motion_controller: A\n"
      model fast deploy/tasks/bunny-short.yaml; reference=$(field "$run" "$views")
      for split in cyclonedds "split fastdds cyclonedds" "split cyclonedds fastdds"; do
        # shellcheck disable=SC2086
        set -- $split
        if [ $# = 1 ]; then edit="s#default: fastdds#default: cyclonedds#"; else edit="s#^  default: fastdds#  default: $3\n${onboard//A/$2}#"; fi
        name=$(echo "$split" | tr ' ' _)
        model "vendor_$name" deploy/tasks/bunny-short.yaml "$edit"
        this=$(field "$run" "$views")
        say "vendors.$name" "$([ "$this" = "$reference" ] && echo equal || echo different)" "" "equal to fastdds" "$([ "$this" = "$reference" ] && echo true || echo false)" ""
      done ;;
    honest_blank)
      mkdir -p "$work/config"
      for service in services/*/; do cp "$service/config/default.yaml" "$work/config/$(basename "$service").yaml" 2>/dev/null; done
      sed -i 's#blank_right_eye: false#blank_right_eye: true#' "$work/config/simulator.yaml"
      PERIPLUS_CONFIG_DIR=$work/config model blank deploy/tasks/bunny-short.yaml
      say honest.blanked_right_eye "$status" "exit status" 6 "$([ "$status" = 6 ] && echo true || echo false)" "" ;;
    honest_mug)
      model mug deploy/tasks/mug.yaml
      v=$(field "$run" "round(r.get('coverage_reachable', 0), 4)")
      say honest.mug_coverage "$v" share "<= 0.75" "$(compare "$v" '<=' 0.75)" 0.42 ;;
    hosts)
      deploy/hosts/two-hosts.sh >"$work/hosts.log" 2>&1; s=$?
      say hosts.same_digest "$s" "exit status" 0 "$([ $s = 0 ] && echo true || echo false)" "" ;;
    compose)
      if ! docker info >/dev/null 2>&1; then
        say compose.exit_status skipped "" "0" "$([ "${PERIPLUS_REQUIRE_DOCKER:-0}" = 1 ] && echo false || echo true)" ""
      else
        deploy/docker/base-image.sh >&2
        deploy/package.sh >"$work/package.log" 2>&1
        docker-compose build >"$work/compose-build.log" 2>&1
        PERIPLUS_TASK=bunny-short docker-compose up --exit-code-from run >"$work/compose.log" 2>&1; s=$?
        docker-compose down -v >/dev/null 2>&1
        say compose.exit_status "$s" "" "0 or 3" "$([ $s = 0 ] || [ $s = 3 ] && echo true || echo false)" ""
      fi ;;
  esac
done
exit $failed
