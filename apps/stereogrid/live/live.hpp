// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "cli/config_options.hpp"
#include "connect/message_output.hpp"
#include "connect/page.hpp"
#include "live/live_input.hpp"
#include "start_pipeline.hpp"

namespace stereogrid::app {

struct LiveOptions {
  LiveInputOptions input;
  ConfigOptions config;
  DeviceOptions device;
  std::vector<double> predict_s;
  MessageOptions messages;
  PageOptions page;
};

/// `stereogrid live`. Returns the exit code; throws ConfigError, InputError, DeviceError.
[[nodiscard]] int live(const LiveOptions& options);

}  // namespace stereogrid::app
