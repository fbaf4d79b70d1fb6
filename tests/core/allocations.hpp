// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace stereogrid::test {

/// Can this program count what it allocates? Not under a sanitizer, which brings its own malloc, and with glibc only.
bool can_count_allocations();

/// Bytes that this program has allocated and not freed, in all its threads.
std::ptrdiff_t live_bytes();

/// What has been allocated between two calls, in all threads: malloc and its relatives, `new` included, as it is made
/// of them. oneTBB's are told apart by who called: whichever comes first on the way up from malloc, code of libtbb or
/// other code than the C and C++ libraries'.
struct Allocations {
  int count{0};
  int of_tbb{0};                   ///< not in `count`
  std::size_t bytes{0};            ///< of `count`
  std::vector<std::string> where;  ///< who made them, each once: program or library + offset, for addr2line
};

void start_counting();
Allocations stop_counting();

}  // namespace stereogrid::test
