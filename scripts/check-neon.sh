#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Cross-compiles the core and its tests for 64-bit ARM (NEON) with warnings as errors, without oneTBB, and runs
# the tests in an emulator where there is one. Needs g++-aarch64-linux-gnu; qemu-user to run.
# Arguments go to the tests: scripts/check-neon.sh --gtest_filter='Matching*'. CXX names another compiler.
set -euo pipefail
cd "$(dirname "$0")/.."

compiler=${CXX:-aarch64-linux-gnu-g++}
if ! command -v "$compiler" >/dev/null; then
  echo "$compiler is missing: nothing was checked. Debian and Ubuntu: apt-get install g++-aarch64-linux-gnu qemu-user" >&2
  exit 2
fi

out=build/neon
mkdir -p "$out/include/oneapi/tbb" "$out/objects"
# this machine's headers that are the same on every machine, without those beside them that are not
includes=$(pkg-config --variable=includedir libhwy)
ln -sfn "$includes/hwy" "$out/include/hwy"
ln -sfn "$includes/gtest" "$out/include/gtest"
for header in blocked_range info parallel_for task_arena; do
  ln -sfn "$PWD/tests/tbb.hpp" "$out/include/oneapi/tbb/$header.h"
done
ln -sfn oneapi/tbb "$out/include/tbb"
googletest=/usr/src/googletest/googletest
googlemock=/usr/src/googletest/googlemock
cmake -D VERSION=neon -D ROOT="$PWD" -D OUTPUT="$out/build_id.cpp" -P cmake/build_id.cmake

mapfile -t sources < <(find src tests/core/unit tests/core/equality -name '*.cpp')
# definitions as in src/CMakeLists.txt, warnings as in cmake/compiler.cmake
cat >"$out/flags" <<FLAGS
-std=c++20 -O2 -ffp-contract=off
-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Wno-restrict -Werror
-DHWY_DISABLED_TARGETS=(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)
-DSTEREOGRID_LIBRARY_FOLDER=\\"lib\\"
-Iinclude -Isrc -Itests/core -isystem $googletest -isystem $googlemock -isystem build/neon/include
FLAGS
rm -f "$out"/objects/*
for source in "${sources[@]}" tests/core/support.cpp "$googletest/src/gtest-all.cc" "$googlemock/src/gmock-all.cc" \
  "$googlemock/src/gmock_main.cc" tests/neon/highway.cpp "$out/build_id.cpp"; do
  object=$(tr / _ <<<"${source#/}").o
  echo "$(command -v ccache || true) $compiler @$out/flags -c $source -o $out/objects/$object"
done | tr '\n' '\0' | xargs -0 -n 1 -P "$(nproc)" sh -c '$0'
"$compiler" -static "$out"/objects/*.o -o "$out/stereogrid_core_tests"
echo "The core and its tests compile for ARM: $out/stereogrid_core_tests"

if [ "$(uname -m)" = aarch64 ]; then
  exec "$out/stereogrid_core_tests" "$@"
elif command -v qemu-aarch64 >/dev/null; then
  exec qemu-aarch64 "$out/stereogrid_core_tests" "$@"
fi
echo "qemu-aarch64 is missing: the tests were not run. Debian and Ubuntu: apt-get install qemu-user"
