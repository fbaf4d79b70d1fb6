// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/upright_row.hpp"

#include <algorithm>

namespace stereogrid::plain {
namespace {

bool is_between_surfaces(const float* row, int width, int u) {
  const int begin{std::max(u - edge_reach_px, 0)};
  const int end{std::min(u + edge_reach_px + 1, width)};
  bool nearer{false};
  bool farther{false};
  for (int i{begin}; i < end; ++i) {
    nearer |= row[i] > row[u] + edge_step_px;
    farther |= row[i] > 0 && row[i] < row[u] - edge_step_px;
  }
  return nearer && farther;
}

}  // namespace

void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels) {
  pixels.size = 0;
  for (int u{begin}; u < end; ++u) {
    if (!limits.is_upright(u, row[u]) || is_between_surfaces(row, width, u)) continue;
    pixels.columns[pixels.size] = u;
    pixels.disparities[pixels.size] = row[u];
    ++pixels.size;
  }
}

}  // namespace stereogrid::plain
