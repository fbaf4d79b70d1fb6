// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "batch/variants.hpp"

#include <fmt/format.h>

#include "batch/sweep.hpp"
#include "stereogrid/io/config_file.hpp"

namespace stereogrid::app::batch {
namespace {

/// "key=value" of all parameters that are not as the preset has them.
std::vector<std::string> settings_of(const Config& config, const std::string& preset_name) {
  const Config standard{preset(preset_name)};
  std::vector<std::string> settings;
  visit_parameters(config, [&](std::string_view group, const Parameter& parameter, const auto&) {
    const std::string key{fmt::format("{}.{}", group, parameter.name)};
    if (get(config, key) != get(standard, key)) settings.push_back(fmt::format("{}={}", key, get(config, key)));
  });
  return settings;
}

}  // namespace

std::vector<Variant> variants_of(const ConfigOptions& options, const std::vector<std::string>& sweeps) {
  std::vector<Variant> variants;
  for (const std::vector<std::string>& swept : combinations(sweeps)) {
    ConfigOptions with_swept{options};
    with_swept.settings.insert(with_swept.settings.end(), swept.begin(), swept.end());
    const Config config{config_from(with_swept)};
    variants.push_back({swept, settings_of(config, with_swept.preset), Json::parse(io::to_json(config))});
  }
  return variants;
}

}  // namespace stereogrid::app::batch
