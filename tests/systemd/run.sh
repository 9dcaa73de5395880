#!/bin/bash
# Runs nestd's unit under a real systemd: boots a container from this machine (an overlay, so that the machine is not changed),
# installs binary, unit, account, folders and configuration as systemd/README.md says, and checks start, work, reload,
# watchdog and stop.
#
#   sudo tests/systemd/run.sh BINARY [RESULTS]
#
# Needs root, systemd-nspawn (Debian: apt install systemd-container). Exit code 0 when every check holds, 77 when it cannot run here.
set -euo pipefail

BINARY=$(realpath "${1:?usage: tests/systemd/run.sh BINARY [RESULTS]}")
REPO=$(realpath "$(dirname "$0")/../..")
RESULTS=${2:-$(mktemp -d)}
BOOT_SECS=330

skip() { echo "skipped: $*"; exit 77; }
[ "$(id -u)" = 0 ] || skip "needs root"
command -v systemd-nspawn >/dev/null || skip "needs systemd-nspawn"
command -v unshare >/dev/null || skip "needs unshare"

# A private mount namespace: the overlay disappears when this script ends, in whatever way.
if [ -z "${NESTD_IN_NAMESPACE:-}" ]; then
    mkdir -p "$RESULTS"
    export NESTD_IN_NAMESPACE=1
    exec unshare --mount --propagation private "$0" "$BINARY" "$(realpath "$RESULTS")"
fi
rm -f "$RESULTS"/{verdict,checks,journal,boot}

WORK=$(mktemp -d /tmp/nestd-systemd.XXXXXX)
trap 'umount -R "$WORK" 2>/dev/null || true; rmdir "$WORK" 2>/dev/null || true' EXIT
mount -t tmpfs -o size=2g tmpfs "$WORK"
mkdir "$WORK"/{upper,work,root}
mount -t overlay -o "lowerdir=/,upperdir=$WORK/upper,workdir=$WORK/work" overlay "$WORK/root"
ROOT=$WORK/root

# Removes the machine's own services, and the files of an installed nestd.
rm -rf "$ROOT"/etc/systemd/system/*.wants/* "$ROOT"/etc/nestd "$ROOT"/srv/nestd "$ROOT"/var/lib/nestd
rm -f "$ROOT"/etc/fstab; : > "$ROOT"/etc/fstab
: > "$ROOT"/etc/machine-id

# As systemd/README.md says.
install -m 0755 "$BINARY" "$ROOT/usr/bin/nestd"
install -D -m 0644 "$REPO/systemd/nestd.service" "$ROOT/usr/lib/systemd/system/nestd.service"
install -D -m 0644 "$REPO/systemd/nestd.sysusers" "$ROOT/usr/lib/sysusers.d/nestd.conf"
install -D -m 0644 "$REPO/systemd/nestd.tmpfiles" "$ROOT/usr/lib/tmpfiles.d/nestd.conf"
install -D -m 0644 "$REPO/docs/administrator.md" "$ROOT/usr/share/doc/nestd/administrator.md"
install -D -m 0644 "$REPO/systemd/servers.conf" "$ROOT/usr/share/doc/nestd/systemd/servers.conf"
install -d "$ROOT/etc/nestd/profiles"
install -m 0644 "$REPO/config/profiles/paper-200.toml" "$ROOT/etc/nestd/profiles/"

# Short times, so that the checks are fast; everything else is as shipped.
{
    echo 'scan_secs = 1'
    cat "$REPO/config/server/nestd.toml"
    printf '[defaults]\nsettle_secs = 1\nfinal_secs = 3\narrival_secs = 1\n'
} > "$ROOT/etc/nestd/nestd.toml"
install -d "$ROOT/etc/systemd/system/nestd.service.d"
printf '[Service]\nWatchdogSec=6\n' > "$ROOT/etc/systemd/system/nestd.service.d/watchdog.conf"

# The probe runs inside, then switches the container off.
install -m 0755 "$REPO/tests/systemd/probe.sh" "$ROOT/usr/local/bin/nestd-probe"
cat > "$ROOT/etc/systemd/system/probe.target" <<'UNIT'
[Unit]
Description=Checks of nestd
Requires=basic.target probe.service
After=basic.target
AllowIsolate=yes
UNIT
cat > "$ROOT/etc/systemd/system/probe.service" <<'UNIT'
[Unit]
Description=Checks nestd under systemd
After=basic.target systemd-journald.service
[Service]
Type=oneshot
ExecStart=/usr/local/bin/nestd-probe /results
ExecStopPost=/bin/systemctl --no-block poweroff --force
TimeoutStartSec=290
UNIT

timeout --kill-after=10 "$BOOT_SECS" systemd-nspawn --quiet --directory="$ROOT" --register=no --keep-unit --console=pipe \
    --bind="$RESULTS:/results" --boot systemd.unit=probe.target > "$RESULTS/boot" 2>&1 || true

cat "$RESULTS/checks" 2>/dev/null || { echo "the container did not come to its checks:"; tail -20 "$RESULTS/boot"; exit 1; }
[ "$(cat "$RESULTS/verdict" 2>/dev/null)" = passed ] || { echo "FAILED; journal: $RESULTS/journal"; exit 1; }
echo "passed; journal: $RESULTS/journal"
