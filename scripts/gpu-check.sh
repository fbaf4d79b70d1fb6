#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds the CUDA part alone, tests it on this machine's GPU, measures its speed, and searches for errors with
# compute-sanitizer. Needs nvcc, CMake, g++ and Python, no other package; takes Ninja where it is.
#
#   scripts/gpu-check.sh [--steps build,test,bench,sanitize] [--report DIR] [--limit SECONDS] [--total SECONDS]
#                        [--tool memcheck] [--architectures "75;80;90"] [--frames 100] [--jobs N] [--werror]
#
# --steps: in this order, whichever are named; build/gpu is kept between calls. --report (build/gpu-report): what the
# steps have found, written anew after each of them: report.json, resources.txt and a log of each check,
# packed into DIR.tar.gz. --limit (300): for each check. --total (600): after this time no further check begins; those
# left out are listed. --tool: of compute-sanitizer; without it all four. --architectures: without it those in CUDAARCHS,
# else this machine's.
# Exit status 0: all that has run passed; 1: something failed; 64: wrong usage; 77: all that needs no GPU passed, but there is none.
set -euo pipefail
cd "$(dirname "$0")/.."

steps=build,test,bench,sanitize
report=build/gpu-report
limit=300
total=600
tools="memcheck racecheck initcheck synccheck"
architectures=${CUDAARCHS:-}
frames=100
jobs=$(nproc)
werror=OFF
usage() {
  echo "$1 See the head of $0." >&2
  exit 64
}
while [ $# -gt 0 ]; do
  [ "$1" = --werror ] || [ $# -gt 1 ] || usage "Not understood: $*."
  case $1 in
    --steps) steps=$2 ;;
    --report) report=$2 ;;
    --limit) limit=$2 ;;
    --total) total=$2 ;;
    --tool) tools=$2 ;;
    --architectures) architectures=$2 ;;
    --frames) frames=$2 ;;
    --jobs) jobs=$2 ;;
    --werror) werror=ON; shift; continue ;;
    *) usage "Not understood: $*." ;;
  esac
  shift 2
done
for step in ${steps//,/ }; do
  [[ $step =~ ^(build|test|bench|sanitize)$ ]] || usage "--steps: $step is none of build, test, bench, sanitize."
done
for seconds in "$limit" "$total"; do
  [[ $seconds =~ ^[1-9][0-9]*$ ]] || usage "--limit, --total: $seconds is not a number of seconds."
done

build=build/gpu
status=0
mkdir -p "$report"
wanted() { [[ ,$steps, == *,$1,* ]]; }

# Records the result of a check in results.tsv.
remember() { # remember NAME RESULT
  touch "$report/results.tsv"
  { grep -v "^$1	" "$report/results.tsv" || true; printf '%s\t%s\n' "$1" "$2"; } | sort >"$report/results.new"
  mv "$report/results.new" "$report/results.tsv"
}

check() { # check NAME COMMAND…
  local name=$1 code=0 result
  shift
  if [ "$SECONDS" -ge "$total" ]; then
    printf '%-32s left out: %s s are over\n' "$name" "$total"
    remember "$name" "left out"
    return
  fi
  timeout -k 10 "$limit" "$@" >"$report/$name.log" 2>&1 || code=$?
  case $code in
    0) result=passed ;;
    77) result="no device" ;;
    124 | 137) result="failed: not done after $limit s" ;;
    *) result="failed: $code" ;;
  esac
  [[ $result != failed* ]] || status=1
  printf '%-32s %s\n' "$name" "$result"
  remember "$name" "$result"
  [ "$code" -eq 0 ] || [ "$code" -eq 77 ] || tail -20 "$report/$name.log"
}

# So that a machine that goes away in the middle leaves what it has found.
write_report() {
  python3 scripts/gpu_report.py join "$report" >"$report/report.new"
  mv "$report/report.new" "$report/report.json"
  tar -C "$(dirname "$report")" -czf "$report.tar.gz" "$(basename "$report")"
}

build_step() {
  echo "== Build"
  export PATH=$PATH:/usr/local/cuda/bin
  if ! command -v nvcc >/dev/null; then
    echo "nvcc is missing, in PATH and in /usr/local/cuda/bin: nothing was checked. Install NVIDIA's CUDA toolkit." >&2
    exit 1
  fi
  if [ -z "$architectures" ]; then
    architectures=$(nvidia-smi --query-gpu=compute_cap --format=csv,noheader 2>/dev/null | head -1 | tr -d . || true)
    if ! [[ $architectures =~ ^[0-9]+$ ]]; then
      architectures="75;80;90"
      [ "$(uname -m)" != aarch64 ] || architectures=87 # a Jetson Orin may have no nvidia-smi
      echo "nvidia-smi finds no GPU: building for $architectures (--architectures names others)."
    fi
  fi
  local generator=()
  command -v ninja >/dev/null && generator=(-G Ninja)
  rm -rf "$build" # the compiler says what a kernel needs only when it compiles it
  cmake -S . -B "$build" "${generator[@]}" -DSTEREOGRID_GPU_ONLY=ON -DSTEREOGRID_WERROR=$werror \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_CUDA_ARCHITECTURES="$architectures" -DCMAKE_CUDA_FLAGS=-Xptxas=-v \
    >"$report/configure.log" 2>&1 || { tail -40 "$report/configure.log"; exit 1; }
  if ! cmake --build "$build" -j "$jobs" >"$report/build.log" 2>&1; then
    tail -40 "$report/build.log"
    remember build failed
    write_report
    exit 1
  fi
  remember build passed
  echo "for $architectures"
  python3 scripts/gpu_report.py resources "$report/build.log" >"$report/resources.txt"
}

test_step() {
  echo "== Tests"
  local test name
  for test in "$build"/bin/stereogrid_cuda_*_test; do
    name=$(basename "$test")
    check "${name#stereogrid_cuda_}" "$test"
  done
}

bench_step() {
  echo "== Speed"
  check bench "$build/bin/bench_gpu" "$frames"
  [ ! -e "$report/bench.log" ] || cat "$report/bench.log"
}

sanitize_step() {
  echo "== compute-sanitizer"
  export PATH=$PATH:/usr/local/cuda/bin
  if ! command -v compute-sanitizer >/dev/null; then
    echo "It is not installed: left out."
    return
  fi
  local tool test name
  for tool in $tools; do
    for test in "$build"/bin/stereogrid_cuda_*_test; do
      name=$(basename "$test")
      # the tests ask for what the device must refuse: that is no error
      check "$tool.${name#stereogrid_cuda_}" compute-sanitizer --tool "$tool" --report-api-errors no --error-exitcode 9 "$test"
    done
    write_report
  done
}

for step in build test bench sanitize; do
  wanted "$step" || continue
  if [ "$step" != build ] && [ ! -x "$build/bin/bench_gpu" ]; then
    echo "$build has not been built: begin with --steps build." >&2
    exit 1
  fi
  "${step}_step"
  write_report
done

echo "== $report/report.json and $report.tar.gz"
if grep -q 'left out' "$report/results.tsv"; then
  echo "Checks were left out, as --total $total was over. Repeat with --steps sanitize --total 3600."
fi
if [ "$status" -eq 0 ] && grep -q 'no device' "$report/results.tsv"; then
  echo "NO GPU: nothing has run on a device. The reason:"
  grep -h '^SKIPPED\|^Nothing was measured' "$report"/*.log | sort -u || true
  exit 77
fi
exit "$status"
