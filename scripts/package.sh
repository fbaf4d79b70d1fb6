#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# package.sh [--debian] [BUILD_FOLDER [CMAKE_OPTION...]]: published files, in BUILD_FOLDER/packages (build/package): Debian
# packages, and with scripts/wheel.sh a wheel and an archive of the tool. --debian: only the Debian packages. Twice
# the same sources make twice the same bytes of these.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
only_debian=
if [ "${1:-}" = --debian ]; then
  only_debian=yes
  shift
fi
build=${1:-$root/build/package}
shift || true
cd "$root"
scripts/install-dependencies.sh --package
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
export SOURCE_DATE_EPOCH
date=$(LC_ALL=C date --utc --date "@$SOURCE_DATE_EPOCH" -R)

configure() {
  cmake -S . -B "$build" -G Ninja --log-level=WARNING -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr \
    -DCMAKE_INSTALL_LIBDIR="lib/$(dpkg-architecture -q DEB_HOST_MULTIARCH)" -DBUILD_SHARED_LIBS=ON -DCMAKE_BUILD_WITH_INSTALL_RPATH=ON \
    -DSTEREOGRID_TESTS=OFF -DSTEREOGRID_RESEARCH=OFF -DSTEREOGRID_DEBIAN=ON -DSTEREOGRID_DATE="$date" "$@"
}
configure "$@"
cmake --build "$build"
export LD_LIBRARY_PATH=$build/bin # as in the packages, the tool contains the path of the libraries

# manual pages: what the program says of itself, and of each of its commands
rm -rf "$build/man" "$build/packages"
mkdir -p "$build/man"
manual() { # manual NAME SUMMARY [COMMAND]
  local tool=$build/bin/stereogrid
  help2man --no-info --no-discard-stderr --section 1 --name "$2" --version-string "$("$tool" --version)" \
    --help-option="${3:-} --help" "$tool" | sed "s/^\.TH [^ ]*/.TH ${1^^}/" | gzip -9n >"$build/man/$1.1.gz"
}
manual stereogrid "occupancy grids and obstacles from a stereo camera"
COLUMNS=120 "$build/bin/stereogrid" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]\+\)  *\(.*\)/\1 \2/p' |
  while read -r command summary; do manual "stereogrid-$command" "${summary%%.*}" "$command"; done

configure "$@"
cpack --config "$build/CPackConfig.cmake" -B "$build/packages" >"$build/cpack.log" 2>&1 || { cat "$build/cpack.log" >&2; exit 1; }
rm -rf "$build/packages/_CPack_Packages"
if [ -z "$only_debian" ]; then
  scripts/wheel.sh "$build/packages" /usr/bin/python3 "${@#-D}"
fi
ls -l "$build/packages"
