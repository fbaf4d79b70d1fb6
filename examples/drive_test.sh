#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: drive_test.sh STEREOGRID DRIVE
#
# Runs the example on a simulated drive. The road 10 m ahead is free, and obstacles are reported.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" simulate 'scene:street?frames=3&width=320&height=160' --out "$folder/drive" --quiet
"$2" "$folder/drive" | tee "$folder/output"
[ "$(grep -c '^frame [0-2]: P(occupied) 0\.[0-3][0-9]*, [1-9][0-9]* obstacles$' "$folder/output")" -eq 3 ]
