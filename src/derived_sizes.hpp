// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/config.hpp"

namespace stereogrid {

/// Adds to `found` a message for each size that parameters give together and that cannot be used, such as the number of
/// cells. Parameters with a message of their own in `found` are left out.
void add_problems_of_sizes(const Config& config, std::vector<std::string>& found);

}  // namespace stereogrid
