// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "backend/reference.hpp"
#include "matching/semi_global.hpp"

namespace stereogrid {
namespace {

constexpr int unreachable{255};

// Costs of all labels of a pixel: first the upright ones, then those of the road.
struct Labels {
  std::vector<int> upright;
  std::vector<int> road;
};

struct Problem {
  const CensusTriple& census;
  const RoadPlane& plane;
  Penalties penalties;
  Shifts upright;
  Shifts road;

  [[nodiscard]] int width() const { return census.left.width; }
  [[nodiscard]] int height() const { return census.left.height; }
};

int hamming(std::uint32_t left, View<const std::uint32_t> right, int u, int v) {
  return std::popcount(left ^ right(std::clamp(u, 0, right.width - 1), v));
}

Labels pixel_costs(const Problem& problem, int u, int v) {
  Labels costs;
  const std::uint32_t left{problem.census.left(u, v)};
  for (int k{0}; k < problem.upright.count; ++k) {
    costs.upright.push_back(hamming(left, problem.census.right, u - problem.upright.first - k, v));
  }
  for (int k{0}; k < problem.road.count; ++k) {
    costs.road.push_back(hamming(left, problem.census.sheared, u - problem.road.first - k, v));
  }
  return costs;
}

int at(const std::vector<int>& labels, int k) {
  return k >= 0 && k < static_cast<int>(labels.size()) ? labels[static_cast<std::size_t>(k)] : unreachable;
}

// Cheapest way into label k of one type, from the pixel before on the path.
int cheapest_within(const std::vector<int>& before, int k, int smallest, const Penalties& penalties) {
  return std::min(
      {at(before, k), std::min(at(before, k - 1), at(before, k + 1)) + penalties.step, smallest + penalties.jump});
}

// Path costs of a pixel from those of the pixel before.
Labels advance(const Problem& problem, const Labels& before, int u, int v) {
  const Penalties& penalties{problem.penalties};
  const int smallest{std::min(*std::min_element(before.upright.begin(), before.upright.end()),
                              *std::min_element(before.road.begin(), before.road.end()))};
  // disparity of the first road label, as an upright label
  const int meeting{meeting_disparity(problem.plane, u, v) + problem.road.first - problem.upright.first};
  Labels path{pixel_costs(problem, u, v)};
  for (int k{0}; k < problem.upright.count; ++k) {
    int way{cheapest_within(before.upright, k, smallest, penalties)};
    for (int j{-1}; j <= 1; ++j) way = std::min(way, at(before.road, k - meeting + j) + penalties.change);
    path.upright[static_cast<std::size_t>(k)] += way - smallest;
  }
  for (int k{0}; k < problem.road.count; ++k) {
    int way{cheapest_within(before.road, k, smallest, penalties)};
    for (int j{-1}; j <= 1; ++j) way = std::min(way, at(before.upright, k + meeting + j) + penalties.change);
    path.road[static_cast<std::size_t>(k)] += way - smallest;
  }
  return path;
}

void add(const Labels& path, Labels& sum) {
  for (std::size_t k{0}; k < path.upright.size(); ++k) sum.upright[k] += path.upright[k];
  for (std::size_t k{0}; k < path.road.size(); ++k) sum.road[k] += path.road[k];
}

// Walks all paths of one direction and adds their costs.
void walk(const Problem& problem, int du, int dv, Image<Labels>& sums) {
  Image<Labels> paths{problem.width(), problem.height()};
  for (int j{0}; j < problem.height(); ++j) {
    for (int i{0}; i < problem.width(); ++i) {
      const int u{du < 0 ? problem.width() - 1 - i : i};
      const int v{dv < 0 ? problem.height() - 1 - j : j};
      const int before_u{u - du};
      const int before_v{v - dv};
      const bool begins{before_u < 0 || before_u >= problem.width() || before_v < 0 || before_v >= problem.height()};
      paths(u, v) = begins ? pixel_costs(problem, u, v) : advance(problem, paths(before_u, before_v), u, v);
      add(paths(u, v), sums(u, v));
    }
  }
}

Candidate best_of(const std::vector<int>& costs, Shifts shifts, int uniqueness) {
  const int best{static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin())};
  int runner_up{65535};
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
  const Problem problem{census, plane, penalties_of(config), upright_shifts(config), road_shifts(config)};
  const auto count_of = [](Shifts shifts) { return static_cast<std::size_t>(shifts.count); };
  Image<Labels> sums{problem.width(),
                     problem.height(),
                     {std::vector<int>(count_of(problem.upright)), std::vector<int>(count_of(problem.road))}};
  walk(problem, 1, 0, sums);
  walk(problem, -1, 0, sums);
  walk(problem, 0, 1, sums);
  walk(problem, 0, -1, sums);
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
