// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "accuracy/measure.hpp"

namespace stereogrid::bench {

/// Tables of one result, under a heading.
std::string markdown(const SetResult& result);

/// A reliability table; "" where no pixel has a confidence.
std::string markdown(const Reliability& reliability, const std::string& matcher);

/// Everything, by set.
std::string json(const std::vector<SetResult>& results);

}  // namespace stereogrid::bench
