#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh STEREOGRID FOLDER. Has check.js look at a recording, and at a live scene, in Chromium.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../npm.sh"

chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || skip "there is no Chromium"
install_packages "$here" "$2"
rm -rf "$2/run" "$2/street.mcap"
"$1" run "scene:street?frames=30" --out "$2/run" --predict 0.5 --mcap "$2/street.mcap" --quiet
NODE_PATH="$2/node_modules" node "$here/check.js" "$1" "$chromium" "$2"
