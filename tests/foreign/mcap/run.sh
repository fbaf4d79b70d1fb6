#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh MCAP_EXCHANGE FOLDER. Installs the packages of package-lock.json in FOLDER and runs check.js there. Exit
# status 77, which ctest counts as skipped: there is no Node.js, or the packages cannot be had.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
exchange=$1
folder=$2
skip() { echo "SKIPPED: $1"; exit 77; }

command -v node >/dev/null && command -v npm >/dev/null || skip "there is no node or no npm"
mkdir -p "$folder"
cd "$folder"
cp "$here/package.json" "$here/check.js" .
if ! cmp -s "$here/package-lock.json" package-lock.json || [ ! -d node_modules ]; then
  rm -rf node_modules package-lock.json
  cp "$here/package-lock.json" .
  npm ci --ignore-scripts --no-audit --no-fund >npm.log 2>&1 || { rm -f package-lock.json; tail -n 3 npm.log; skip "npm ci failed"; }
fi
node check.js "$exchange"
