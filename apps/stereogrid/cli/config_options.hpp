// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cli/cli_fwd.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid::app {

/// Sources of parameters, in ascending priority: preset, file, --set.
struct ConfigOptions {
  std::string preset{"default"};
  std::string file;
  std::vector<std::string> settings;  ///< "key=value"
};

void add_config_options(CLI::App& command, ConfigOptions& options);

/// Throws ConfigError, InputError.
[[nodiscard]] Config config_from(const ConfigOptions& options);

}  // namespace stereogrid::app
