// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "baselines/columns.hpp"

#include <algorithm>

namespace stereogrid::research {
namespace {

struct Source {
  float cost;
  int state;
};

// Best predecessor of each state: two sweeps of the distance transform, and a jump from the cheapest of all.
std::vector<Source> sources(const std::vector<float>& totals, float jump_cost, int jump_max) {
  const int states{static_cast<int>(totals.size())};
  std::vector<Source> best(totals.size());
  const int cheapest{static_cast<int>(std::min_element(totals.begin(), totals.end()) - totals.begin())};
  const Source far{totals[static_cast<std::size_t>(cheapest)] + jump_cost * static_cast<float>(jump_max), cheapest};
  for (int i{0}; i < states; ++i) {
    const auto at{static_cast<std::size_t>(i)};
    best[at] = {totals[at], i};
    if (i > 0 && best[at - 1].cost + jump_cost < best[at].cost)
      best[at] = {best[at - 1].cost + jump_cost, best[at - 1].state};
  }
  for (int i{states - 1}; i >= 0; --i) {
    const auto at{static_cast<std::size_t>(i)};
    if (i + 1 < states && best[at + 1].cost + jump_cost < best[at].cost) {
      best[at] = {best[at + 1].cost + jump_cost, best[at + 1].state};
    }
  }
  for (Source& source : best) {
    if (far.cost < source.cost) source = far;
  }
  return best;
}

}  // namespace

std::vector<int> best_path(const Image<float>& costs, double jump_cost, int jump_max) {
  if (costs.empty()) return {};
  const int states{costs.width()};
  Image<int> from{states, costs.height()};
  std::vector<float> totals(costs.row(0), costs.row(0) + states);
  for (int column{1}; column < costs.height(); ++column) {
    const std::vector<Source> best{sources(totals, static_cast<float>(jump_cost), jump_max)};
    for (int state{0}; state < states; ++state) {
      const Source& source{best[static_cast<std::size_t>(state)]};
      totals[static_cast<std::size_t>(state)] = source.cost + costs(state, column);
      from(state, column) = source.state;
    }
  }
  std::vector<int> path(static_cast<std::size_t>(costs.height()));
  int state{static_cast<int>(std::min_element(totals.begin(), totals.end()) - totals.begin())};
  for (int column{costs.height() - 1}; column >= 0; --column) {
    path[static_cast<std::size_t>(column)] = state;
    state = from(state, column);
  }
  return path;
}

}  // namespace stereogrid::research
