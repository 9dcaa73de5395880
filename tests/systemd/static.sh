#!/bin/bash
# Checks the unit file: systemd-analyze verify must print nothing, and the exposure must be at most 1.5 (of 10).
# Exit code 77 when there is no systemd-analyze.
set -euo pipefail
command -v systemd-analyze >/dev/null || { echo "skipped: needs systemd-analyze"; exit 77; }
unit=$(dirname "$0")/../../systemd/nestd.service
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# The unit's own binary need not be installed here.
sed 's|^ExecStart=/usr/bin/nestd|ExecStart=/bin/true|' "$unit" > "$work/nestd.service"
# systemd-analyze exits with 0 on unknown directives, but prints a warning.
said=$(systemd-analyze verify --man=no "$work/nestd.service" 2>&1) || { echo "$said"; exit 1; }
[ -z "$said" ] || { echo "$said"; exit 1; }
# The same with each drop-in.
for dropin in "$(dirname "$unit")"/*.conf; do
    mkdir "$work/nestd.service.d"
    cp "$dropin" "$work/nestd.service.d/"
    said=$(systemd-analyze verify --man=no "$work/nestd.service" 2>&1) || { echo "$dropin: $said"; exit 1; }
    [ -z "$said" ] || { echo "$dropin: $said"; exit 1; }
    rm -r "$work/nestd.service.d"
done
# The same with the dashboard's socket.
cp "$(dirname "$unit")/nestd-web.socket" "$work/"
said=$(systemd-analyze verify --man=no "$work/nestd-web.socket" "$work/nestd.service" 2>&1) || { echo "$said"; exit 1; }
[ -z "$said" ] || { echo "$said"; exit 1; }
systemd-analyze security --offline=true --threshold=15 "$work/nestd.service" | tail -1

# Each directive of [Service] has its reason above it: a comment, or another directive of the same group.
awk '/^\[/ {group = 0} /^#/ {group = 1} /^$/ {group = 0} /^[A-Z][A-Za-z]*=/ && !group && section ~ /Service/ {print FILENAME ": no reason above " $0; bad = 1}
     /^\[/ {section = $0} END {exit bad}' "$unit"
