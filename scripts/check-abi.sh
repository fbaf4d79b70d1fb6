#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# scripts/check-abi.sh [TAG]: whether programs that were linked with the shared core of TAG work with this one. Without
# TAG: the last tag of a version, v*. They need not where major or minor version differ: then the SONAME does, too.
# Exit status 0: they do, or need not, or there is no tag; 1: they do not; 2: nothing could be compared.
set -euo pipefail
cd "$(dirname "$0")/.."

tag=${1:-$(git describe --tags --abbrev=0 --match 'v[0-9]*' 2>/dev/null || true)}
if [ -z "$tag" ]; then
  echo "No version has been tagged yet: there is no interface to keep to."
  exit 0
fi
if ! git rev-parse --quiet --verify "$tag^{commit}" >/dev/null; then
  echo "There is no tag or commit $tag: nothing was compared." >&2
  exit 2
fi

minor_version() { sed -n 's/^project(stereogrid VERSION \([0-9]*\.[0-9]*\)\..*/\1/p'; }
before=$(git show "$tag:CMakeLists.txt" | minor_version)
now=$(minor_version <CMakeLists.txt)
if [ "$before" != "$now" ]; then
  echo "$tag has version $before, this is $now: programs look for a library of another name. Nothing has to be kept."
  exit 0
fi
if ! command -v abidiff >/dev/null; then
  echo "abidiff is missing: nothing was compared. Debian and Ubuntu: apt-get install abigail-tools" >&2
  exit 2
fi

out=build/abi
rm -rf "$out"
mkdir -p "$out/source"
git archive "$tag" | tar -x -C "$out/source"

build() { # build SOURCE NAME: a core with debug information about types; one instruction set contains them all
  cmake -S "$1" -B "$out/$2" -G Ninja --log-level=WARNING -DBUILD_SHARED_LIBS=ON -DSTEREOGRID_TOOL=OFF \
    -DSTEREOGRID_TESTS=OFF -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS=-DHWY_COMPILE_ONLY_STATIC >"$out/$2.log"
  cmake --build "$out/$2" >>"$out/$2.log" 2>&1 || { tail -40 "$out/$2.log"; exit 2; }
}
build "$out/source" before
build . now

# ignores types without a public header
status=0
abidiff --no-added-syms --drop-private-types --hd1 "$out/source/include" --hd2 include \
  "$out/before/src/libstereogrid.so" "$out/now/src/libstereogrid.so" || status=$?
if [ $((status & 3)) -ne 0 ]; then
  echo "abidiff failed: nothing was compared." >&2
  exit 2
fi
if [ "$status" -ne 0 ]; then
  echo "Programs that were linked with the core of $tag may break. Undo that, or raise the minor version in CMakeLists.txt." >&2
  exit 1
fi
echo "Programs that were linked with the core of $tag work with this one."
