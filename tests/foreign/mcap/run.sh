#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: run.sh SCRIPT PROGRAM FOLDER. Installs the packages in FOLDER and runs SCRIPT with the program there.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/../npm.sh"

install_packages "$here" "$3"
cp "$here/$1" "$3/"
cd "$3"
node "$1" "$2"
