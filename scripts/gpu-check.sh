#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds the CUDA part alone, tests it on this machine's GPU, looks for errors with compute-sanitizer, measures its speed,
# and lists what every kernel needs. Needs nvcc, CMake, g++ and Python, no other package. Everything is left in
# build/gpu/report: report.json, bench.json, resources.txt and a log of each step.
# Exit status 0: all passed; 1: something failed; 77: all that needs no GPU passed, but there is none.
#
#   scripts/gpu-check.sh [--architectures "75;80;90"] [--frames 500] [--jobs N]
set -euo pipefail
cd "$(dirname "$0")/.."

architectures=
frames=500
jobs=$(nproc)
while [ $# -gt 1 ]; do
  case $1 in
    --architectures) architectures=$2 ;;
    --frames) frames=$2 ;;
    --jobs) jobs=$2 ;;
    *) break ;;
  esac
  shift 2
done
if [ $# -gt 0 ]; then
  echo "Not understood: $*. See the head of $0." >&2
  exit 64
fi

export PATH=$PATH:/usr/local/cuda/bin
if ! command -v nvcc >/dev/null; then
  echo "nvcc is missing, in PATH and in /usr/local/cuda/bin: nothing was checked. Install NVIDIA's CUDA toolkit." >&2
  exit 1
fi
if [ -z "$architectures" ]; then # this machine's, or all where it has no GPU
  architectures=$(nvidia-smi --query-gpu=compute_cap --format=csv,noheader 2>/dev/null | head -1 | tr -d . || true)
  [[ $architectures =~ ^[0-9]+$ ]] || architectures="75;80;90"
fi

build=build/gpu
report=$build/report
rm -rf "$build" # the compiler says what a kernel needs only when it compiles it
mkdir -p "$report"

echo "== Build for $architectures"
cmake -S . -B "$build" -DSTEREOGRID_GPU_ONLY=ON -DSTEREOGRID_WERROR=ON -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CUDA_ARCHITECTURES="$architectures" -DCMAKE_CUDA_FLAGS=-Xptxas=-v >"$report/configure.log"
cmake --build "$build" -j "$jobs" >"$report/build.log" 2>&1 || { tail -40 "$report/build.log"; exit 1; }

echo "== What kernels need"
python3 scripts/gpu_report.py resources "$report/build.log" | tee "$report/resources.txt"

status=0
declare -A result
check() { # check NAME COMMAND…: remembers how it ended
  local name=$1 code=0
  shift
  "$@" >"$report/$name.log" 2>&1 || code=$?
  case $code in
    0) result[$name]=passed ;;
    77) result[$name]="no device" ;;
    *) result[$name]=failed; status=1 ;;
  esac
  printf '%-32s %s\n' "$name" "${result[$name]}"
  [ "$code" -eq 0 ] || [ "$code" -eq 77 ] || tail -20 "$report/$name.log"
}

echo "== Tests"
for test in "$build"/bin/stereogrid_cuda_*_test; do
  name=$(basename "$test")
  check "${name#stereogrid_cuda_}" "$test"
done

echo "== compute-sanitizer"
if command -v compute-sanitizer >/dev/null; then
  for tool in memcheck racecheck initcheck synccheck; do
    for test in "$build"/bin/stereogrid_cuda_*_test; do
      name=$(basename "$test")
      # the tests ask for what the device must refuse: that is no error
      check "$tool.${name#stereogrid_cuda_}" compute-sanitizer --tool "$tool" --report-api-errors no --error-exitcode 9 "$test"
    done
  done
else
  echo "compute-sanitizer is not installed: left out"
fi

echo "== Speed"
check bench "$build/bin/bench_gpu" "$report/bench.json" "$frames"
cat "$report/bench.log"

for name in "${!result[@]}"; do printf '%s\t%s\n' "$name" "${result[$name]}"; done | sort >"$report/results.tsv"
python3 scripts/gpu_report.py join "$report" >"$report/report.json"
echo "== $report/report.json"
if [ "$status" -eq 0 ] && grep -q 'no device' "$report/results.tsv"; then
  echo "There is no GPU on this machine that can be used: nothing has run on one."
  exit 77
fi
exit "$status"
