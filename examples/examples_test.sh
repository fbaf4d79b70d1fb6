#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Usage: examples_test.sh STEREOGRID EXAMPLE
#
# drive: runs on a simulated drive; the road 10 m ahead is free, and obstacles are reported. stereo_camera: reads the same
# drive as the film of a camera that delivers both images side by side. Exit status 77: ffmpeg is missing.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" simulate 'scene:street?frames=6&width=320&height=160' --out "$folder/drive" --quiet
if [ "$(basename "$2")" = drive ]; then
  "$2" "$folder/drive" | tee "$folder/output"
  [ "$(grep -c '^frame [0-5]: P(occupied) 0\.[0-3][0-9]*, [0-9]* confirmed obstacles$' "$folder/output")" -eq 6 ]
  grep -q '^frame 5: .* [1-9][0-9]* confirmed obstacles$' "$folder/output"
  exit
fi
command -v ffmpeg >/dev/null || { echo "ffmpeg is missing: not tested" >&2; exit 77; }
ffmpeg -loglevel error -framerate 10 -pattern_type glob -i "$folder/drive/left/*.png" \
  -framerate 10 -pattern_type glob -i "$folder/drive/right/*.png" \
  -filter_complex hstack -c:v ffv1 "$folder/film.mkv"
"$2" "$folder/film.mkv" "$folder/drive/calibration.yaml" 6 | tee "$folder/output"
[ "$(grep -c '^frame [0-5]: [1-9][0-9]* cells occupied' "$folder/output")" -eq 6 ]
! grep -q 'hardly match\|grid is unknown' "$folder/output"
