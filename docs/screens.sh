#!/bin/sh
# Makes the pictures of the pages in docs/screens: sh docs/screens.sh [CHROMIUM]. Needs Chromium, node and npm.
set -eu
cd "$(dirname "$0")/.."
NESTD_BROWSER=$(command -v "${1:-chromium}")
NESTD_SHOTS=$PWD/docs/screens
export NESTD_BROWSER NESTD_SHOTS
mkdir -p "$NESTD_SHOTS"
cargo test --test browser tasks
