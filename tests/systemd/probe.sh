#!/bin/bash
# Runs inside the container that run.sh boots: checks nestd under systemd, writes `checks`, `journal` and `verdict` into $1.
set -u
RESULTS=$1
failures=0

say() { echo "$*" | tee -a "$RESULTS/checks"; }
check() { # NAME COMMAND...: the check holds when the command succeeds
    local name=$1; shift
    if "$@" > /tmp/said 2>&1; then say "ok      $name"; else say "FAILED  $name"; sed 's/^/        /' /tmp/said >> "$RESULTS/checks"; failures=$((failures + 1)); fi
}
within() { # SECONDS COMMAND...: the command succeeds some time within so long
    local end=$((SECONDS + $1)); shift
    until "$@"; do [ $SECONDS -lt $end ] || return 1; sleep 0.3; done
}
property() { systemctl show --value -p "$1" nestd; }
is_active() { [ "$(property ActiveState)" = active ]; }
as_nestd() { runuser -u nestd -- nestd "$@" -c /etc/nestd/nestd.toml; }

# An ASCII cube with an edge of 20 mm: cube NAME
cube() {
    python3 - "$1" <<'PYTHON'
import sys
corner = lambda i: tuple(20.0 * (i >> k & 1) for k in range(3))
quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
with open(sys.argv[1], "w") as out:
    out.write("solid cube\n")
    for a, b, c, d in quads:
        for triangle in ((a, b, c), (a, c, d)):
            corners = "".join("vertex %g %g %g\n" % corner(i) for i in triangle)
            out.write("facet normal 0 0 0\nouter loop\n%sendloop\nendfacet\n" % corners)
    out.write("endsolid cube\n")
PYTHON
}

verifies() { local said; said=$(systemd-analyze verify --man=no /usr/lib/systemd/system/nestd.service 2>&1); echo "$said"; [ -z "$said" ]; }
security() { systemd-analyze security --offline=true --threshold=15 /usr/lib/systemd/system/nestd.service | tail -1; return "${PIPESTATUS[0]}"; }
builds() { find "/srv/nestd/queue/$1" -maxdepth 1 -name '[!.]*.build.3mf' 2>/dev/null | wc -l; }
published() { [ "$(builds "$1")" = "$2" ]; }
flushed() { as_nestd flush "$1"; }

check "the account is made" systemd-sysusers /usr/lib/sysusers.d/nestd.conf
check "the folders are made" systemd-tmpfiles --create /usr/lib/tmpfiles.d/nestd.conf
check "the unit verifies without a word" verifies
check "systemd-analyze security gives at most 1.5" security
systemctl daemon-reload
check "nestd check finds no problem before the first start" as_nestd check

# systemctl start of a notify service returns when READY=1 has come.
check "it starts and says that it is ready" timeout 30 systemctl start nestd
check "it is active" is_active
check "it says what it does" test -n "$(property StatusText)"
check "it runs as nestd" test "$(ps -o user= -p "$(property MainPID)")" = nestd

check "the hot folder is there" within 10 test -d /srv/nestd/inbox/paper-200
cube /srv/nestd/inbox/paper-200/cube_x3.stl
chmod 0644 /srv/nestd/inbox/paper-200/cube_x3.stl
check "a dropped part is taken" within 20 test ! -e /srv/nestd/inbox/paper-200/cube_x3.stl
check "flush is taken" within 20 flushed paper-200
check "the build is in the queue" within 60 published paper-200 1
as_nestd status >> "$RESULTS/checks" 2>&1
as_nestd history >> "$RESULTS/checks" 2>&1

# A technician in the group, with an order folder that only the technician may write to.
useradd -M -G nestd technician 2>/dev/null
check "a technician drops an order" runuser -u technician -- sh -c \
    'umask 077; mkdir "/srv/nestd/inbox/paper-200/order 7" && cat > "/srv/nestd/inbox/paper-200/order 7/piece.stl"' < <(cube /tmp/piece.stl; cat /tmp/piece.stl)
check "it is taken or refused with a reason" within 30 test ! -e "/srv/nestd/inbox/paper-200/order 7/piece.stl"

