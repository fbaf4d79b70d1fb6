// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace stereogrid::app::batch {

/// Every combination of the values of "key=a,b,c" (values that hold commas themselves: "key=a,b|c,d"), as lists of
/// "key=value", the last key's values changing first. None given: one empty list. Throws ConfigError.
[[nodiscard]] std::vector<std::vector<std::string>> combinations(const std::vector<std::string>& sweeps);

}  // namespace stereogrid::app::batch
