#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh MESSAGE_SAMPLES FOLDER. Has what MESSAGE_SAMPLES writes read by Foxglove's packages.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../npm.sh"

install_packages "$here" "$2"
cp "$here/check.js" "$2/"
cd "$2"
"$1" samples.json
node check.js samples.json