# Least privilege, and the operator's commands from docs/administrator.md.
refuses_root() { ! /usr/bin/nestd run -c /etc/nestd/nestd.toml > /tmp/said 2>&1 && grep -q 'does not run as root' /tmp/said; }
check "it does not run as root" refuses_root
owns_only_its_folders() {
    ! find / -xdev -user nestd -not -path '/srv/nestd*' -not -path '/var/lib/nestd*' -not -path '/proc/*' -not -path '/tmp/*' -not -path '/run/*' 2>/dev/null | grep .
}
check "its user owns only its folders" owns_only_its_folders
others_see_nothing() { ! find /srv/nestd /var/lib/nestd -perm /007 2>/dev/null | grep .; }
check "others may neither read nor write what it makes" others_see_nothing
modes() { [ "$(stat -c '%a %G' /srv/nestd/queue/paper-200/*.build.3mf)" = "660 nestd" ]; }
check "a build has the mode of the configuration and the group of its folder" modes
install -d -o nestd -g nestd /var/backups/nestd /var/backups/nestd/store
nestd() { as_nestd "$@"; }
# The indented lines of a section of the document, with the day that the document names as an example.
documented() { sed -n "/^## $1\$/,/^## /p" /usr/share/doc/nestd/administrator.md | sed -n 's/^    //p' | sed "s/2026-11-20/$(date +%F)/"; }
does_as_documented() { local line; while read -r line; do echo "$line"; eval "$line" || return 1; done < <(documented "$1"); }
check "backing up works as documented" does_as_documented "Backing up"
check "restoring works as documented" does_as_documented "Restoring"
check "it is active after the restore" within 20 is_active

before=$(property MainPID)
cp /etc/nestd/profiles/paper-200.toml /etc/nestd/profiles/second-200.toml
check "it reloads" timeout 20 systemctl reload nestd
check "a new machine has its hot folder without a restart" within 15 test -d /srv/nestd/inbox/second-200
check "it is the same process" test "$before" = "$(property MainPID)"
check "it is active after the reload" within 5 is_active
echo 'volume_mm = "wrong"' > /etc/nestd/profiles/third.toml
systemctl reload nestd
sleep 2
check "a wrong configuration does not stop it" is_active
journalctl -u nestd --no-pager -o cat | grep -q 'third.toml' && say "ok      the journal names the wrong file" || { say "FAILED  the journal names the wrong file"; failures=$((failures + 1)); }
rm /etc/nestd/profiles/third.toml
systemctl reload nestd

# A stopped process sends no heartbeat.
kill -STOP "$before"
restarted() { is_active && [ "$(property MainPID)" != "$before" ] && [ "$(property MainPID)" != 0 ]; }
check "the watchdog has it killed and started anew" within 60 restarted
check "the reason was the watchdog" sh -c "journalctl -u nestd --no-pager -o cat | grep -qi 'watchdog'"
cube /srv/nestd/inbox/second-200/after.stl
check "it works after the restart" within 20 test ! -e /srv/nestd/inbox/second-200/after.stl
check "flush is taken after the restart" within 20 flushed second-200
check "the second build is in its queue" within 60 published second-200 1
check "the first build is still there once" published paper-200 1

