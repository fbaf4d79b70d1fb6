// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace stereogrid::test {

/// True if this program can count its allocations: with glibc, and without a sanitizer, which replaces malloc.
bool can_count_allocations();

/// Bytes that this program has allocated and not freed, in all its threads.
std::ptrdiff_t live_bytes();

/// Allocations between two calls, in all threads: malloc and its relatives, and `new` with them. Those of oneTBB are
/// separate: libtbb is the first module above malloc outside the C and C++ libraries.
struct Allocations {
  int count{0};
  int of_tbb{0};                   ///< not in `count`
  std::size_t bytes{0};            ///< bytes of `count`
  std::vector<std::string> where;  ///< callers without duplicates: program or library + offset, for addr2line
};

void start_counting();
Allocations stop_counting();

}  // namespace stereogrid::test
