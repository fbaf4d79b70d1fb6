#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh STEREOGRID STREET FOLDER. Has check.js look at a recording, and at what STREET sends, in Chromium.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../npm.sh"

chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || skip "there is no Chromium"
install_packages "$here" "$3"
rm -rf "$3/run" "$3/street.mcap"
"$1" run "scene:street?frames=30" --out "$3/run" --predict 0.5 --mcap "$3/street.mcap" --quiet
NODE_PATH="$3/node_modules" node "$here/check.js" "$1" "$2" "$chromium" "$3"
