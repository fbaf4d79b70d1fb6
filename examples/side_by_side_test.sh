#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: side_by_side_test.sh STEREOGRID STEREO_CAMERA
#
# A built-in scene as the film of a camera that delivers both images side by side, through the example. Exit status 77:
# ffmpeg is missing.
set -euo pipefail

command -v ffmpeg >/dev/null || { echo "ffmpeg is missing: not tested" >&2; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" simulate 'scene:street?frames=4&width=320&height=160' --out "$folder/drive" --quiet
ffmpeg -loglevel error -framerate 10 -pattern_type glob -i "$folder/drive/left/*.png" \
  -framerate 10 -pattern_type glob -i "$folder/drive/right/*.png" \
  -filter_complex hstack -c:v ffv1 "$folder/film.mkv"
"$2" "$folder/film.mkv" "$folder/drive/calibration.yaml" 4 | tee "$folder/said"
[ "$(grep -c '^frame [0-3]: [1-9][0-9]* cells occupied' "$folder/said")" -eq 4 ]
! grep -q 'hardly match\|grid is unknown' "$folder/said"
