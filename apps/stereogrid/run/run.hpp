// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cli/config_options.hpp"
#include "connect/message_output.hpp"
#include "connect/page.hpp"
#include "input.hpp"

namespace stereogrid::app {

struct RunOptions {
  InputOptions input;
  std::string folder;
  ConfigOptions config;
  std::string fuse{"none"};
  std::vector<double> predict_s;
  std::string frames;
  int warm_up{0};
  DeviceOptions device;
  bool compact{false};
  std::size_t every{1};
  std::vector<std::string> layers;  ///< none: all
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

/// --layers as the files call them, in their order, each once. Throws ConfigError: there is no such layer.
[[nodiscard]] std::vector<std::string> layers_of(const RunOptions& options);

/// `stereogrid run`. Returns the exit code; throws ConfigError, InputError, DeviceError.
[[nodiscard]] int run(const RunOptions& options);

}  // namespace stereogrid::app
