// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "filter/filter.hpp"

namespace stereogrid {

// `filter` on the CPU, in its two forms.

void filter_joint(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                  FilterState& after, GridLayers& layers);
void filter_tay(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                FilterState& after, GridLayers& layers);

/// Sets the source cells of each velocity's masses.
void set_antecedents(const FilterInput& input, Scroll scroll, std::vector<Antecedents>& from);

}  // namespace stereogrid
