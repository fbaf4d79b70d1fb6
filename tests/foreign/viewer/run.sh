#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh STEREOGRID STREET FOLDER. Installs the packages into FOLDER once, makes a recording with STREET, and has
# check.js look at it in Chromium. Exit status 77: Chromium, npm or the packages cannot be had.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
stereogrid=$1
street=$2
folder=$3

chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome) ||
  { echo "skipped: no chromium"; exit 77; }
mkdir -p "$folder"
if ! cmp -s "$here/package-lock.json" "$folder/package-lock.json" || [ ! -d "$folder/node_modules/playwright-core" ]; then
  command -v node >/dev/null && command -v npm >/dev/null || { echo "skipped: no node, or no npm"; exit 77; }
  cp "$here/package.json" "$here/package-lock.json" "$folder/"
  if ! (cd "$folder" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error); then
    rm -f "$folder/package-lock.json"
    echo "skipped: the packages cannot be had"
    exit 77
  fi
fi

"$street" "$folder/street.mcap"
NODE_PATH="$folder/node_modules" node "$here/check.js" "$stereogrid" "$street" "$chromium" "$folder"
