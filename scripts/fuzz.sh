#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Usage: scripts/fuzz.sh [SECONDS [NAME…]]
#
# Gives every fuzzer (or those named; tests/fuzz/CMakeLists.txt lists them) its share of SECONDS, an hour by default, as many at
# a time as there are processors; the pipeline's gets two shares. An input that takes 10 s or 2 GB is a finding. Continues
# from the last run's corpus in build/fuzz/corpus. Findings go to build/fuzz/findings; exit status 1 where there are any.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
total_s=${1:-3600}
shift || true
[[ $total_s =~ ^[1-9][0-9]*$ ]] || { echo "Usage: scripts/fuzz.sh [SECONDS [NAME…]]" >&2; exit 64; }
names=("$@")
python3 tests/fuzz/seeds.py build/fuzz/seeds
[ ${#names[@]} -gt 0 ] || mapfile -t names < <(ls build/fuzz/seeds)
for name in "${names[@]}"; do
  [ -d "build/fuzz/seeds/$name" ] || { echo "There is no fuzzer $name. There are:" $(ls build/fuzz/seeds) >&2; exit 64; }
done

[ -f build/fuzz/build.ninja ] || cmake --preset fuzz --log-level=WARNING
cmake --build build/fuzz --target stereogrid_fuzzer

# inputs become files: many a second, best in memory
memory=/dev/shm
[ -w "$memory" ] || memory=${TMPDIR:-/tmp}
TMPDIR=$(mktemp -d "$memory/stereogrid-fuzz-XXXXXX")
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1

jobs=$(nproc)
shares=${#names[@]}
[[ " ${names[*]} " != *" pipeline "* ]] || shares=$((shares + 1))
[ "$jobs" -le "$shares" ] || jobs=$shares
export share_s=$(((total_s * jobs + shares - 1) / shares))
mkdir -p build/fuzz/findings
rm -f build/fuzz/findings/*

# words of its seeds, and the parameters
dictionary() { # dictionary NAME
  cat tests/fuzz/common.dict
  {
    LC_ALL=C grep -rahoE '[A-Za-z_][A-Za-z0-9_./]{1,40}[:=]?' "build/fuzz/seeds/$1"
    [[ $1 != @(config_yaml|settings) ]] ||
      awk -F'`' '/^## / { group = substr($0, 4) } /^\| `/ { print group "." $2 }' docs/config.md
  } | sort -u | sed 's/.*/"&"/'
}

fuzz() { # fuzz NAME
  local name=$1 seconds=$share_s log=build/fuzz/findings/$1.log status=0
  [ "$name" != pipeline ] || seconds=$((2 * share_s))
  mkdir -p "build/fuzz/corpus/$name"
  dictionary "$name" >"build/fuzz/corpus/$name.dict"
  STEREOGRID_FUZZ_TARGET=$name build/fuzz/bin/stereogrid_fuzzer -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="build/fuzz/findings/$name-" -dict="build/fuzz/corpus/$name.dict" "build/fuzz/corpus/$name" "build/fuzz/seeds/$name" >"$log" 2>&1 || status=$?
  local executions coverage
  executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  coverage=$(grep -oE 'cov: [0-9]+ ft: [0-9]+ corp: [0-9]+' "$log" | tail -1)
  printf '%-18s %5d s  %9s tries  %s%s\n' "$name" "$seconds" "${executions:-?}" "$coverage" \
    "$([ $status -eq 0 ] || echo '  FINDING')"
  [ $status -eq 0 ] || return 1
  rm "$log"
}
export -f dictionary fuzz

found=0
printf '%s\0' "${names[@]}" | xargs -0 -n 1 -P "$jobs" bash -c 'fuzz "$1"' fuzz || found=1
[ $found -eq 1 ] || exit 0

for log in build/fuzz/findings/*.log; do
  name=$(basename "$log" .log)
  printf '\n== %s (%s)\n' "$name" "$log"
  grep -aE -m 3 'what\(\)|ERROR:|runtime error:' "$log" || tail -n 5 "$log"
  for input in build/fuzz/findings/"$name"-*; do
    echo "Again: STEREOGRID_FUZZ_TARGET=$name build/fuzz/bin/stereogrid_fuzzer $input"
  done
done
echo
echo "Correct it, and keep the input: tests/fuzz/seeds.py --add NAME WHAT FILE. The replay (ctest -R fuzz) runs it from then on."
exit 1
