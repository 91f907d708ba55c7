#!/bin/sh
# Runs a program as whoever owns the project folder (/host), so that ./runs belongs to its caller and no service runs as root
# without need.
set -e
owner=0:0
[ ! -d /host ] || owner=$(stat -c %u:%g /host)
mkdir -p /project/runs /var/lib/periplus
[ "$(stat -c %u:%g /project/runs)" = "$owner" ] || chown "$owner" /project/runs
chown -R "$owner" /var/lib/periplus
export HOME=/var/lib/periplus
exec setpriv --reuid "${owner%:*}" --regid "${owner#*:}" --clear-groups -- "$@"
