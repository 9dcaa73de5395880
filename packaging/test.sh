#!/bin/bash
# Installs, upgrades, removes and purges the Debian package in a copy of this machine (an overlay, so that the machine is not changed),
# and asks lintian where it is installed: sudo packaging/test.sh [BINARY]
#
# Needs root, unshare, dpkg. Exit code 0 when every check holds, 77 when it cannot run here.
set -euo pipefail

BINARY=$(realpath "${1:-$(dirname "$0")/../target/release/nestd}")
REPO=$(realpath "$(dirname "$0")/..")
skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*"; exit 1; }
[ "$(id -u)" = 0 ] || skip "needs root"
for program in unshare dpkg-deb systemd-sysusers git; do command -v $program >/dev/null || skip "needs $program"; done
if [ -z "${NESTD_IN_NAMESPACE:-}" ]; then
    export NESTD_IN_NAMESPACE=1
    exec unshare --mount --propagation private "$0" "$BINARY"
fi

WORK=$(mktemp -d /tmp/nestd-deb.XXXXXX)
trap 'umount -R "$WORK" 2>/dev/null || true; rmdir "$WORK" 2>/dev/null || true' EXIT
mount -t tmpfs -o size=2g tmpfs "$WORK"
mkdir "$WORK"/{upper,work,root,first,again,second}
mount -t overlay -o "lowerdir=/,upperdir=$WORK/upper,workdir=$WORK/work" overlay "$WORK/root" || skip "no overlay here"
ROOT=$WORK/root
mount --bind /dev "$ROOT/dev"
mount -t proc proc "$ROOT/proc" || skip "no /proc here"
rm -rf "$ROOT"/etc/nestd "$ROOT"/srv/nestd "$ROOT"/var/lib/nestd

