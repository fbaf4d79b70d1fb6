// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "matching/correlation/census_simd.hpp"
#include "matching/correlation/correlate_simd.hpp"
#include "matching/matching.hpp"

namespace stereogrid {
MatchingWorkspace::MatchingWorkspace(int width, int height, const MatchingConfig& config, int threads)
    : left{width, height, row_overrun},
      right{width, height, row_overrun},
      sheared{width, height, row_overrun},
      textured{width, height, row_overrun},
      speckles{width, height, threads},
      rows(static_cast<std::size_t>(threads), RowCandidates{width}),
      decisions(static_cast<std::size_t>(threads), ClassifyWorkspace{width}),
      textures(static_cast<std::size_t>(threads), TextureWorkspace{width, config.window_px / 2}) {
  if (config.method == MatchingMethod::semi_global) {
    for (auto* census : {&census_left, &census_right, &census_sheared}) *census = {width, height, row_overrun};
  } else {
    const int border{correlate_border(upright_shifts(config))};
    for (auto* census : {&short_left, &short_right_reversed, &short_sheared}) *census = {width, height, border};
  }
}

}  // namespace stereogrid
