#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh PROGRAM FOLDER. Installs the packages into FOLDER once, starts PROGRAM, and has check.js talk to it.
# Exit status 77: npm or the packages cannot be had.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$1
folder=$2

mkdir -p "$folder"
if ! cmp -s "$here/package-lock.json" "$folder/package-lock.json" || [ ! -d "$folder/node_modules/ws" ]; then
  command -v node >/dev/null && command -v npm >/dev/null || { echo "skipped: no node, or no npm"; exit 77; }
  cp "$here/package.json" "$here/package-lock.json" "$folder/"
  if ! (cd "$folder" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error); then
    rm -f "$folder/package-lock.json"
    echo "skipped: the packages cannot be had"
    exit 77
  fi
fi

coproc server { exec "$program"; }
# shellcheck disable=SC2154 # coproc sets it
read -r port <&"${server[0]}"
NODE_PATH="$folder/node_modules" node "$here/check.js" "$port"
