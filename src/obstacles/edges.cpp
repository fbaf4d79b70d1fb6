// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "obstacles/edges.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace stereogrid {
namespace {

constexpr int block{256};  // pixels at a time: what is kept in between stays in the first cache
constexpr int reach{edge_reach_px};
static_assert(reach == 5, "window_of() joins windows of eight to one of eleven");

using Window = std::array<float, block + 2 * reach>;

// Over 2·reach + 1 values from each of the first `block` on, by doubling: compilers make vectors of these loops.
template <class Choose>
void window_of(Window& values, Choose choose) {
  constexpr int size{block + 2 * reach};
  for (int i{0}; i < size - 1; ++i) values[i] = choose(values[i], values[i + 1]);
  for (int i{0}; i < size - 3; ++i) values[i] = choose(values[i], values[i + 2]);
  for (int i{0}; i < size - 7; ++i) values[i] = choose(values[i], values[i + 4]);
  for (int i{0}; i < block; ++i) values[i] = choose(values[i], values[i + 3]);
}

}  // namespace

void leave_edges_out(const float* row, int width, float* kept) {
  constexpr float nothing{std::numeric_limits<float>::max()};
  Window most;
  Window least;
  for (int begin{0}; begin < width; begin += block) {
    const int first{std::max(begin - reach, 0)};
    const int end{std::min(begin + block + reach, width)};
    most.fill(0);
    std::copy(row + first, row + end, most.begin() + (first - (begin - reach)));
    for (std::size_t i{0}; i < least.size(); ++i) least[i] = most[i] > 0 ? most[i] : nothing;
    window_of(most, [](float a, float b) { return a < b ? b : a; });
    window_of(least, [](float a, float b) { return b < a ? b : a; });
    const int pixels{std::min(block, width - begin)};
    for (int i{0}; i < pixels; ++i) {
      const float here{row[begin + i]};
      const bool between{most[i] > here + edge_step_px && least[i] < here - edge_step_px};
      kept[begin + i] = between ? 0.0f : here;
    }
  }
}

}  // namespace stereogrid
