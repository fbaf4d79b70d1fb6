#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds everything and runs all tests but the longest (label "long"). Arguments go to ctest instead, e.g.
# ./test.sh -L fast -R projection, or ./test.sh -L long (half an hour).
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$root/build/release

"$root/scripts/install-dependencies.sh" --python
# the tests of the package compile the libraries again in other folders, with ccache, which has to see relative paths:
# files that are compiled as one lie in the build's folder
export CCACHE_NOHASHDIR=1 CCACHE_BASEDIR="${CCACHE_BASEDIR:-$root}"
# options of the preset "release", spelt out because the CMake of Ubuntu 22.04 does not support such presets
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
  -DSTEREOGRID_TESTS=ON -DSTEREOGRID_PYTHON=ON -DSTEREOGRID_SIMD=all
cmake --build "$build"
# three at a time on two cores: those with a network wait, 9 s of 10
[ $# -gt 0 ] || set -- --label-exclude "^long$"
ctest --test-dir "$build" --parallel 3 --output-on-failure --no-tests=error "$@"
