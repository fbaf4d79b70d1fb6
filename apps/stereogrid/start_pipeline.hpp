// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "cli/cli_fwd.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

/// Where the work is done, as the user says.
struct DeviceOptions {
  std::string device{"auto"};
  int threads{0};
};

void add_device_options(CLI::App& command, DeviceOptions& options);

/// `pipeline`: all but back end and threads. Tells the log about a GPU. Throws ConfigError, DeviceError.
[[nodiscard]] Pipeline start_pipeline(const Config& config, const Rig& rig, const DeviceOptions& options,
                                      PipelineOptions pipeline);

/// As --device has it.
[[nodiscard]] std::string_view name_of(BackEnd back_end);

}  // namespace stereogrid::app
