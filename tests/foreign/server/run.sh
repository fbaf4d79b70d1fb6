#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh SERVED_CHANNELS FOLDER. Starts SERVED_CHANNELS and has check.js talk to it.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../npm.sh"

install_packages "$here" "$2"
coproc server { exec "$1"; }
# shellcheck disable=SC2154 # coproc sets it
read -r port <&"${server[0]}"
NODE_PATH="$2/node_modules" node "$here/check.js" "$port"
