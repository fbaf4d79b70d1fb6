// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "device.hpp"

namespace emulator {

/// Bits of unwritten words: as a float NaN, as an integer too large for an index.
inline constexpr std::uint32_t unwritten{0x7fe500a5U};
void fill_unwritten(void* memory, std::size_t bytes, std::uint32_t word);

/// Calls `kernel` once for every thread of the grid. Aborts with a message where threads wait for each other forever.
void run_grid(dim3 grid, dim3 threads, std::size_t shared_bytes, const std::function<void()>& kernel, bool backwards);

}  // namespace emulator
