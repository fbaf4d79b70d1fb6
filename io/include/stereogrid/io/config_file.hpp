// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "stereogrid/config.hpp"
#include "stereogrid/export.hpp"

namespace stereogrid::io {

/// Sets every parameter that a YAML file names, as nested groups (grid: {length_m: 30}) or dotted keys
/// (grid.length_m: 30). Throws ConfigError naming file and line: no YAML, unknown key, text that is no value;
/// InputError where the file cannot be read.
STEREOGRID_EXPORT void load_config(const std::filesystem::path& path, Config& config);

/// {"grid": {"length_m": 20.0, …}, …}, numbers as numbers, choices as strings. `indent` < 0: one line.
[[nodiscard]] STEREOGRID_EXPORT std::string to_json(const Config& config, int indent = -1);

/// YAML that load_config reads, with unit, range and sentence of each parameter in a comment.
[[nodiscard]] STEREOGRID_EXPORT std::string to_yaml(const Config& config);

}  // namespace stereogrid::io
