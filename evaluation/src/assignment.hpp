// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace stereogrid::evaluation {

/// For each row the column it is given, each column once, so that the sum of costs [row][column] is the least
/// (Hungarian method, O(rows² · columns)). Costs are finite. There are at least as many columns as rows.
[[nodiscard]] std::vector<std::size_t> cheapest_columns(const std::vector<double>& costs, std::size_t rows,
                                                        std::size_t columns);

}  // namespace stereogrid::evaluation
