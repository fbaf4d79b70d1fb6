// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "config_options.hpp"
#include "connect/message_output.hpp"
#include "connect/page.hpp"
#include "input.hpp"
#include "start_pipeline.hpp"
#include "sweeps.hpp"

namespace stereogrid::app {

struct RunOptions {
  InputOptions input;
  std::string folder;
  ConfigOptions config;
  std::string matcher{"own"};
  std::string fuse{"none"};
  Rings fuse_rings{Rings::all};
  std::vector<double> predict_s;
  std::string frames;
  DeviceOptions device;
  bool save_stages{false};
  bool pictures{false};
  std::string video;
  MessageOptions messages;
  bool view{false};
  PageOptions page;
  bool resume{false};
  int checkpoint_every{100};
  int input_wait_s{300};
};

/// `stereogrid run`. Returns the exit code; throws ConfigError, InputError, DeviceError.
[[nodiscard]] int run(const RunOptions& options);

}  // namespace stereogrid::app
