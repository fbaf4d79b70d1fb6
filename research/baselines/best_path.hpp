// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/image.hpp"

namespace stereogrid::research {

/// One state per column, by dynamic programming: the least sum of costs(column, state) and, between neighbours,
/// jump_cost·min(|difference of states|, jump_max). `costs` is (states, columns).
[[nodiscard]] std::vector<int> best_path(const Image<float>& costs, double jump_cost, int jump_max);

}  // namespace stereogrid::research
