#!/usr/bin/env bash
# Everything at full size, or the named checks: deploy/acceptance.sh [NAME...]. One JSON line a value
# {name, value, unit, limit, ok, baseline, commit, machine, date} on standard output and, appended, in docs/results/acceptance.jsonl.
# Exit status 0 if all are ok. Names: deploy/acceptance.sh --list. Runs and logs stay in build/acceptance/<name>.
# Needs root or sudo (packages, network namespaces, containers). What a machine cannot do (no namespaces, no docker) is said as
# "skipped"; with PERIPLUS_REQUIRE_DOCKER=1 a missing engine is a failure.
set -uo pipefail
cd "$(dirname "$0")/.."
all=(build ci visibility search nbv_benchmark carving truths eyes demo demo_fine triceratops forbidden ship statue treehouse growth determinism vendors killed blank mug fuzz readers hosts compose)
if [ "${1:-}" = --list ]; then printf '%s\n' "${all[@]}"; exit 0; fi
checks=("$@"); [ $# -gt 0 ] || checks=("${all[@]}")
for check in "${checks[@]}"; do
  [[ " ${all[*]} " == *" $check "* ]] || { echo "acceptance.sh: there is no check $check; deploy/acceptance.sh --list names them" >&2; exit 2; }
done
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n --preserve-env=PERIPLUS_REQUIRE_DOCKER,PERIPLUS_BASE "$@"; fi; }
work=$PWD/build/acceptance
bin=$PWD/build/release/bin
mkdir -p "$work" docs/results
commit=$(git rev-parse --short HEAD 2>/dev/null || echo none)
[ -z "$(git status --porcelain -- . ':!docs/results' 2>/dev/null)" ] || commit=$commit-dirty
machine="$(nproc) x $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)"
failed=0

# say NAME VALUE UNIT LIMIT OK [BASELINE]
say() {
  python3 - "$@" "${6-}" "$commit" "$machine" <<'P' | tee -a docs/results/acceptance.jsonl
import datetime, json, sys
name, value, unit, limit, ok = sys.argv[1:6]
baseline, commit, machine = sys.argv[-3:]
def number(text):
    try: return float(text)
    except ValueError: return text or None
print(json.dumps({"name": name, "value": number(value), "unit": unit, "limit": limit, "ok": ok == "true", "baseline": number(baseline),
                  "commit": commit, "machine": machine, "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")}))