sh "$REPO/packaging/deb.sh" "$BINARY" "$WORK/first" >/dev/null
FIRST=$(echo "$WORK"/first/*.deb)
sleep 1
sh "$REPO/packaging/deb.sh" "$BINARY" "$WORK/again" >/dev/null
cmp "$FIRST" "$WORK"/again/*.deb || fail "the same binary and commit give another package"
# The next version: that of a repository with one more commit, which changes the farm file.
git -c safe.directory="$REPO/.git" clone -q "$REPO" "$WORK/next"
echo "# A line of the next version." >>"$WORK/next/config/server/nestd.toml"
git -C "$WORK/next" -c user.name=test -c user.email=test@localhost commit -q --all --message "a newer farm file"
sh "$WORK/next/packaging/deb.sh" "$BINARY" "$WORK/second" >/dev/null
SECOND=$(echo "$WORK"/second/*.deb)
version() { dpkg-deb -f "$1" Version; }
OLD=$(version "$FIRST") NEW=$(version "$SECOND") RELEASE=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' "$REPO/Cargo.toml")
dpkg --compare-versions "$NEW" gt "$OLD" || fail "$NEW is not newer than $OLD"
dpkg --compare-versions "$NEW" lt "$RELEASE" || fail "the release $RELEASE would not be newer than $NEW"
cp "$FIRST" "$ROOT/tmp/first.deb"
cp "$SECOND" "$ROOT/tmp/next.deb"
inside() { chroot "$ROOT" env -u NESTD_ROOT PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive "$@"; }

inside dpkg -i /tmp/first.deb >"$WORK/log" 2>&1 || { cat "$WORK/log"; fail "it is not installed"; }
inside nestd --version | grep -q '^nestd ' || fail "nestd does not run"
inside getent passwd nestd >/dev/null || fail "there is no user nestd"
[ "$(inside stat -c '%U:%G %a' /srv/nestd/inbox)" = "nestd:nestd 2770" ] || fail "the inbox is not the group's"
for file in usr/lib/systemd/system/nestd.service usr/share/man/man1/nestd-status.1.gz usr/share/man/man5/nestd.toml.5.gz usr/share/bash-completion/completions/nestd \
    usr/share/doc/nestd/nestd.toml usr/share/doc/nestd/third-party-notices.txt.gz usr/share/doc/nestd/examples/profiles/mjf-5200.toml \
    usr/share/doc/nestd/docs/servers.md etc/nestd/nestd.toml; do
    [ -s "$ROOT/$file" ] || fail "$file is missing"
done
inside nestd -c /etc/nestd/nestd.toml machine new hp --model mjf-5200 >/dev/null || fail "a machine cannot be added"
if inside sh -c 'command -v man' >/dev/null; then
    inside man -l --warnings /usr/share/man/man1/nestd-status.1.gz >"$WORK/man" 2>"$WORK/man-warnings" || fail "the manual page does not render"
    inside man -l --warnings /usr/share/man/man5/nestd.toml.5.gz >>"$WORK/man" 2>>"$WORK/man-warnings" || fail "nestd.toml(5) does not render"
    grep -q scan_secs "$WORK/man" || fail "nestd.toml(5) does not name scan_secs"
    grep -q -e '--watch' "$WORK/man" || fail "the manual page does not name --watch"
fi

sed -i 's/^time_zone = .*/time_zone = "Europe\/Berlin"/' "$ROOT/etc/nestd/nestd.toml"
echo "a part" >"$ROOT/srv/nestd/inbox/part.stl"
inside dpkg -i /tmp/next.deb >"$WORK/log" 2>&1 || { cat "$WORK/log"; fail "it is not upgraded"; }
[ "$(inside dpkg-query -W -f '${Version}' nestd)" = "$NEW" ] || fail "the version is not the next one"
! grep -q 'next version' "$ROOT/etc/nestd/nestd.toml" || fail "the upgrade changed the farm file"
grep -q 'next version' "$ROOT/usr/share/doc/nestd/examples/nestd.toml" || fail "the newer example is not there"
[ -z "$(inside dpkg-query -W -f '${Conffiles}' nestd)" ] || fail "a conffile would stop an upgrade"
grep -q Berlin "$ROOT/etc/nestd/nestd.toml" || fail "the upgrade overwrote the configuration"
[ -s "$ROOT/etc/nestd/profiles/hp.toml" ] || fail "the upgrade took a machine away"

wanted=$ROOT/etc/systemd/system/multi-user.target.wants/nestd.service
if inside sh -c 'command -v systemctl' >/dev/null; then
    inside systemctl enable nestd >"$WORK/log" 2>&1 || { cat "$WORK/log"; fail "it cannot be enabled"; }
    [ -L "$wanted" ] || fail "enabled, it is not wanted at boot"
fi
inside dpkg -r nestd >"$WORK/log" 2>&1 || { cat "$WORK/log"; fail "it is not removed"; }
[ ! -e "$ROOT/usr/bin/nestd" ] || fail "the binary is still there"
[ ! -L "$wanted" ] || fail "the unit is gone, and wanted at boot all the same"
grep -q Berlin "$ROOT/etc/nestd/nestd.toml" || fail "the configuration is gone with the program"
inside dpkg -P nestd >"$WORK/log" 2>&1 || { cat "$WORK/log"; fail "it is not purged"; }
[ ! -e "$ROOT/etc/nestd/nestd.toml" ] || fail "the configuration is still there after the purge"
[ -s "$ROOT/etc/nestd/profiles/hp.toml" ] || fail "a machine that the shop wrote is gone"
[ -s "$ROOT/srv/nestd/inbox/part.stl" ] || fail "a dropped part is gone with the package"
if command -v lintian >/dev/null; then
    lintian --fail-on error,warning --allow-root "$FIRST" >"$WORK/lintian" 2>&1 || { cat "$WORK/lintian"; fail "lintian finds something"; }
    echo "lintian: no errors, no warnings"
fi
echo "installed, upgraded, removed, purged: all checks hold"
