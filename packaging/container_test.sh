#!/bin/bash
# Builds the container image and runs a farm in it, as systemd/README.md says: a part is taken, built, queued, and known after a restart:
# sudo packaging/container_test.sh [BINARY]
#
# Needs root, podman, buildah, mmdebstrap. Exit code 0 when every check holds, 77 when it cannot run here.
set -euo pipefail

BINARY=$(realpath "${1:-$(dirname "$0")/../target/release/nestd}")
REPO=$(realpath "$(dirname "$0")/..")
skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*"; podman "${STORE[@]}" logs nestd 2>/dev/null | tail -20; exit 1; }
[ "$(id -u)" = 0 ] || skip "needs root"
for program in podman buildah mmdebstrap unshare python3; do command -v $program >/dev/null || skip "needs $program"; done
if [ -z "${NESTD_IN_NAMESPACE:-}" ]; then
    export NESTD_IN_NAMESPACE=1
    exec unshare --mount --propagation private "$0" "$BINARY"
fi
# Container runtimes want version 2 of control groups alone.
if [ "$(stat -f -c %T /sys/fs/cgroup)" != cgroup2fs ]; then
    umount -R /sys/fs/cgroup && mount -t cgroup2 cgroup2 /sys/fs/cgroup || skip "no control groups of version 2 here"
fi

WORK=$(mktemp -d /tmp/nestd-container.XXXXXX)
STORE=(--root "$WORK/storage" --runroot "$WORK/run" --cgroup-manager cgroupfs)
# Where a machine may not raise limits, a container keeps below them.
LIMITS=(--ulimit nofile=1024:1024 --ulimit nproc=1000:1000 --cgroups disabled --network host)
VOLUMES=(-v "$WORK/farm:/farm" -v "$WORK/state:/farm/state")
RUN=(podman "${STORE[@]}" run "${LIMITS[@]}" "${VOLUMES[@]}")
end() { podman "${STORE[@]}" rm --force --time 5 nestd >/dev/null 2>&1 || true; umount -R "$WORK/storage/overlay" 2>/dev/null || true; rm -rf "$WORK"; }
trap end EXIT
inside() { podman "${STORE[@]}" exec nestd nestd "$@"; }
wait_for() { # WHAT COMMAND...
    for _ in $(seq 120); do if "${@:2}" >/dev/null 2>&1; then return; fi; sleep 0.5; done
    fail "it does not come to pass that $1"
}

sh "$REPO/packaging/container.sh" "$BINARY" "$WORK" >/dev/null
began=$SECONDS
podman "${STORE[@]}" load --quiet --input "$WORK"/nestd_*.oci.tar >/dev/null
if ! podman "${STORE[@]}" run --rm "${LIMITS[@]}" localhost/nestd --version >/dev/null 2>"$WORK/why"; then
    # What the runtime lacks on this machine is no fault of the image.
    grep -qE 'cgroup|mount|rlimit|permitted|namespace' "$WORK/why" && skip "no container can run here: $(tail -1 "$WORK/why")"
    fail "the image does not run: $(tail -1 "$WORK/why")"
fi
install -d -o 7878 -g 7878 "$WORK/farm" "$WORK/state"
"${RUN[@]}" --rm localhost/nestd init >/dev/null || fail "init"
"${RUN[@]}" --rm localhost/nestd machine new hp --model mjf-5200 >/dev/null || fail "machine new"
sed -i 's/^final_secs = .*/final_secs = 1.0/; s/^settle_secs = .*/settle_secs = 0.5/; s/^listen = .*/listen = "off"/' "$WORK/farm/config/nestd.toml"
start() { "${RUN[@]}" --detach --replace --name nestd --read-only --cap-drop all --security-opt no-new-privileges localhost/nestd >/dev/null; }
start || fail "it does not start"
wait_for "the hot folder is there" test -d "$WORK/farm/inbox/hp"

python3 - "$WORK/part.stl" <<'END'
import struct, sys
corners = [(x * 20.0, y * 30.0, z * 10.0) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
with open(sys.argv[1], "wb") as file:
    file.write(b"\0" * 80 + struct.pack("<I", len(faces)))
    for face in faces:
        file.write(struct.pack("<12fH", 0, 0, 0, *(number for corner in face for number in corners[corner]), 0))
END
install -o 7878 -g 7878 -m 0664 "$WORK/part.stl" "$WORK/farm/inbox/hp/.part_x3.stl"
mv "$WORK/farm/inbox/hp/.part_x3.stl" "$WORK/farm/inbox/hp/part_x3.stl"
wait_for "the part waits" sh -c "podman ${STORE[*]} exec nestd nestd status --parts | grep -q 'part_x3.stl'"
inside flush hp >/dev/null || fail "flush"
wait_for "the build is in the queue" sh -c "ls $WORK/farm/queue/hp/*.build.3mf"
queued=$((SECONDS - began))
[ "$(stat -c %u:%g "$WORK"/farm/queue/hp/*.build.3mf)" = 7878:7878 ] || fail "the build file is another account's"
[ -s "$WORK/state/nestd.db" ] || [ -n "$(ls "$WORK/state"/*.db 2>/dev/null)" ] || fail "the ledger is not in its volume"
podman "${STORE[@]}" stop --time 15 nestd >/dev/null
[ "$(podman "${STORE[@]}" inspect --format '{{.State.ExitCode}}' nestd)" = 0 ] || fail "a stop is not an orderly end"
start || fail "it does not start again"
wait_for "the build is known after the restart" sh -c "podman ${STORE[*]} exec nestd nestd history | grep -q hp"
inside check >"$WORK/check" 2>&1 || { cat "$WORK/check"; fail "check finds something"; }
quadlet=$(ls /usr/libexec/podman/quadlet /usr/lib/podman/quadlet 2>/dev/null | head -1 || true)
if [ -n "$quadlet" ]; then
    QUADLET_UNIT_DIRS=$REPO/systemd "$quadlet" -dryrun >"$WORK/unit" 2>&1 || { cat "$WORK/unit"; fail "the quadlet is not understood"; }
    grep -q 'localhost/nestd' "$WORK/unit" || fail "the quadlet makes no unit"
else
    echo "no quadlet here: systemd/nestd.container was not tried"
fi
echo "image of $(du -m "$WORK"/nestd_*.oci.tar | cut -f1) MB; $queued s from its file to a part in the queue; first start, part, build, stop, restart: all checks hold"
