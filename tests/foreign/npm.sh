# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# For the run.sh of each folder beside this file: what a test with packages of npm needs.

# Exit status 77, which ctest counts as skipped.
skip() {
  echo "SKIPPED: $1"
  exit 77
}

# install_packages HERE FOLDER: those of HERE's package-lock.json in FOLDER/node_modules, once. Skips where they cannot
# be had.
install_packages() {
  command -v node >/dev/null && command -v npm >/dev/null || skip "there is no node, or no npm"
  mkdir -p "$2"
  cp "$1/package.json" "$2/"
  if ! cmp -s "$1/package-lock.json" "$2/node_modules/installed.json"; then
    cp "$1/package-lock.json" "$2/"
    (cd "$2" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error) || skip "the packages cannot be had"
    cp "$1/package-lock.json" "$2/node_modules/installed.json"
  fi
}
