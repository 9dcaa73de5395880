#!/bin/bash
# Fetches the generators of clients into a folder, which tests take as NESTD_API_TOOLS: fetch.sh FOLDER
set -euo pipefail
from=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
cd "$1"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check --requirement "$from/requirements.txt"
cp "$from/package.json" .
npm install --silent --no-audit --no-fund --no-package-lock --ignore-scripts
