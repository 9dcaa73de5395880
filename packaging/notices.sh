#!/bin/sh
# Writes the notices of all that is linked into nestd, or into another package of a manifest: each crate with its version, its licence, and the
# texts that come with it, once where several crates have the same: sh packaging/notices.sh [PACKAGE MANIFEST] >third-party-notices.txt
# Needs cargo and the sources that it has fetched for a build.
set -eu
cd "$(dirname "$0")/.."
package=${1:-nestd}
manifest=${2:-Cargo.toml}
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
# The crates of nestd itself have their folder behind the version.
cargo tree --locked --offline --manifest-path "$manifest" --package "$package" --edges normal --no-dedupe --prefix none --format '{p}|{l}' | grep -v '(/' | sort -u |
    sed 's/^\([^ ]*\) v\([^ |]*\)[^|]*|/\1 \2: /' >"$work/crates"
while read -r name version _; do
    version=${version%:}
    # Also the texts of the C that some bring along.
    find "${CARGO_HOME:-$HOME/.cargo}"/registry/src/*/"$name-$version" -maxdepth 3 -type f \( -iname 'licen[sc]e*' -o -iname 'copying*' \
        -o -iname 'copyright*' -o -iname 'notice*' -o -iname 'unlicense*' \) -exec sha256sum {} + | sed "s|^|$name $version |"
done <"$work/crates" >"$work/texts"

cat <<END
$package is linked with the software of others. Each crate is named with its version and its licence; the texts that come with them follow.
A crate that brings no text of its own is under the text of the same licence below.

END
cat "$work/crates"
[ "$package" != nestd ] || cat <<'END'
SQLite (in libsqlite3-sys): public domain
meshoptimizer (in meshopt): MIT, Copyright (c) 2016-2026 Arseny Kapoulkine
three.js (in the 3D view of the dashboard): MIT, Copyright (c) 2010-2026 Three.js Authors
END
sort -u -k3,3 "$work/texts" | while read -r _ _ sum text; do
    of=$(awk -v sum="$sum" '$3 == sum && !seen[$1 $2]++ { print $1, $2 }' "$work/texts" | paste -sd, | sed 's/,/, /g')
    printf '\n----- %s\n\n' "$of"
    tr -d '\r' <"$text"
done
