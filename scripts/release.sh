#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# release.sh [FOLDER]: builds the published files of the checked-out commit: Debian packages, a wheel, an archive of the
# tool, sources, SPDX documents of the Debian packages, this version's part of CHANGELOG.md, checksums. Run
# scripts/bare-debian.sh on the commit first: it checks the README's commands on a bare system.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
out=${1:-$root/build/release-files}
if [ -n "$(git status --porcelain)" ]; then
  echo "The tree has changes that are not committed: what is released has to be a commit." >&2
  exit 1
fi
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
version=$(sed -n 's/^project(stereogrid VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)

rm -rf "$out"
mkdir -p "$out"
scripts/package.sh "$root/build/package"
cp build/package/packages/* "$out"
git archive --format=tar --prefix="stereogrid-$version/" HEAD | gzip -9n >"$out/stereogrid-$version.tar.gz"
awk '/^## /{if (found) exit; found=1} found' CHANGELOG.md >"$out/CHANGES-$version.md"
python3 scripts/sbom.py "$version" "$out"/*.deb >"$out/stereogrid-$version.spdx.json"
(cd "$out" && sha256sum -- * >SHA256SUMS)
ls -l "$out"
