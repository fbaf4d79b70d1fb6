// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "backend/reference.hpp"
#include "matching/semi_global/semi_global.hpp"

namespace stereogrid {
namespace {

// Costs of all labels of a pixel: first the upright ones, then those of the road.
struct Labels {
  std::vector<int> upright;
  std::vector<int> road;
};

struct Problem {
  const CensusTriple& census;
  const RoadPlane& plane;
  Shifts upright;
  Shifts road;

  [[nodiscard]] int width() const { return census.left.width; }
  [[nodiscard]] int height() const { return census.left.height; }
};

int hamming(std::uint32_t left, View<const std::uint32_t> right, int u, int v) {
  return std::popcount(left ^ right(std::clamp(u, 0, right.width - 1), v));
}

// Road labels cannot be taken in a row without road.
Labels pixel_costs(const Problem& problem, int u, int v) {
  Labels costs;
  const std::uint32_t left{problem.census.left(u, v)};
  const bool has_road{row_has_road(problem.plane, problem.width(), v)};
  for (int k{0}; k < problem.upright.count; ++k) {
    costs.upright.push_back(hamming(left, problem.census.right, u - problem.upright.first - k, v));
  }
  for (int k{0}; k < problem.road.count; ++k) {
    const int cost{hamming(left, problem.census.sheared, u - problem.road.first - k, v)};
    costs.road.push_back(has_road ? cost : cost_max);
  }
  return costs;
}

int at(const std::vector<int>& labels, int k) {
  return k >= 0 && k < static_cast<int>(labels.size()) ? labels[static_cast<std::size_t>(k)] : cost_max;
}

// Cheapest way into label k of one type, from the pixel before on the path.
int cheapest_within(const std::vector<int>& before, int k, int step, int jump) {
  return std::min({at(before, k), std::min(at(before, k - 1), at(before, k + 1)) + step, jump});
}

int cheapest_of_three(const std::vector<int>& before, int k) {
  return std::min({at(before, k - 1), at(before, k), at(before, k + 1)});
}

struct Direction {
  int du;
  int dv;
};

// Path costs of a pixel from those of the pixel before.
Labels advance(const Problem& problem, const Labels& before, int u, int v, Direction direction) {
  constexpr Penalties penalties{path_penalties};
  const int smallest{std::min(*std::min_element(before.upright.begin(), before.upright.end()),
                              *std::min_element(before.road.begin(), before.road.end()))};
  const int meeting{meeting_label(problem.plane, problem.upright, problem.road, u, v)};
  // upwards, from the road to an obstacle on it
  const bool changes{direction.dv < 0 && meeting >= 0 && row_has_road(problem.plane, problem.width(), v)};
  Labels path{pixel_costs(problem, u, v)};
  for (int k{0}; k < problem.upright.count; ++k) {
    int way{cheapest_within(before.upright, k, penalties.step, smallest + penalties.jump)};
    if (changes) way = std::min(way, cheapest_of_three(before.road, k - meeting) + penalties.change);
    int& cost{path.upright[static_cast<std::size_t>(k)]};
    cost = std::min(cost + way - smallest, cost_max);
  }
  for (int k{0}; k < problem.road.count; ++k) {
    const int way{cheapest_within(before.road, k, penalties.road_step, smallest + penalties.jump)};
    int& cost{path.road[static_cast<std::size_t>(k)]};
    cost = std::min(cost + way - smallest, cost_max);
  }
  return path;
}

void add(const std::vector<int>& path, std::vector<int>& sum) {
  for (std::size_t k{0}; k < path.size(); ++k) sum[k] = std::min(sum[k] + path[k], cost_max);
}

// Walks all paths of one direction and adds their costs.
void walk(const Problem& problem, Direction direction, Image<Labels>& sums) {
  Image<Labels> paths{problem.width(), problem.height()};
  for (int j{0}; j < problem.height(); ++j) {
    for (int i{0}; i < problem.width(); ++i) {
      const int u{direction.du < 0 ? problem.width() - 1 - i : i};
      const int v{direction.dv < 0 ? problem.height() - 1 - j : j};
      const int before_u{u - direction.du};
      const int before_v{v - direction.dv};
      const bool begins{before_u < 0 || before_u >= problem.width() || before_v < 0 || before_v >= problem.height()};
      paths(u, v) = begins ? pixel_costs(problem, u, v) : advance(problem, paths(before_u, before_v), u, v, direction);
      add(paths(u, v).upright, sums(u, v).upright);
      add(paths(u, v).road, sums(u, v).road);
    }
  }
}

Candidate best_of(const std::vector<int>& costs, Shifts shifts, int uniqueness) {
  const int best{static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin())};
  int runner_up{cost_max};
  for (int k{0}; k < shifts.count; ++k) {
    if (std::abs(k - best) > 1) runner_up = std::min(runner_up, at(costs, k));
  }
  const bool is_unique{runner_up > highest_rival(at(costs, best), uniqueness)};
  const bool inside{best > 0 && best < shifts.count - 1};
  const auto cost_at = [&](int k) { return static_cast<std::uint16_t>(at(costs, k)); };
  return {cost_at(best), static_cast<std::uint16_t>(is_unique ? 0 : 1), cost_at(inside ? best - 1 : best),
          cost_at(inside ? best + 1 : best), static_cast<std::int16_t>(shifts.first + best)};
}

}  // namespace

void optimise(Reference&, const CensusTriple& census, const RoadPlane& plane, const MatchingConfig& config,
              CandidateSink& sink) {
  const Problem problem{census, plane, upright_shifts(config), road_shifts};
  const auto count_of = [](Shifts shifts) { return static_cast<std::size_t>(shifts.count); };
  Image<Labels> sums{problem.width(),
                     problem.height(),
                     {std::vector<int>(count_of(problem.upright)), std::vector<int>(count_of(problem.road))}};
  for (const Direction direction : {Direction{1, 0}, {-1, 0}, {0, -1}}) walk(problem, direction, sums);
  RowCandidates row{problem.width()};
  for (int v{0}; v < problem.height(); ++v) {
    for (int u{0}; u < problem.width(); ++u) {
      row.upright.set(u, best_of(sums(u, v).upright, problem.upright, uniqueness_1024(config)));
      row.level.set(u, best_of(sums(u, v).road, problem.road, uniqueness_1024(config)));
    }
    sink.take(v, row);
  }
}

}  // namespace stereogrid
