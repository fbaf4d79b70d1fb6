// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "baselines/columns.hpp"

namespace stereogrid::research {
namespace {

constexpr int bins_per_px{2};  // bins of the stochastic grid

/// The stochastic grid over (disparity, column): the share of an obstacle's height that measurements fill.
class StochasticGrid {
 public:
  StochasticGrid(const DisparityFrame& frame, const OccupancyBoundaryParameters& parameters)
      : frame_{frame},
        parameters_{parameters},
        columns_{(frame.obstacle.width + parameters.column_px - 1) / parameters.column_px},
        evidence_{frame.disparities * bins_per_px, columns_} {
    add_measurements();
    spread_across();
    normalise();
  }

  [[nodiscard]] const Image<float>& evidence() const { return evidence_; }

  /// Keeps the nearest peak of each column.
  void drop_background() {
    for (int column{0}; column < columns_; ++column) {
      bool peak{false};
      bool behind{false};
      for (int k{evidence_.width() - 1}; k >= 0; --k) {
        const double value{static_cast<double>(evidence_(k, column))};
        peak = peak || value > parameters_.peak;
        behind = behind || (peak && value < parameters_.peak / 2);
        if (behind) evidence_(k, column) = 0;
      }
    }
  }

 private:
  // every pixel is a Gaussian over disparities, cut off at three sigmas
  void add_measurements() {
    const RoadModel road{frame_.rig, frame_.ground};
    for (int v{0}; v < frame_.obstacle.height; ++v) {
      for (int u{0}; u < frame_.obstacle.width; ++u) {
        const double d{static_cast<double>(frame_.obstacle(u, v))};
        if (d <= 0) continue;
        const double height_m{road.height_m(u, v, d)};
        if (height_m < parameters_.height_min_m || height_m > parameters_.height_max_m) continue;
        add(u / parameters_.column_px, d);
      }
    }
  }

  void add(int column, double d) {
    const double sigma{parameters_.sigma_d_px};
    const int first{std::max(1, static_cast<int>(std::ceil((d - 3 * sigma) * bins_per_px)))};
    const int last{std::min(evidence_.width() - 1, static_cast<int>((d + 3 * sigma) * bins_per_px))};
    for (int k{first}; k <= last; ++k) {
      const double off{(static_cast<double>(k) / bins_per_px - d) / sigma};
      evidence_(k, column) += static_cast<float>(std::exp(-0.5 * off * off));
    }
  }

  void spread_across() {
    const double sigma{parameters_.sigma_u_px / parameters_.column_px};
    const int reach{static_cast<int>(3 * sigma)};
    Image<float> spread{evidence_.width(), columns_};
    for (int column{0}; column < columns_; ++column) {
      for (int k{-reach}; k <= reach; ++k) {
        const int from{column + k};
        if (from < 0 || from >= columns_) continue;
        const auto weight{static_cast<float>(std::exp(-0.5 * (k / sigma) * (k / sigma)))};
        weight_sum_ += column == columns_ / 2 ? static_cast<double>(weight) : 0;
        for (int d{0}; d < spread.width(); ++d) spread(d, column) += weight * evidence_(d, from);
      }
    }
    evidence_ = spread;
  }

  // by what an obstacle of the full height would give at that disparity
  void normalise() {
    const double rows_per_px{(parameters_.height_max_m - parameters_.height_min_m) / frame_.rig.baseline_m};
    for (int k{1}; k < evidence_.width(); ++k) {
      const double full{rows_per_px * k / bins_per_px * parameters_.column_px * weight_sum_};
      for (int column{0}; column < columns_; ++column) evidence_(k, column) /= static_cast<float>(std::max(1.0, full));
    }
  }

  const DisparityFrame& frame_;
  const OccupancyBoundaryParameters& parameters_;
  int columns_;
  Image<float> evidence_;  // (columns, bins): a row per column
  double weight_sum_{0};
};

// A boundary costs what its cell lacks, 1/D; state 0 is "no obstacle".
Image<float> costs_of(const Image<float>& evidence, double no_obstacle_cost) {
  Image<float> costs{evidence.width(), evidence.height()};
  const double highest{2 * no_obstacle_cost};
  for (std::size_t i{0}; i < costs.size(); ++i) {
    const double value{static_cast<double>(evidence.data()[i])};
    costs.data()[i] = static_cast<float>(value * highest > 1 ? 1 / value : highest);
  }
  for (int column{0}; column < costs.height(); ++column) costs(0, column) = static_cast<float>(no_obstacle_cost);
  return costs;
}

// The centre of the evidence around the boundary.
double refined(const Image<float>& evidence, int column, int bin) {
  double sum{0};
  double moment{0};
  for (int k{std::max(1, bin - bins_per_px)}; k <= std::min(evidence.width() - 1, bin + bins_per_px); ++k) {
    sum += static_cast<double>(evidence(k, column));
    moment += k * static_cast<double>(evidence(k, column));
  }
  return (sum > 0 ? moment / sum : bin) / bins_per_px;
}

}  // namespace

Image<float> occupancy_boundary_grid(const DisparityFrame& frame, const GridGeometry& grid,
                                     const OccupancyBoundaryParameters& parameters) {
  StochasticGrid stochastic{frame, parameters};
  stochastic.drop_background();
  const Image<float>& evidence{stochastic.evidence()};
  const std::vector<int> path{best_path(costs_of(evidence, parameters.no_obstacle_cost),
                                        parameters.jump_cost / bins_per_px,
                                        static_cast<int>(std::lround(parameters.jump_max_px * bins_per_px)))};
  const std::vector<double> farthest{farthest_road(frame)};
  std::vector<ColumnBoundary> columns;
  for (std::size_t u{0}; u < farthest.size(); ++u) {
    const std::size_t column{u / static_cast<std::size_t>(parameters.column_px)};
    const int bin{path[column]};
    columns.push_back({bin > 0 ? refined(evidence, static_cast<int>(column), bin) : 0, farthest[u]});
  }
  return boundary_grid(frame, columns, parameters.grid, parameters.levels, grid);
}

}  // namespace stereogrid::research
