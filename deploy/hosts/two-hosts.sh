#!/usr/bin/env bash
# Runs a task on two hosts that know no multicast, both on this computer:
#   deploy/hosts/two-hosts.sh [TASK] [OUTPUT]        default: deploy/tasks/bunny-short.yaml, runs
# The robot carries simulator, motion and vision; the other host has model, planners, supervisor and the client. Each is a
# namespace of its own for network, processes, shared memory and host name; between them stands a router that forwards
# unicast only. Needs root and the programs of PERIPLUS_BIN (default build/release/bin). PERIPLUS_ONBOARD_DDS and
# PERIPLUS_EXTERNAL_DDS choose the vendor of each host (fastdds). Exit status: that of `periplus run`.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=${PERIPLUS_BIN:-$root/build/release/bin}
task=$(realpath "${1:-$root/deploy/tasks/bunny-short.yaml}")
output=$(realpath -m "${2:-$root/runs}")
onboard="simulator motion-controller vision-server"
external="model-server nbv-planner posture-generator walk-planner supervisor"

say() { echo "two-hosts: $*" >&2; }
[ "$(id -u)" = 0 ] || { say "network namespaces need root; run it with sudo"; exit 2; }
[ -r "$task" ] || { say "there is no task $task; give one such as deploy/tasks/bunny-short.yaml"; exit 2; }
[ -x "$bin/periplus" ] || { say "there is no $bin/periplus; build first (deploy/build.sh) or set PERIPLUS_BIN"; exit 2; }

value() { sed -n "s/^$1:[[:space:]]*\([^#[:space:]]*\).*/\1/p" "$task"; }
file() { # of the task: beside it or above, like `periplus run`
  local folder
  folder=$(dirname "$task")
  while [ ! -r "$folder/$1" ] && [ "$folder" != / ]; do folder=$(dirname "$folder"); done
  echo "$folder/$1"
}
scene=$(file "$(value scene)")
robot=$(file "$(value robot)")
truth=--truth
[ "$(value truth)" != false ] || truth=

name=periplus-$$
temporary=$(mktemp -d)
clean_up() {
  exec 7>&- # the robot's host ends its programs when this closes
  [ -z "${robot_host:-}" ] || wait "$robot_host" 2>/dev/null || true
  for host in robot external router; do ip netns delete "$name-$host" 2>/dev/null || true; done
  rm -rf "$temporary"
}
trap clean_up EXIT
for left in $(ip netns list | awk '/^periplus-[0-9]+-/ {print $1}'); do # of runs that were killed
  pid=${left#periplus-}
  [ -d "/proc/${pid%%-*}" ] || ip netns delete "$left" || true
done

ip netns add "$name-router" 2>/dev/null || { say "this kernel or container has no network namespaces"; exit 77; }
ip -n "$name-router" link set lo up
ip netns exec "$name-router" sysctl -qw net.ipv4.ip_forward=1
number=1
for host in robot external; do
  ip netns add "$name-$host"
  ip link add eth0 netns "$name-$host" type veth peer name "$host" netns "$name-router"
  ip -n "$name-$host" address add "10.77.$number.2/24" dev eth0
  ip -n "$name-router" address add "10.77.$number.1/24" dev "$host"
  ip -n "$name-router" link set "$host" up
  ip -n "$name-$host" link set lo up
  ip -n "$name-$host" link set eth0 up
  ip -n "$name-$host" route add default via "10.77.$number.1"
  number=$((number + 1))
done

mkdir -p "$output"
logs=$output/two-hosts-logs
rm -rf "$logs" && mkdir -p "$logs"

# on_host NAME PEER VENDOR COMMAND: bash in namespaces of that host's own.
on_host() {
  ip netns exec "$name-$1" unshare --uts --ipc --pid --fork --kill-child --mount-proc \
    env PERIPLUS_INTERFACE=eth0 PERIPLUS_PEERS="$2" PERIPLUS_DDS="$3" OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 LP_NUM_THREADS=1 \
    XDG_STATE_HOME="$temporary" XDG_RUNTIME_DIR="$temporary" \
    bash -c "hostname $1 && mount -t tmpfs -o size=512m tmpfs /dev/shm && $4"
}
start() { # program and its arguments
  printf '"%s" --log-file "%s" %s >"%s" 2>&1 </dev/null & ' "$bin/periplus-$1" "$logs/${1//-/_}.jsonl" "${*:2}" "$logs/$1.out"
}
# The first program of a pid namespace gets no signal that it does not handle; its children are ended by name of job.
end_all='kill $(jobs -p) 2>/dev/null; wait'

mkfifo "$temporary/robot"
exec 7<>"$temporary/robot"
commands=
for program in $onboard; do
  arguments=
  [ "$program" != simulator ] || arguments="--scene '$scene' --robot '$robot' $truth"
  commands+=$(start "$program" "$arguments")
done
on_host robot 10.77.2.2 "${PERIPLUS_ONBOARD_DDS:-fastdds}" "{ $commands read -r nothing; $end_all; }" <"$temporary/robot" 7>&- &
robot_host=$!

commands=
for program in $external; do
  arguments=
  [ "$program" != supervisor ] || arguments="--set 'log_folder=$logs'"
  commands+=$(start "$program" "$arguments")
done
status=0
on_host external 10.77.1.2 "${PERIPLUS_EXTERNAL_DDS:-fastdds}" \
  "{ $commands '$bin/periplus' run --attach '$task' -o '$output' 7>&-; status=\$?; $end_all; exit \$status; }" 7>&- || status=$?
exit $status
