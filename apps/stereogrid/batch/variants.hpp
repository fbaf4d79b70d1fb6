// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "batch/plan.hpp"
#include "config_options.hpp"

namespace stereogrid::app::batch {

/// The configurations of a plan: all combinations of the sweeps ("key=a,b,c"); without any, the one. Throws
/// ConfigError.
[[nodiscard]] std::vector<Variant> variants_of(const ConfigOptions& options, const std::vector<std::string>& sweeps);

}  // namespace stereogrid::app::batch
