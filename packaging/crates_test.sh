#!/bin/bash
# Packs solids, nester and build-file as `cargo publish` would, and uses the packages as others do: bash packaging/crates_test.sh [--write-api]
#
# Packs the three in a row; checks what is in each; builds each from its package, alone; runs the examples of the documents from the
# packages, and those of the READMEs, with the examples of the nester compiled, in a client that knows only the packages; builds the
# documents as docs.rs does; compares the public interface with
# crates/*/public-api.txt. With --write-api it writes these files instead. Exit code 77 where it cannot run: no cargo, no Python, no registry.
set -euo pipefail
cd "$(dirname "$0")/.."
repo=$PWD
crates="solids nester build-file"
ignored() { echo "ignored: $*"; exit 77; }
fail() { echo "FAILED: $*"; exit 1; }
command -v cargo >/dev/null || ignored "needs cargo"
command -v python3 >/dev/null || ignored "needs python3"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo fetch --quiet --locked >"$work/log" 2>&1 || ignored "no registry has the crates: $(tail -1 "$work/log")"
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
began=$SECONDS

# `--no-verify`: cargo would compile all dependencies again for each of the three. What it verifies is below.
rm -f "$target"/package/*.crate
# shellcheck disable=SC2086
cargo package --quiet --locked --allow-dirty --no-verify $(printf -- '-p %s ' $crates) || fail "cargo package"
for crate in $crates; do
    archive=$(echo "$target/package/$crate"-[0-9]*.crate)
    mkdir "$work/$crate"
    tar xzf "$archive" -C "$work/$crate" --strip-components 1
    for text in LICENSE-APACHE LICENSE-MIT; do
        cmp -s "$text" "$work/$crate/$text" || fail "$crate: the package does not hold $text"
    done
    cmp -s "crates/$crate/README.md" "$work/$crate/README.md" || fail "$crate: the package does not hold the README"
    stray=$(cd "$work/$crate" && find . -type f | grep -vxE '\./(\.cargo_vcs_info\.json|Cargo\.(toml|toml\.orig|lock)|README\.md|LICENSE-(APACHE|MIT)|(src|examples)/[a-z0-9_/]+\.rs)' || true)
    [ -z "$stray" ] || fail "$crate: what is this in the package? $stray"
    grep -q '^\[package.metadata.docs.rs\]' "$work/$crate/Cargo.toml" || fail "$crate: docs.rs does not know its features"
    ! grep -q '^path = "\.\.' "$work/$crate/Cargo.toml" || fail "$crate: the package depends on a path"
    ls -l "$archive" | awk -v name="$crate" -v files="$(find "$work/$crate" -type f | wc -l)" '{ printf "%s: %.0f kB, %d files\n", name, $5 / 1e3, files }'
done

# A workspace elsewhere, of the packages and a client that names them as it would those of crates.io.
mkdir -p "$work/client/src/bin" "$work/run"
cat > "$work/Cargo.toml" <<END
[workspace]
members = ["client"$(printf ', "%s"' $crates)]
resolver = "3"
[patch.crates-io]
$(printf '%s = { path = "%s" }\n' $(for crate in $crates; do echo "$crate $crate"; done))
[profile.dev]
debug = false
[profile.dev.package.nester]
opt-level = 2
[profile.dev.package.solids]
opt-level = 2
END
cat > "$work/client/Cargo.toml" <<END
[package]
name = "client"
version = "0.0.0"
edition = "2024"
[dependencies]
$(for crate in $crates; do sed -n "s/^version = \(.*\)/$crate = \1/p" "$work/$crate/Cargo.toml" | head -1; done)
END
# Of what the tests of the crates need, the examples use serde_json; the rest takes long to compile.
python3 - "$work" $crates <<'END'
import re, sys
for crate in sys.argv[2:]:
    path = f"{sys.argv[1]}/{crate}/Cargo.toml"
    tables = re.split(r"^(?=\[)", open(path, encoding="utf-8").read(), flags=re.M)
    kept = [t for t in tables if not t.startswith("[dev-dependencies.") or t.startswith("[dev-dependencies.serde_json")]
    open(path, "w", encoding="utf-8").write("".join(kept))
END
cp Cargo.lock "$work/Cargo.lock" # the versions of others that are fetched
cp "$work/nester/examples/"*.rs "$work/client/src/bin/"
python3 - "$work" $crates <<'END'
import re, sys
work, crates = sys.argv[1], sys.argv[2:]
code, calls = ["//! The examples of the READMEs.", "use std::error::Error;"], []
for crate in crates:
    text = open(f"{work}/{crate}/README.md", encoding="utf-8").read()
    for number, block in enumerate(re.findall(r"^```rust.*?\n(.*?)^```$", text, re.M | re.S)):
        name = f"{crate.replace('-', '_')}_{number}"
        block = re.sub(r"^# ?", "", block, flags=re.M)
        code.append(f"fn {name}() -> Result<(), impl Into<Box<dyn Error>>> {{\n{block}}}")
        calls.append(f'    println!("-- {crate}, example {number}");\n    {name}().map_err(Into::<Box<dyn Error>>::into)?;')
files = """    use solids::{Mesh, Pose, glam::DVec3};
    for (name, mesh) in [("bar", Mesh::cuboid(DVec3::new(50.0, 20.0, 10.0))?), ("ring", Mesh::tube(30.0, 20.0, 6.0)?)] {
        build_file::write_stl([(&mesh, &Pose::IDENTITY)].into_iter(), std::fs::File::create(format!("{name}.stl"))?)?;
    }"""
code.append("fn main() -> Result<(), Box<dyn Error>> {\n" + "\n".join([files, *calls]) + "\n    Ok(())\n}")
open(f"{work}/client/src/main.rs", "w", encoding="utf-8").write("\n\n".join(code) + "\n")
END

cd "$work"
export CARGO_TARGET_DIR=$target/crates-test CARGO_NET_OFFLINE=true
for crate in $crates; do
    cargo check --quiet -p "$crate" || fail "$crate does not build from its package"
done
cargo check --quiet -p nester --no-default-features || fail "the nester does not build without its features"
cargo build --quiet -p client --bins || fail "what the documents say does not compile"
# shellcheck disable=SC2086
cargo test --quiet --doc $(printf -- '-p %s ' $crates) || fail "an example of the documents"
(cd run && "$CARGO_TARGET_DIR/debug/client") || fail "what the documents say does not run"

printf '#!/bin/sh\nRUSTC_BOOTSTRAP=1 exec rustdoc "$@"\n' > rustdoc.sh
chmod +x rustdoc.sh
for crate in $crates; do
    RUSTDOCFLAGS="-D warnings" cargo doc --quiet --no-deps --all-features -p "$crate" || fail "$crate: the documents"
    # The interface as rustdoc knows it. Not through an environment of rustc, which would compile all dependencies again.
    written=$CARGO_TARGET_DIR/doc/${crate//-/_}.json
    RUSTDOC=$work/rustdoc.sh cargo rustdoc --quiet --all-features -p "$crate" -- -Z unstable-options --output-format json >"$work/log" 2>&1 ||
        ignored "rustdoc writes no JSON, so that the interface of $crate is not compared: $(tail -1 "$work/log")"
    told=0
    python3 "$repo/packaging/public_api.py" "$written" > "$crate.api" || told=$?
    [ $told != 77 ] || ignored "the interface of $crate is not compared"
    [ $told = 0 ] || fail "$crate: its interface cannot be read"
    if [ "${1:-}" = --write-api ]; then
        cp "$crate.api" "$repo/crates/$crate/public-api.txt"
    else
        diff -U0 "$repo/crates/$crate/public-api.txt" "$crate.api" ||
            fail "the interface of $crate has changed. Where that is meant: bash packaging/crates_test.sh --write-api, and the version where callers break."
    fi
    echo "$crate: $(wc -l < "$crate.api") public items"
done
echo "the crates hold: $((SECONDS - began)) s"
