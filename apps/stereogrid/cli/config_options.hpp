// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "device_options.hpp"
#include "preset_choice.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/pipeline.hpp"

namespace stereogrid::app {

class Command;

/// Sources of parameters, in ascending priority: preset, file, --set.
struct ConfigOptions {
  std::string preset{"default"};
  std::string file;
  std::vector<std::string> settings;  ///< "key=value"
};

void add_config_options(Command command, ConfigOptions& options);

/// The preset "auto" counts as "default" until resolve_preset() replaces it. Throws ConfigError, InputError.
[[nodiscard]] Config config_from(const ConfigOptions& options);

/// Replaces the preset "auto" by the chosen one, logs it and returns the configuration with it. `choose` is called
/// for "auto" only. Throws ConfigError, InputError.
[[nodiscard]] Config resolve_preset(ConfigOptions& options, const std::function<PresetChoice()>& choose);

/// Inputs of a pipeline that decide which parameters are read.
struct InputUse {
  bool has_disparities{false};  ///< instead of right images
  bool is_fused{false};         ///< with grids of another source
};

/// Condition under which the parameter `key` would be read, where it is not; empty: it is read.
[[nodiscard]] std::string why_unread(const Config& config, std::string_view key, const InputUse& input);

/// Warns of each --set of a parameter that is not read.
void warn_of_unread(const ConfigOptions& options, const Config& config, const InputUse& input);

void add_device_options(Command command, DeviceOptions& options);

/// `pipeline`: all but back end and threads. Logs the choice of a GPU. Throws ConfigError, DeviceError.
[[nodiscard]] Pipeline start_pipeline(const Config& config, std::span<const Rig> rigs, const DeviceOptions& options,
                                      PipelineOptions pipeline);

}  // namespace stereogrid::app
