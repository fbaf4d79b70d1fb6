// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/cli_fwd.hpp"
#include "device_options.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

void add_device_options(CLI::App& command, DeviceOptions& options);

/// `pipeline`: all but back end and threads. Logs the choice of a GPU. Throws ConfigError, DeviceError.
[[nodiscard]] Pipeline start_pipeline(const Config& config, const Rig& rig, const DeviceOptions& options,
                                      PipelineOptions pipeline);

}  // namespace stereogrid::app
