// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "baselines/columns.hpp"

namespace stereogrid::research {
namespace {

/// Strip of image columns, with the evidence of each row.
class Strip {
 public:
  Strip(const DisparityFrame& frame, const FreeSpaceParameters& parameters, const RoadModel& road, int first_u)
      : parameters_{parameters},
        road_{road},
        centre_u_{first_u + (parameters.column_px - 1) / 2.0},
        rows_{frame.obstacle.height} {
    for (int v{0}; v < rows_; ++v) disparities_.push_back(median_disparity(frame, first_u, parameters.column_px, v, v));
  }

  /// The score of an obstacle whose base is on the row first_row + i, which may lie below the image. `costs`: a number
  /// per such row.
  void fill(float* costs, int first_row, int bases) const {
    double on_road{0};
    for (int base{first_row + bases - 1}; base >= first_row; --base) {
      if (base < rows_) on_road += difference(base, road_.disparity(centre_u_, base)) - parameters_.unexplained_px;
      double upright{0};
      const double d{road_.disparity(centre_u_, base)};
      for (int v{top_of(base)}; v <= std::min(base, rows_ - 1); ++v)
        upright += difference(v, d) - parameters_.unexplained_px;
      costs[base - first_row] =
          static_cast<float>(parameters_.obstacle_weight * upright + parameters_.road_weight * on_road);
    }
  }

  /// Median of the disparities near the base's own on the rows above it; 0: there is none.
  [[nodiscard]] double disparity_above(int base) const {
    constexpr double near_px{1.5};
    const double d{road_.disparity(centre_u_, base)};
    std::vector<double> near;
    for (int v{top_of(base)}; v <= std::min(base, rows_ - 1); ++v) {
      const double found{disparities_[static_cast<std::size_t>(v)]};
      if (found > 0 && std::abs(found - d) < near_px) near.push_back(found);
    }
    return near.empty() ? 0 : median(near);
  }

 private:
  // a base below the image still has some rows
  [[nodiscard]] int top_of(int base) const {
    const double d{road_.disparity(centre_u_, base)};
    const int top{static_cast<int>(std::ceil(road_.row_at_height(centre_u_, d, parameters_.obstacle_height_m)))};
    return std::clamp(top, 0, std::max(0, rows_ - parameters_.rows_min));
  }

  [[nodiscard]] double difference(int v, double expected) const {
    const double d{disparities_[static_cast<std::size_t>(v)]};
    return d > 0 ? std::min(std::abs(d - expected), parameters_.difference_max_px) : parameters_.none_px;
  }

  const FreeSpaceParameters& parameters_;
  const RoadModel& road_;
  double centre_u_;
  int rows_;
  std::vector<double> disparities_;  // by row; 0 = none
};

}  // namespace

Image<float> free_space_grid(const DisparityFrame& frame, const GridGeometry& grid,
                             const FreeSpaceParameters& parameters) {
  const RoadModel road{frame.rig, frame.ground};
  const int width{frame.obstacle.width};
  std::vector<Strip> strips;
  for (int u{0}; u < width; u += parameters.column_px) strips.emplace_back(frame, parameters, road, u);
  // the first base is the horizon: no obstacle
  const int horizon{static_cast<int>(std::floor(road.row(frame.rig.cx_px, 0)))};
  const int last{static_cast<int>(road.row(frame.rig.cx_px, frame.disparities - 1))};
  Image<float> costs{std::max(1, last - horizon + 1), static_cast<int>(strips.size())};
  for (int i{0}; i < costs.height(); ++i)
    strips[static_cast<std::size_t>(i)].fill(costs.row(i), horizon, costs.width());
  const std::vector<int> path{best_path(costs, parameters.jump_cost, parameters.jump_max_rows)};
  const std::vector<double> farthest{farthest_road(frame)};
  std::vector<ColumnBoundary> columns;
  for (std::size_t u{0}; u < farthest.size(); ++u) {
    const std::size_t i{u / static_cast<std::size_t>(parameters.column_px)};
    const double d{path[i] > 0 ? strips[i].disparity_above(horizon + path[i]) : 0};
    columns.push_back({d > parameters.disparity_min_px ? d : 0, farthest[u]});
  }
  return boundary_grid(frame, columns, parameters.grid, parameters.levels, grid);
}

}  // namespace stereogrid::research
