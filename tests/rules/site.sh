#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Usage: site.sh VENV [STEREOGRID]
#
# Builds the documentation site; every warning, such as a broken link, is an error. STEREOGRID makes the runs of
# the gallery. Exit status 77: mkdocs is missing.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
mkdocs=$1/bin/mkdocs
[ -x "$mkdocs" ] || mkdocs=$(command -v mkdocs) || { echo "mkdocs is missing: not tested. Run scripts/install-dependencies.sh --python." >&2; exit 77; }
site=$(mktemp -d)
trap 'rm -rf "$site"' EXIT
STEREOGRID=${2:-} NO_MKDOCS_2_WARNING=1 "$mkdocs" build --strict --config-file "$root/mkdocs.yml" --site-dir "$site"
[ -f "$site/constants/index.html" ]
# formulas, tabs and code of examples are made by scripts/mkdocs_hooks.py
grep -q '<math ' "$site/method/index.html"
grep -q tabbed-set "$site/index.html"
grep -q open_recording "$site/index.html"
for run in crossing corridor ditch; do
  [ -z "${2:-}" ] || [ -s "$site/gallery/$run/index.html" ]
done
[ -z "${2:-}" ] || [ ! -f "$root/build/playground/stereogrid.wasm" ] || [ -s "$site/gallery/playground/index.html" ]
