#!/bin/sh
# Runs a program as whoever owns the project folder (/host), so that ./runs belongs to its caller and no service runs as root
# without need.
set -e
owner=0:0
[ ! -d /host ] || owner=$(stat -c %u:%g /host)
mkdir -p /project/runs/.logs /var/lib/periplus
for folder in /project/runs /project/runs/.logs; do
  [ "$(stat -c %u:%g $folder)" = "$owner" ] || chown "$owner" $folder
done
chown -R "$owner" /var/lib/periplus
export HOME=/var/lib/periplus
exec setpriv --reuid "${owner%:*}" --regid "${owner#*:}" --clear-groups -- "$@"
