#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# bare-debian.sh [COMMAND]: runs the README's commands, or COMMAND, in a bare Debian 12: debootstrap's minimal system, with the
# commit that is checked out in root's home of mode 700. Needs root, debootstrap and about 10 GB; takes an hour or two.
# Environment:
#   MIRROR       Debian mirror (default: that of this machine's apt sources)
#   BARE_SYSTEM  folder for the system, which must not exist (default: a temporary folder); it is removed at the end
#   CCACHE_DIR   folder of ccache to share with the system (default: none); other CCACHE_* variables are passed on
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
suite=bookworm

# In namespaces of its own: every mount and process is gone before the folder is removed.
if [ "${1:-}" = --inside ]; then
  system=$2
  mount -t proc proc "$system/proc"
  mount -t sysfs -o ro sysfs "$system/sys"
  mount --rbind /dev "$system/dev"
  variables=(LANG=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
  if [ -n "${CCACHE_DIR:-}" ]; then
    mount --bind "$CCACHE_DIR" "$system/ccache"
    mapfile -t shared < <(env | grep '^CCACHE_')
    variables+=("${shared[@]}" CCACHE_DIR=/ccache)
  fi
  exec env -i "${variables[@]}" chroot "$system" bash -ec "export HOME=~; cd ~/stereogrid; $3"
fi

command=${1:-./demo.sh; ./test.sh}
[ "$(id -u)" -eq 0 ] || { echo "Run as root: a system cannot be set up otherwise." >&2; exit 2; }
command -v debootstrap >/dev/null || { echo "debootstrap is missing: apt-get install debootstrap" >&2; exit 2; }
mirror=${MIRROR:-$(apt-get indextargets --format "\$(REPO_URI)" "Codename: $suite" "Component: main" | sed -n 1p)}
[ -n "$mirror" ] || { echo "This machine's apt sources have no $suite: name a mirror, MIRROR=…" >&2; exit 2; }
parent=$(mktemp -d "${TMPDIR:-/var/tmp}/bare-debian-XXXXXX")
system=${BARE_SYSTEM:-$parent/system}
[ ! -e "$system" ] || { echo "$system exists already: name another folder, BARE_SYSTEM=…" >&2; exit 2; }
trap 'rm -rf --one-file-system "$system" "$parent"' EXIT
mkdir -p "$system"

# debootstrap's own mounts end with it, too
unshare --mount debootstrap --variant=minbase "$suite" "$system" "$mirror" >"$parent/log" || { tail "$parent/log" >&2; exit 2; }
cp /etc/resolv.conf /etc/hosts "$system/etc/"
apt-config dump | grep -i '^Acquire::.*proxy' >"$system/etc/apt/apt.conf.d/90proxy" || true
mkdir "$system/ccache"
home=$system$(awk -F: '$1 == "root" {print $6}' "$system/etc/passwd")
chmod 700 "$home"
git -c safe.directory="*" clone --quiet --no-hardlinks "$project" "$home/stereogrid"

unshare --mount --pid --fork --kill-child bash "${BASH_SOURCE[0]}" --inside "$system" "$command"
echo "Passed on a bare Debian 12: $command"
