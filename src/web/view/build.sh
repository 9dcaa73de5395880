#!/bin/sh
# Bundles the 3D view with three.js (MIT, its notice stays in the bundle): sh src/web/view/build.sh [--check]
# --check says whether the committed bundle matches these sources.
set -eu
cd "$(dirname "$0")"
out=$(mktemp -d)
trap 'rm -r "$out"' EXIT
cp ./*.js package.json "$out"
(cd "$out" && npm install --silent --no-audit --no-fund && node node_modules/esbuild/install.js &&
    npx esbuild view.js --bundle --minify --format=esm --legal-comments=inline --outfile=bundle.js --log-level=warning)
if [ "${1:-}" = --check ]; then cmp "$out/bundle.js" ../assets/view.js && echo "the bundle is up to date"; else cp "$out/bundle.js" ../assets/view.js; fi