started=$SECONDS
stopped_at=$(date '+%Y-%m-%d %H:%M:%S')
check "it stops" timeout 20 systemctl stop nestd
took=$((SECONDS - started))
check "it stops within 10 s (took $took s)" test $took -le 10
ended_well() { journalctl -u nestd --no-pager -o cat --since "$stopped_at" | tee /dev/stderr | grep -q 'Deactivated successfully'; }
check "it ended by itself, with success" ended_well
check "nestd check finds no problem afterwards" as_nestd check
# From one server to several, as docs/servers.md says. The second node is a process beside the unit.
postgres=$(find /usr/lib/postgresql -maxdepth 2 -name bin 2>/dev/null | tail -1)
if [ -n "$postgres" ]; then
    install -d -o postgres /tmp/pg
    as_postgres() { runuser -u postgres -- "$@"; }
    database() {
        as_postgres "$postgres/initdb" -D /tmp/pg/data --auth-local=trust --auth-host=scram-sha-256 &&
            as_postgres "$postgres/pg_ctl" -D /tmp/pg/data -l /tmp/pg/log -o "-p 5499 -h 127.0.0.1 -k /tmp/pg" -w start &&
            as_postgres psql -h /tmp/pg -p 5499 -d postgres -c "CREATE USER nestd PASSWORD 'of-the-ledger-0123456789'" -c "CREATE DATABASE nestd OWNER nestd"
    }
    check "a database is made" database
    secret() { install -m 0640 -g nestd /dev/null "/etc/nestd/$1" && echo "$2" > "/etc/nestd/$1"; }
    secret ledger-password of-the-ledger-0123456789
    secret token a-token-of-all-nodes-0123456789
    ledger=postgres://nestd@127.0.0.1:5499/nestd
    check "the ledger is copied" as_nestd ledger copy /var/lib/nestd/nestd.db "$ledger" --password-file /etc/nestd/ledger-password
    node() { # FILE NAME PORT: the settings of a node
        sed -i "s|^\\[folders\\]|[folders]\\nledger = \"$ledger\"\\nledger_password_file = \"/etc/nestd/ledger-password\"|" "$1"
        printf '[node]\nname = "%s"\naddress = "http://127.0.0.1:%s"\n[web]\nlisten = "127.0.0.1:%s"\ntoken_file = "/etc/nestd/token"\n' "$2" "$3" "$3" >> "$1"
    }
    install -d -o nestd -g nestd /tmp/second /tmp/second/profiles
    sed 's|/srv/nestd|/tmp/second|; s|/var/lib/nestd|/tmp/second/state|' /etc/nestd/nestd.toml > /tmp/second/nestd.toml
    node /etc/nestd/nestd.toml print1 7878
    node /tmp/second/nestd.toml print2 7879
    install -D -m 0644 /usr/share/doc/nestd/systemd/servers.conf /etc/systemd/system/nestd.service.d/servers.conf
    systemctl daemon-reload
    check "nestd check finds no problem with the database" as_nestd check
    check "it starts on the database" timeout 60 systemctl start nestd
    tells() { python3 -c 'import sys, urllib.request as u; r = u.Request("http://127.0.0.1:%s%s" % (sys.argv[1], sys.argv[2]), headers={"Authorization": "Bearer a-token-of-all-nodes-0123456789"}); sys.exit(sys.argv[3] not in u.urlopen(r, timeout=10).read().decode())' "$@"; }
    check "its history is there" tells 7878 /history paper-200
    # A machine moves to another server: its file goes there, and both reload.
    mv /etc/nestd/profiles/second-200.toml /tmp/second/profiles/
    systemctl reload nestd
    runuser -u nestd -- nestd run -c /tmp/second/nestd.toml > /tmp/second/log 2>&1 &
    check "a second node has the machine" within 90 test -d /tmp/second/inbox/second-200
    two_nodes() { [ "$(as_nestd nodes --json | grep -c '"alive": true')" = 2 ]; }
    check "nestd nodes lists both" within 30 two_nodes
    cube /tmp/second/inbox/second-200/there.stl && chmod 0644 /tmp/second/inbox/second-200/there.stl
    check "a part that is dropped on the second is seen on the pages of the first" within 60 tells 7878 /parts there.stl
    check "flush is taken by the first for the second" within 20 flushed second-200
    there() { [ "$(find /tmp/second/queue/second-200 -name '[!.]*.build.3mf' | wc -l)" = 1 ]; }
    check "the build is in the queue of the second" within 60 there
    number=$(find /tmp/second/queue/second-200 -name '[!.]*.build.3mf' | sed 's/.*_0*\([0-9]*\)\.build\.3mf/\1/')
    check "its report is had from the first" tells 7878 "/builds/$number/report.html" there
    cat /tmp/second/log >> "$RESULTS/checks"
    kill %1
    wait
    check "it stops on the database" timeout 20 systemctl stop nestd
fi
check "nothing was killed by the system-call filter" sh -c "! journalctl --no-pager | grep -qi 'SIGSYS\|seccomp'"

journalctl --no-pager -o short-precise -u nestd > "$RESULTS/journal" 2>&1
# One entry of the journal a line; the wrong configuration and the watchdog are the two errors that were provoked.
unexpected() {
    journalctl -u nestd -p err --no-pager -o json | grep -v 'third.toml' | grep -v 'Watchdog timeout'
}
check "no error was logged but those that were provoked" test -z "$(unexpected)"
unexpected >> "$RESULTS/checks"
if [ $failures = 0 ]; then echo passed > "$RESULTS/verdict"; else echo "$failures failed" > "$RESULTS/verdict"; fi
say "$(cat "$RESULTS/verdict")"
