// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <string>
#include <string_view>

#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Device and threads, as set by the user.
struct DeviceOptions {
  std::string device{"auto"};
  bool is_explicit{false};  ///< by the user: a choice of "auto" is reported
  int threads{0};
};

/// Why a text is no DeviceOptions::device; empty: it is one.
[[nodiscard]] std::string device_problem(const std::string& device);

/// Sets back end, device and threads. `options.device` must be without problem.
void set_device(PipelineOptions& pipeline, const DeviceOptions& options);

/// As --device has it.
[[nodiscard]] std::string_view name_of(BackEnd back_end);

/// Message where the system has not started a thread, of the standard library or of oneTBB in OpenCV; empty: another
/// failure.
[[nodiscard]] std::string thread_failure(const std::exception& error);

}  // namespace stereogrid::app
