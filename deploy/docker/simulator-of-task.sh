#!/bin/sh
# Starts the simulator with the robot and the scene of a task:   simulator-of-task.sh TASK
set -e
share=/usr/share/periplus
task=$share/tasks/$1.yaml
[ -r "$task" ] || { echo "there is no task $1; there are: $(cd $share/tasks && ls | sed 's/\.yaml$//' | tr '\n' ' ')" >&2; exit 2; }
value() { sed -n "s/^$1:[[:space:]]*\([^#[:space:]]*\).*/\1/p" "$task"; }
truth=--truth
[ "$(value truth)" != false ] || truth=
# shellcheck disable=SC2086  # no argument where there is none
exec periplus-simulator --log-file runs/.logs/simulator.jsonl --scene "$share/$(value scene)" --robot "$share/$(value robot)" $truth
