#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh MCAP_EXCHANGE FOLDER. Installs the packages in FOLDER and runs check.js there.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../npm.sh"

install_packages "$here" "$2"
cp "$here/check.js" "$2/"
cd "$2"
node check.js "$1"
