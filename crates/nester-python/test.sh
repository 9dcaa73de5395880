#!/bin/bash
# Builds the wheel, installs it into a fresh environment and runs the tests there: bash crates/nester-python/test.sh [ARGUMENTS OF PYTEST]
# Exit code 77 where it cannot run: no Python, no venv, no cargo, or no registry. NESTD_WHEELS=<folder> keeps the wheel.
set -euo pipefail
cd "$(dirname "$0")"
ignored() { echo "ignored: $*"; exit 77; }
command -v python3 >/dev/null || ignored "needs python3"
command -v cargo >/dev/null || ignored "needs cargo"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 9))' || ignored "needs Python 3.9 or later"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
log=$work/log
python3 -m venv "$work/build" >"$log" 2>&1 || ignored "needs Python's venv"
"$work/build/bin/pip" install --quiet 'maturin>=1.9.4,<2' >"$log" 2>&1 || ignored "no registry has maturin: $(tail -1 "$log")"
# Not below this folder, where tests of the repository would take what was generated for its source.
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/../../target/nester-python}
cargo fetch --quiet --locked >"$log" 2>&1 || ignored "no registry has the crates: $(tail -1 "$log")"

# The wheel carries the notices of all that is linked into it.
sh ../../packaging/notices.sh nester-python crates/nester-python/Cargo.toml >third-party-notices.txt

wheels=${NESTD_WHEELS:-$work/wheels}
"$work/build/bin/maturin" build --release --locked --out "$wheels"

python3 -m venv "$work/fresh"
pip=$work/fresh/bin/pip
wheel=$(ls -t "$wheels"/*.whl | head -1)
"$pip" install --quiet numpy pytest >"$log" 2>&1 || ignored "no registry has numpy and pytest: $(tail -1 "$log")"
"$pip" install --quiet "$wheel"
# What needs one of these says so where it is not there.
for optional in trimesh networkx lxml manifold3d mypy nbclient ipykernel; do
    "$pip" install --quiet "$optional" >"$log" 2>&1 || echo "without $optional: $(tail -1 "$log")"
done
ls -l "$wheel" | awk '{ printf "wheel: %.2f MB\n", $5 / 1e6 }'
# Not from here, so that the installed package is tested and not the source beside it.
cp -r tests README.md python examples "$work"
cd "$work"
"$work/fresh/bin/python" -m pytest -p no:cacheprovider -ra tests "$@"
