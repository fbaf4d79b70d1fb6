// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cuda.hpp"
#include "terrain/rules.hpp"

namespace stereogrid {

/// Applies rules, row by row without gaps, to `cells`. `rules` is on the device, or in pinned memory.
void apply_rules(Cuda& cuda, const CellRule* rules, View<float, Device> cells);

}  // namespace stereogrid
