#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# packages.sh SOURCE WORK [CMAKE_OPTION...]: the Debian packages as users meet them: made twice with the same bytes, looked through by
# lintian, installed into a root of their own, used there, installed again and removed without a trace.
set -euo pipefail

source=$1
work=$2
options=("${@:3}")
skip=77
for program in dpkg-deb help2man fakeroot; do
  command -v $program >/dev/null || { echo "SKIPPED: there is no $program"; exit $skip; }
done
fail() { echo "FAILED: $*" >&2; exit 1; }

rm -rf "$work"
mkdir -p "$work"
for turn in first second; do
  "$source/scripts/package.sh" --debian "$work/$turn" "${options[@]}" >"$work/$turn.log" 2>&1 || { tail -20 "$work/$turn.log"; fail "$turn build"; }
done
(cd "$work/first/packages" && sha256sum ./*.deb) >"$work/sums"
(cd "$work/second/packages" && sha256sum --check --quiet "$work/sums") || fail "other bytes the second time"

packages=("$work"/first/packages/*.deb)
[ ${#packages[@]} -ge 4 ] || fail "only ${#packages[@]} packages"
if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error,warning "${packages[@]}" || fail "lintian"
else
  echo "lintian is not here: not looked through"
fi

root=$work/root
mkdir -p "$root"/var/lib/dpkg/{info,updates} "$root/etc"
touch "$root/var/lib/dpkg/status"
install_all() {
  fakeroot dpkg --root="$root" --force-depends --force-script-chrootless --force-not-root --log=/dev/null "$@"
}
install_all -i "${packages[@]}" >"$work/install.log" 2>&1 || { cat "$work/install.log"; fail "install"; }
export LD_LIBRARY_PATH=   # the tool finds its libraries by itself
"$root/usr/bin/stereogrid" --version || fail "the tool does not start"
"$root/usr/bin/stereogrid" run 'scene:street?frames=3' --out "$work/run" >/dev/null 2>&1 || fail "the tool does not run"
for page in stereogrid stereogrid-run stereogrid-live; do
  [ -s "$root/usr/share/man/man1/$page.1.gz" ] || fail "no manual page $page"
done
zcat "$root/usr/share/man/man1/stereogrid-run.1.gz" | grep -qF '\-\-mcap' || fail "the manual page has no options"
PATH=$root/usr/bin:$PATH bash -c "source '$root/usr/share/bash-completion/completions/stereogrid'
  COMP_WORDS=(stereogrid si) COMP_CWORD=1 COMP_LINE='stereogrid si' COMP_POINT=13; _stereogrid
  [ \"\${COMPREPLY[*]}\" = simulate ]" ||
  fail "completion"

cmake -S "$source/tests/install/consumer" -B "$work/consumer" -G Ninja -DCMAKE_PREFIX_PATH="$root/usr" \
  -DCOMPONENTS=core,io,messages,mcap >"$work/consumer.log" 2>&1 && cmake --build "$work/consumer" >>"$work/consumer.log" 2>&1 ||
  { tail -20 "$work/consumer.log"; fail "a program that links the package"; }

install_all -i "${packages[@]}" >"$work/again.log" 2>&1 || { cat "$work/again.log"; fail "install again"; }
mapfile -t names < <(for package in "${packages[@]}"; do dpkg-deb -f "$package" Package; done)
install_all -P "${names[@]}" >"$work/remove.log" 2>&1 || { cat "$work/remove.log"; fail "remove"; }
left=$(find "$root" -not -path "$root/var/lib/dpkg*" -not -type d)
[ -z "$left" ] || fail "left behind: $left"
ls -l "$work/first/packages"
