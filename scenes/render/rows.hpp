// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_for.h>

#include <stdexcept>
#include <string>
#include <typeinfo>

#include "stereogrid/error.hpp"

namespace stereogrid::scenes {

/// Calls work(row) for `count` rows, on all cores. Throws DeviceError where a thread cannot be started: oneTBB throws a
/// plain std::runtime_error then.
template <class Work>
void for_rows(int count, const Work& work) {
  try {
    tbb::parallel_for(0, count, work);
  } catch (const std::runtime_error& error) {
    if (typeid(error) != typeid(std::runtime_error)) throw;
    throw DeviceError{std::string{"a thread cannot be started: "} + error.what() +
                      ". Allow more threads or address space (ulimit -u, ulimit -v, the container's limits)."};
  }
}

}  // namespace stereogrid::scenes
