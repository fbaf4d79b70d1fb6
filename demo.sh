#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds the tool and shows what it does.
#
#   ./demo.sh                  simulates a drive through a street and runs the pipeline on it
#   ./demo.sh INPUT [OPTION…]  runs the pipeline on your own drive (a folder, a pair of images with --calibration, or
#                              scene:NAME); options are those of `stereogrid run`
#
# Results go to out/demo/ beside this script; earlier results of the same name are replaced.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$root/build/release
out=$root/out/demo
tool=$build/bin/stereogrid

"$root/scripts/install-dependencies.sh" --tool
# the tests' libraries are not installed here; ./test.sh and the preset add the tests and all instruction sets
only_here=()
[ -e "$build/CMakeCache.txt" ] || only_here=(-DSTEREOGRID_TESTS=OFF -DSTEREOGRID_SIMD=host)
# options of the preset "release", spelt out because the CMake of Ubuntu 22.04 does not support such presets
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
  --log-level=WARNING "${only_here[@]}"
targets=(stereogrid_tool)
# library that --ros2 loads, if Cyclone DDS is installed
! cmake --build "$build" --target help | grep -q '^stereogrid_dds:' || targets+=(stereogrid_dds)
cmake --build "$build" --target "${targets[@]}"

if [ $# -eq 0 ]; then
  name=street
  rm -rf "$out/street"
  "$tool" simulate 'scene:street?frames=30' --out "$out/street"
  set -- "$out/street"
else
  name=${1#scene:}                                   # scene:street?frames=60 → street
  name=${name%%\?*}
  name=$(basename -- "$name")                        # some/where/drive/ → drive
  name=$(printf %s "${name%.*}" | tr -c 'A-Za-z0-9_-' _)
  case "$name" in '' | _ | __) name=drive ;; esac    # . and ..
fi
run=$out/$name-run
rm -rf "$run" "$run.mcap"
"$tool" run "$@" --out "$run" --pictures --mcap "$run.mcap"

cat <<END

Look at
  $run/pictures      a picture per frame: camera with overlay, u-disparity grid, Cartesian grid with velocities
  $run/grids         the same as numbers: numpy.load opens every .npz
  $run/frames.jsonl  a line per frame: pose, ground, timing, obstacles
  $run/run.json      the whole configuration and the timing
or play it in the browser:
  $tool view $run.mcap
END
