#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh PROGRAM WORK. Has what PROGRAM (message_samples) writes read by Foxglove's packages, installed into the
# folder WORK. Exit status 77: they cannot be had here.
set -euo pipefail
program=$1
work=$2
here=$(cd "$(dirname "$0")" && pwd)

command -v node >/dev/null && command -v npm >/dev/null || { echo "SKIPPED: node and npm are not here"; exit 77; }
mkdir -p "$work"
cp "$here"/package.json "$here"/package-lock.json "$here"/check.js "$work"
cd "$work"
if ! cmp -s package-lock.json node_modules/installed.json; then
  npm ci --no-audit --no-fund --loglevel=error || { echo "SKIPPED: the npm packages cannot be had"; exit 77; }
  cp package-lock.json node_modules/installed.json
fi
"$program" samples.json
node check.js samples.json
