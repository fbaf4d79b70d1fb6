// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "compare.hpp"

namespace stereogrid::app {

/// A line per method, 3–20 m.
void print_table(const Comparison& comparison);

/// Every figure of every method and band, with its 95 % interval; null where there is nothing to say.
[[nodiscard]] nlohmann::ordered_json json_of(const Comparison& comparison);

}  // namespace stereogrid::app
