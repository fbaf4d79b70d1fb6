// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <typeinfo>

namespace stereogrid::app {

/// Message where the system has not started a thread, of the standard library or of oneTBB in OpenCV; empty: another
/// failure.
inline std::string thread_failure(const std::exception& error) {
  const auto* const of_system{dynamic_cast<const std::system_error*>(&error)};
  const bool is_of_standard{of_system != nullptr && of_system->code() == std::errc::resource_unavailable_try_again};
  const bool is_of_tbb{typeid(error) == typeid(std::runtime_error) &&
                       std::string_view{error.what()}.starts_with("pthread_create")};
  if (!is_of_standard && !is_of_tbb) return {};
  return std::string{"a thread cannot be started: "} + error.what() +
         ". Allow more threads or address space (ulimit -u, ulimit -v, the container's limits).";
}

}  // namespace stereogrid::app
