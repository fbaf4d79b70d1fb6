#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Usage: wheel_test.sh ROOT [PYTHON [NAME=VALUE...]]. Makes a wheel and the archive of the tool (scripts/wheel.sh). From
# the wheel, a clean environment of PYTHON has the first images of a run within a minute. Then it runs the tests that
# need no tool there, and the tool of the archive. Exit status 77: PyPI cannot be reached.
set -euo pipefail
root=$1
python=${2:-/usr/bin/python3}
tests=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
largest_bytes=$((20 * 1024 * 1024))
longest_s=60

# in the tree, so that ccache finds the objects
mkdir -p "$root/build"
folder=$(mktemp -d "$root/build/wheel-test-XXXXXX")
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }

began=$SECONDS
"$root/scripts/wheel.sh" "$folder/made" "$python" "${@:3}"
echo "built within $((SECONDS - began)) s"
for file in "$folder"/made/*; do
  [ "$(stat -c %s "$file")" -le "$largest_bytes" ] || fail "$(basename "$file") is larger than $largest_bytes bytes"
done

cd "$folder"
began=$SECONDS
"$python" -m venv user
user/bin/pip --disable-pip-version-check install --quiet made/stereogrid-*.whl
env -i PATH="$folder/user/bin:/usr/bin:/bin" stereogrid run scene:crossing --pictures --out run >/dev/null
took_s=$((SECONDS - began))
pictures=$(find run/pictures -type f | wc -l)
echo "from the wheel to $pictures pictures: $took_s s"
[ "$pictures" -gt 0 ] || fail "no pictures"
[ "$took_s" -le "$longest_s" ] || fail "a new user waits for more than $longest_s s"

mkdir archive
tar --extract --directory archive --strip-components=1 --file made/stereogrid-*.tar.xz
env -i archive/bin/stereogrid run 'scene:street?frames=3' --out archive/run >/dev/null
outside=$(env -i ldd archive/bin/stereogrid | grep -v "$folder/archive/\|linux-vdso\|/ld-linux\|/lib[cm]\.so\|/lib\(dl\|rt\|pthread\)\.so" || true)
[ -z "$outside" ] || fail "the archive's tool needs libraries of the system: $outside"

user/bin/pip --disable-pip-version-check install --quiet pytest hypothesis
cp -r "$tests" tests
user/bin/python -m pytest -q -m "not tool" -p no:cacheprovider tests
