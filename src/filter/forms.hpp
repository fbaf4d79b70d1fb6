// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "filter/filter.hpp"

namespace stereogrid {

// `filter` on the CPU, in its two forms.

void filter_joint(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                  FilterState& after, GridLayers& layers);
void filter_tay(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
                FilterState& after, GridLayers& layers);

/// Where each velocity's masses come from.
void set_antecedents(const FilterInput& input, Scroll scroll, std::vector<Antecedents>& from);

/// Before the step, of what is now at the window's cell (x, y); infinite: never seen.
inline float age_before(const Image<float>& age_s, Scroll scroll, int x, int y) {
  const int from_x{x + scroll.x};
  const int from_y{y + scroll.y};
  const bool is_inside{from_x >= 0 && from_x < age_s.width() && from_y >= 0 && from_y < age_s.height()};
  return is_inside ? age_s(from_x, from_y) : std::numeric_limits<float>::infinity();
}

}  // namespace stereogrid
