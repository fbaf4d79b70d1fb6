// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "device.hpp"

namespace emulator {

/// Calls `kernel` once for every thread of the grid. Aborts with a message where threads wait for each other forever.
void run_grid(dim3 grid, dim3 threads, std::size_t shared_bytes, const std::function<void()>& kernel, bool backwards);

}  // namespace emulator
