// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "cli/config_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "stereogrid/error.hpp"
#include "stereogrid/io/config_file.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::app {

void add_config_options(CLI::App& command, ConfigOptions& options) {
  command.add_option("--preset", options.preset, "Preset: default, robot, or paper (as published).")
      ->type_name("NAME")
      ->capture_default_str();
  command.add_option("--config", options.file, "YAML file with parameters.")->type_name("FILE.yaml");
  command.add_option("--set", options.settings, "Value of a parameter, such as grid.length_m=30. May be repeated.")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

Config config_from(const ConfigOptions& options) {
  Config config{preset(options.preset)};
  if (!options.file.empty()) io::load_config(options.file, config);
  for (const std::string& given : options.settings) {
    const std::string setting{io::printable(given, std::string::npos)};  // a complaint may quote it
    const std::size_t equals{setting.find('=')};
    if (equals == std::string::npos) {
      throw ConfigError{fmt::format("--set {}: give KEY=VALUE, such as grid.length_m=30.", setting)};
    }
    set(config, setting.substr(0, equals), setting.substr(equals + 1));
  }
  return config;
}

}  // namespace stereogrid::app
