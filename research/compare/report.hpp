// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "compare/compare.hpp"

namespace stereogrid::research {

/// A line per method, 3–20 m.
void print_table(const Comparison& comparison);

/// JSON of the evaluations, with each method's title and time. `about`: see Evaluation.
[[nodiscard]] nlohmann::ordered_json json_of(const Comparison& comparison,
                                             const std::vector<std::pair<std::string, std::string>>& about);

}  // namespace stereogrid::research
