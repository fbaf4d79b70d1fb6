#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# All tests, the slow ones too, under the address and undefined-behaviour sanitizers, then under the thread sanitizer.
# Takes the better part of an hour on two cores. Arguments go to ctest, e.g. scripts/sanitizers.sh -R chain
#
# Under the thread sanitizer loops run on the threads of tests/tbb.hpp, since oneTBB is not instrumented.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1
export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
export TSAN_OPTIONS=suppressions=$root/tests/io/tsan.supp:second_deadlock_stack=1
failed=0
for preset in asan tsan; do
  cmake --preset "$preset" --log-level=WARNING
  cmake --build "build/$preset"
  ctest --test-dir "build/$preset" --parallel 2 --output-on-failure --no-tests=error "$@" || failed=1
done
exit $failed