P
  [ "$5" = true ] || failed=1
}
# judge NAME VALUE UNIT OPERATOR LIMIT [BASELINE]: what is no number is a failure
judge() {
  local ok
  ok=$(python3 -c "
import sys
try: v, l = float(sys.argv[1]), float(sys.argv[3]); print('true' if {'<=': v <= l, '>=': v >= l, '=': v == l}[sys.argv[2]] else 'false')
except ValueError: print('false')" "$2" "$4" "$5")
  say "$1" "${2:-missing}" "$3" "$4 $5" "$ok" "${6-}"
}
# equal NAME VALUE OTHER WHAT: both there and the same
equal() {
  if [ -n "$2" ] && [ "$2" = "$3" ]; then say "$1" equal "" "$4" true; else say "$1" "${2:+different}" "" "$4" false; fi
}
# field PYTHON-EXPRESSION over r, the report of $run; nothing if there is none
field() { python3 -c "import json, sys; r = json.load(open(sys.argv[1] + '/report.json')); print($1)" "$run" 2>/dev/null; }
# model NAME TASK [ARGUMENTS OF periplus run...]: sets run (its folder), status, seconds
model() {
  local folder=$work/$1 task=$2 start=$SECONDS
  rm -rf "$folder" && mkdir -p "$folder"
  "$bin/periplus" run "$task" --output "$folder" "${@:3}" >"$folder/terminal.txt" 2>&1
  status=$?
  seconds=$((SECONDS - start))
  run=$(ls -d "$folder"/*/ 2>/dev/null | tail -1)
}
large_run() {  # NAME LOOKS ERROR_MM: complete by its own criterion; the thesis shows such objects without numbers
  model "$1" "deploy/tasks/$1.yaml"
  judge "$1.exit_status" "$status" "" = 0
  judge "$1.looks" "$(field "r['views']")" looks '<=' "$2"
  judge "$1.coverage_reachable" "$(field "round(r['coverage_reachable'], 4)")" share '>=' 0.90
  judge "$1.reachable_share" "$(field "round(r['reachable_share'], 4)")" share '>=' 0.3
  judge "$1.surface_error_mean" "$(field "round(1000 * r['surface_error']['model_to_truth']['mean'], 2)")" mm '<=' "$3"
  judge "$1.wall_time" "$seconds" s '<=' 1200
}
full_run() {  # NAME TASK COVERAGE ERROR_MM: a run within the limits of a complete model
  model "$1" "$2"
  judge "$1.exit_status" "$status" "" = 0
  judge "$1.looks" "$(field "r['views']")" looks '<=' 12
  judge "$1.coverage_reachable" "$(field "round(r['coverage_reachable'], 4)")" share '>=' "$3" 0.98
  judge "$1.surface_error_mean" "$(field "round(1000 * r['surface_error']['model_to_truth']['mean'], 2)")" mm '<=' "$4" 2
  judge "$1.wall_time" "$seconds" s '<=' 600
}
# What two runs of one seed have in common to the last bit; nothing unless the run came to an end of its own with a model.
result() {
  [ "$status" = 0 ] || [ "$status" = 3 ] || return 0
  field "[l['pose_world_camera'] for l in r['looks']], r['model_digest'] if len(r['model_digest']) == 64 and r['views'] >= 3 else 1 / 0"
}
# benchmark_ms FILE NAME: of a Google Benchmark report in milliseconds, wall time where it works on several threads; nothing where it was skipped
benchmark_ms() {
  python3 -c '
import json, sys
for b in json.load(open(sys.argv[1]))["benchmarks"]:
    if b["name"].startswith(sys.argv[2]) and not b.get("error_occurred"): print(round(b["real_time" if b["name"].endswith("/real_time") else "cpu_time"], 4)); break' "$1" "$2" 2>/dev/null
}
# search_value SIZE METHOD KEY of search_bench's report
search_value() { python3 -c 'import json, sys; print(round(json.load(open(sys.argv[1]))["methods"][sys.argv[2]][sys.argv[3]], 4))' "$work/search_$1.json" "$2" "$3" 2>/dev/null; }
# script NAME COMMAND...: a test script; 77 means that this machine cannot, and a line "SKIPPED PART: ..." that it cannot judge a part
script() {
  local name=$1 s=0
  "${@:2}" >"$work/$name.log" 2>&1 || s=$?
  case $s in
    0) say "$name" "$(tail -1 "$work/$name.log")" "" passes true ;;
    77) say "$name" "$(grep -m1 SKIPPED "$work/$name.log")" "" passes true ;;
    *) say "$name" "exit status $s" "" passes false; tail -20 "$work/$name.log" >&2 ;;
  esac
  sed -nE 's/^SKIPPED ([a-z0-9_-]+): /\1 SKIPPED: /p' "$work/$name.log" | while read -r part why; do say "$name.$part" "$why" "" passes true; done
}

deploy/setup.sh && deploy/build.sh >"$work/build.log" 2>&1 || { tail -20 "$work/build.log" >&2; echo "acceptance.sh: the build failed" >&2; exit 1; }

for check in "${checks[@]}"; do
  case $check in
    build)  # from nothing, without a compiler cache
      rm -rf "$work/clean"
      start=$SECONDS
      if CCACHE_DISABLE=1 cmake --preset release -B "$work/clean" >"$work/clean.log" 2>&1 && CCACHE_DISABLE=1 cmake --build "$work/clean" >>"$work/clean.log" 2>&1
      then judge build.clean "$((SECONDS - start))" s '<=' 720; else say build.clean failed "" "<= 720" false; fi
      rm -rf "$work/clean" ;;
    ci)
      start=$SECONDS
      .ci/run >"$work/ci.log" 2>&1; s=$?
      judge ci.exit_status "$s" "" = 0
      judge ci.time "$((SECONDS - start))" s '<=' 2700
      grep -E "tests passed|\(Failed\)|\(Timeout\)|\(Skipped\)" "$work/ci.log" >&2 ;;
    visibility)  # one evaluation beside OctoMap's rays over the same pixels: 128 voxels each way, 0.5 m
      ninja -C build/release visibility_bench >"$work/visibility.log" 2>&1
      "$bin/visibility_bench" --benchmark_format=json >"$work/visibility.json" 2>>"$work/visibility.log" && sed '/"executable"/d; /"host_name"/d' "$work/visibility.json" >docs/results/visibility.json
      while read -r simd limit ratio; do
        value=$(benchmark_ms "$work/visibility.json" "evaluate/$simd/cells:128/cm:50")
        # Without VPOPCNTDQ the same limit holds.
        [ "$simd" = avx512 ] && with=$(benchmark_ms "$work/visibility.json" evaluate/avx512_popcnt/cells:128/cm:50) && value=${with:-$value}
        [ -n "$value" ] || { say "visibility.$simd" "no such instructions here" ms "<= $limit" true; continue; }
        rays=$(benchmark_ms "$work/visibility.json" octomap_cast_rays/cells:128/cm:50)
        judge "visibility.$simd" "$value" ms '<=' "$limit" "$rays"
        judge "visibility.$simd.times_octomap" "$(python3 -c "print(round($rays / $value))")" times '>=' "$ratio"
      done <<<$'avx512 0.35 1000\navx2 0.5 800' ;;
    search)  # recorded situations, against the best of 50,000 evaluations and a plain search
      ninja -C build/release search_bench >"$work/search.log" 2>&1
      for size in half-metre two-metres unseen; do
        (cd services/nbv_planner/bench/situations && "$bin/search_bench" $size.situations --reference $size.reference --methods plain,bobyqa,newuoa,nelder-mead,fast,thorough --seeds 3 \
          --json "$work/search_$size.json") >>"$work/search.log" 2>&1 && cp "$work/search_$size.json" docs/results/
      done
      judge search.half-metre.compared "$(search_value half-metre thorough compared)" searches = 120
      judge search.two-metres.compared "$(search_value two-metres thorough compared)" searches = 36
      judge search.unseen.compared "$(search_value unseen thorough compared)" searches = 60
      while read -r size method share wall; do
        judge "search.$size.$method.share_98" "$(search_value $size $method at_least_98_percent)" share '>=' "$share" "$(search_value $size plain at_least_98_percent)"
        [ "$wall" = - ] || judge "search.$size.$method.wall_p95" "$(search_value $size $method wall_ms_p95)" ms '<=' "$wall" "$(search_value $size plain wall_ms_p95)"
      done <<<$'half-metre fast 0.9 150\nhalf-metre thorough 0.96 250\ntwo-metres thorough 0.85 -\nunseen fast 0.9 -\nunseen thorough 0.96 -' ;;
    nbv_benchmark)  # viewpoint planners beside each other; page, JSON and CSV go to docs/results/nbv_benchmark
      rm -rf "$work/nbv_benchmark"
      start=$SECONDS
      integration-tests/nbv_benchmark/run.sh --check --output build/acceptance/nbv_benchmark >"$work/nbv_benchmark.log" 2>&1
      say nbv_benchmark.time "$((SECONDS - start))" s none true
      python3 -c '
import json, sys
for c in json.load(open(sys.argv[1]))["checks"]:
    value = "missing" if c["value"] is None else round(c["value"], 4)
    print("nbv_benchmark." + c["name"], value, c["limit"], str(c["ok"]).lower(), c["detail"] or "-", sep="\t")' \
        "$work/nbv_benchmark/benchmark.json" >"$work/nbv_benchmark.checks"
      [ -s "$work/nbv_benchmark.checks" ] || say nbv_benchmark.report missing "" "a report" false
      while IFS=$'\t' read -r name value limit ok detail; do say "$name" "$value" "" "$limit" "$ok" "$detail"; done <"$work/nbv_benchmark.checks"
      mkdir -p docs/results/nbv_benchmark && cp "$work"/nbv_benchmark/{index.html,benchmark.json,benchmark.csv} docs/results/nbv_benchmark/ ;;
    carving)  # a depth map into the grid, beside OctoMap's insertPointCloud of the same depth
      ninja -C build/release carving_bench >"$work/carving.log" 2>&1
      for part in carving=-memory carving_memory=memory; do  # each in a process of its own
        report=$work/${part%=*}.json
        "$bin/carving_bench" --benchmark_filter="${part#*=}" --benchmark_format=json >"$report" 2>>"$work/carving.log" && sed '/"executable"/d; /"host_name"/d' "$report" >"docs/results/${part%=*}.json"
      done
      while read -r cells limit; do
        for sphere in 30 45; do  # the larger one fills its box, as an object does
          octomap=$(benchmark_ms "$work/carving.json" octomap/insert_point_cloud/cells:$cells/sphere_cm:$sphere)
          value=$(benchmark_ms "$work/carving.json" depth_into_grid/cells:$cells/sphere_cm:$sphere)
          name=carving.$cells; [ $sphere = 30 ] || name=$name.filled
          judge "$name" "$value" ms '<=' "$limit" "$octomap"
          judge "$name.times_octomap" "$(python3 -c "print(round($octomap / $value))" 2>/dev/null)" times '>=' 300
        done
      done <<<$'128 5\n256 10'
      # Where OctoMap empties the same space: without its box, to which it follows no ray that goes on.
      octomap=$(benchmark_ms "$work/carving.json" octomap/whole_space/cells:128/sphere_cm:30)
      judge carving.128.times_octomap_in_whole_space "$(python3 -c "print(round($octomap / $(benchmark_ms "$work/carving.json" depth_into_grid/cells:128/sphere_cm:30)))" 2>/dev/null)" times '>=' 300
      # What a model of 512 voxels a side adds to the process, without the pictures and depth maps of its views; beside it what values for every
      # voxel would.
      memory() { python3 -c 'import json, sys; m = next(b for b in json.load(open(sys.argv[1]))["benchmarks"] if b["name"].startswith("memory/cells:512")); print(round(eval(sys.argv[2], {}, m)))' "$work/carving_memory.json" "$1" 2>/dev/null; }
      judge carving.512.memory "$(memory 'six_views_mb - views_mb')" MB '<=' 200 "$(memory every_voxel_mb)"
      judge carving.512.memory_meanwhile "$(memory 'most_mb - views_mb')" MB '<=' 250 "$(memory every_voxel_mb)"
      judge carving.512.view "$(memory '1000 * slowest_view_s')" ms '<=' 5000
      # As the model does it from its second look on; beside it all made anew.
      judge carving.labels_and_surface "$(benchmark_ms "$work/carving.json" labels_and_surface_kept/cells:128)" ms '<=' 2 "$(benchmark_ms "$work/carving.json" labels_and_surface/cells:128)" ;;
    truths)  # of carving and labels, over random scenes: exact depths, exact visibility
      ninja -C build/release object_model_test >"$work/truths.log" 2>&1
      PERIPLUS_CARVING_SCENES=200 "$bin/object_model_test" --gtest_filter='*Property.*' --gtest_output=json:"$work/truths.json" >>"$work/truths.log" 2>&1; s=$?
      judge truths.exit_status "$s" "" = 0
      truth() { python3 -c 'import json, sys; print(next(t[sys.argv[2]] for s in json.load(open(sys.argv[1]))["testsuites"] for t in s["testsuite"] if sys.argv[2] in t))' "$work/truths.json" "$1" 2>/dev/null; }
      judge truths.touched "$(truth touched)" voxels '>=' 100000
      judge truths.touched_emptied "$(truth touched_emptied)" voxels = 0
      judge truths.half_voxel_most_filled "$(truth most_filled)" share '<=' 0.5
      for margin in half_diagonal half_voxel; do
        judge "truths.$margin.share_of_naive" "$(truth ${margin}_share)" share '>=' 0.97
        judge "truths.$margin.share_of_naive_near" "$(truth ${margin}_share_near)" share '>=' 0.97
      done ;;
    eyes)  # stereo and carving against the truth; page, JSON and CSV go to docs/results/eyes_benchmark
      rm -rf "$work/eyes_benchmark"
      start=$SECONDS
      integration-tests/eyes_benchmark/run.sh --check --output build/acceptance/eyes_benchmark >"$work/eyes_benchmark.log" 2>&1
      say eyes.time "$((SECONDS - start))" s none true
      # The time of a pair too, which the benchmark itself does not judge.
      python3 -c '
import json, sys
for c in json.load(open(sys.argv[1]))["checks"]:
    value = "missing" if c["value"] is None else round(c["value"], 5)
    print("eyes." + c["name"].replace(" ", "_"), value, c["unit"] or "-", c["comparison"] + " " + str(c["limit"]), str(c["ok"]).lower(), sep="\t")' \
        "$work/eyes_benchmark/benchmark.json" >"$work/eyes_benchmark.checks"
      [ -s "$work/eyes_benchmark.checks" ] || say eyes.report missing "" "a report" false
      while IFS=$'\t' read -r name value unit limit ok; do say "$name" "$value" "${unit#-}" "$limit" "$ok"; done <"$work/eyes_benchmark.checks"
      mkdir -p docs/results/eyes_benchmark && cp "$work"/eyes_benchmark/{benchmark.json,benchmark.csv} docs/results/eyes_benchmark/
      # Six megabytes of pictures stay where they were made.
      sed '/!\[/d; /^Depth (near red/d' "$work/eyes_benchmark/index.md" | cat -s >docs/results/eyes_benchmark/index.md ;;
    demo) full_run demo deploy/tasks/bunny.yaml 0.97 3 ;;
    demo_fine) full_run demo_fine deploy/tasks/bunny-fine.yaml 0.97 2 ;;
    triceratops) full_run triceratops deploy/tasks/triceratops.yaml 0.95 5 ;;
    forbidden)
      full_run forbidden deploy/tasks/forbidden.yaml 0.95 5
      judge forbidden.forbidden_poses "$(field "len(r['forbidden_poses'])")" poses '>=' 1 ;;
    ship) large_run ship 12 5 ;;
    statue) large_run statue 15 10 ;;
    treehouse) large_run treehouse 20 15 ;;
    growth)  # begun in a box of half its height
      large_run treehouse-grow 26 15
      judge growth.box_height "$(field "round(r['object_box']['size_m'][2], 2)")" m '>=' 3 ;;
    determinism)
      model determinism_first deploy/tasks/bunny.yaml; first=$(result)
      model determinism_second deploy/tasks/bunny.yaml
      equal determinism.same_seed "$(result)" "$first" "digest and views of two runs" ;;
    vendors)
      model vendors_fastdds deploy/tasks/bunny.yaml --set dds.default=fastdds; reference=$(result)
      for pair in cyclonedds/cyclonedds fastdds/cyclonedds cyclonedds/fastdds; do
        split=${pair%/*} rest=${pair#*/} arguments=(--set "dds.default=${pair#*/}")
        for service in simulator model_server posture_generator motion_controller; do arguments+=(--set "dds.$service=$split"); done
        name=vendors_${split}_$rest
        model "$name" deploy/tasks/bunny.yaml "${arguments[@]}"
        equal "$name" "$(result)" "$reference" "digest and views as on Fast DDS alone"
        equal "$name.vendors" "$(field "r['vendors']['simulator'] + ' ' + r['vendors']['vision_server']")" "$split $rest" "as asked for"
      done ;;
    killed) script killed.services env PERIPLUS_FULL=1 ctest --preset release -R '^scenarios\.killed' --no-tests=error ;;
    blank)
      config=$work/blank_config
      rm -rf "$config" && mkdir -p "$config"
      for service in services/*/; do [ ! -f "$service/config/default.yaml" ] || cp "$service/config/default.yaml" "$config/$(basename "$service").yaml"; done
      sed -i 's#blank_right_eye: false#blank_right_eye: true#' "$config/simulator.yaml"
      PERIPLUS_CONFIG_DIR=$config model blank deploy/tasks/bunny.yaml
      judge blank.exit_status "$status" "" = 6
      reason=$(field "r['exit']['reason']")
      say blank.reason "${reason:-missing}" "" "a reason" "$([ -n "$reason" ] && echo true || echo false)" ;;
    mug)  # stereo sees a fifth of it: little coverage, and what there is must be true
      model mug deploy/tasks/mug.yaml
      v=$(field "round(r['coverage_reachable'], 4)")
      judge mug.coverage_reachable "$v" share '<=' 0.75 0.42
      judge mug.coverage_reachable_is_some "$v" share '>=' 0.1
      judge mug.surface_error_mean "$(field "round(1000 * r['surface_error']['model_to_truth']['mean'], 2)")" mm '<=' 10 ;;
    fuzz)  # libFuzzer on every reader of what comes from elsewhere; without clang-14 and the right to install it: skipped
      s=0
      integration-tests/fuzz/run.sh --seconds "${PERIPLUS_FUZZ_SECONDS:-600}" >"$work/fuzz.log" 2>"$work/fuzz.errors" || s=$?
      if [ "$s" = 77 ]; then say fuzz "$(grep -m1 SKIPPED "$work/fuzz.log")" "" "findings = 0" true; continue; fi
      [ "$s" -le 1 ] && [ -s "$work/fuzz.log" ] || say fuzz "exit status $s" "" "findings = 0" false
      cat "$work/fuzz.errors" >&2
      while IFS=$'\t' read -r target executions edges findings; do
        say "fuzz.$target" "$executions" executions "findings = 0" "$([ "$findings" = 0 ] && [ "$executions" -gt 0 ] && echo true || echo false)"
      done <"$work/fuzz.log" ;;
    readers)  # every export, and the topics for ROS 2 tools, read by programs that others wrote
      ninja -C build/release write_models >"$work/readers.build.log" 2>&1
      script readers python3 integration-tests/public_readers/read_models.py "$bin/write_models" "$work/readers" "$bin" ;;
    hosts)
      for check_of in "one_host reference.sh" "two_hosts two_hosts_test.sh" "two_hosts_mixed two_hosts_test.sh cyclonedds fastdds"; do
        # shellcheck disable=SC2086
        set -- $check_of
        if [ "$1" = one_host ]; then script hosts.one_host "integration-tests/hosts/$2" "$bin" deploy/tasks/bunny.yaml "$work/one_host"
        else script "hosts.$1" as_root "integration-tests/hosts/$2" "$bin" deploy/tasks/bunny.yaml "$work/one_host" "$work/$1" "${@:3}"; fi
      done ;;
    compose)
      [ -f "$work/one_host/digest" ] || script hosts.one_host integration-tests/hosts/reference.sh "$bin" deploy/tasks/bunny.yaml "$work/one_host"
      start=$SECONDS
      script compose.same_digest as_root integration-tests/hosts/compose_test.sh "$PWD/build/release" bunny "$work/one_host" "$work/compose"
      judge compose.time "$((SECONDS - start))" s '<=' 600 ;;
  esac
done
exit $failed
