#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh FOLDER SCRIPT PROGRAM. Installs the packages of npm in FOLDER, once, and runs SCRIPT there on the output of
# PROGRAM. Exit status 77, which ctest counts as skipped: Node.js, the packages or Chromium are missing.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

skip() {
  echo "SKIPPED: $1"
  exit 77
}

command -v node >/dev/null && command -v npm >/dev/null || skip "there is no node, or no npm"
mkdir -p "$1"
cd "$1"
if ! cmp -s "$here/package-lock.json" node_modules/installed.json; then
  cp "$here/package.json" "$here/package-lock.json" .
  npm ci --ignore-scripts --no-audit --no-fund --loglevel=error || skip "the packages cannot be had"
  cp package-lock.json node_modules/installed.json
fi
script=${2//\//_} program=$3
arguments=("$program")
case $2 in
  server/*)
    coproc server { exec "$program"; }
    # shellcheck disable=SC2154 # coproc sets it
    read -r port <&"${server[0]}"
    arguments=("$port")
    ;;
  viewer/* | playground/*)
    chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || skip "there is no Chromium"
    arguments+=("$chromium" "$PWD")
    ;;&
  viewer/*)
    rm -rf run street.mcap
    "$program" run "scene:street?frames=30" --out run --predict 0.5 --mcap street.mcap --quiet
    ;;
  playground/*)
    cmake -S "$here/../../viewer/playground" -B wasm -G Ninja || skip "there is no clang for WebAssembly (viewer/playground/CMakeLists.txt)"
    cmake --build wasm
    rm -rf page
    STEREOGRID=$program python3 "$here/../../scripts/playground.py" --wasm wasm/stereogrid.wasm page
    ;;
esac
cp "$here/$2" "$script"
node "$script" "${arguments[@]}"
