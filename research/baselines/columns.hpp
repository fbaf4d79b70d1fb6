// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "baselines/baselines.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::research {

/// The road in disparity space (docs/method.md §1.2).
class RoadModel {
 public:
  RoadModel(const Rig& rig, const Ground& ground);

  /// Disparity of the road at a pixel; 0 or less above the horizon.
  [[nodiscard]] double disparity(double u, double v) const { return at_origin_ + per_u_ * u + per_v_ * v; }
  /// Row at which the road has that disparity.
  [[nodiscard]] double row(double u, double disparity) const { return (disparity - at_origin_ - per_u_ * u) / per_v_; }
  /// Row of a point at that height above the road.
  [[nodiscard]] double row_at_height(double u, double disparity, double height_m) const {
    return row(u, disparity * (1 - height_m / camera_height_m_));
  }
  /// Height of a pixel above the road, given its disparity.
  [[nodiscard]] double height_m(double u, double v, double pixel_disparity) const {
    return camera_height_m_ * (1 - disparity(u, v) / pixel_disparity);
  }
  [[nodiscard]] double per_row() const { return per_v_; }

 private:
  double camera_height_m_;
  double per_u_;
  double per_v_;
  double at_origin_;
};

/// Probabilities over columns and disparities; what nothing is known of is 0.5.
class DisparityPlane {
 public:
  DisparityPlane(const DisparityFrame& frame, const ColumnGridParameters& parameters);

  /// Sets the bins of a column that overlap the disparities [from, to].
  void set(int u, double from, double to, double probability);
  /// The same for cells that are unknown, or less certainly occupied.
  void raise(int u, double from, double to, double probability);
  [[nodiscard]] double disparity_max() const { return (plane_.height() - 0.5) / bins_per_px_; }
  /// Smooths, resets the left border, and assigns to every cell the largest probability of the bins whose footprint it
  /// touches (T-ITS 2012, eq. 16).
  [[nodiscard]] Image<float> to_cells(const GridGeometry& grid);

 private:
  struct Bins {
    int first;
    int last;
  };
  [[nodiscard]] Bins bins(double from, double to) const;
  void smooth();
  void drop_left_border();
  [[nodiscard]] float cell(double x0, double x1, double y0, double y1) const;
  [[nodiscard]] float largest_in(int bin, double x_near, double x_far, double y0, double y1, float so_far) const;

  Rig rig_;
  ColumnGridParameters parameters_;
  double bins_per_px_;
  Image<float> plane_;  // (bins, W)
};

/// The nearest obstacle of an image column, and how far it is known to be free.
struct ColumnBoundary {
  double disparity{0};  ///< disparity of the obstacle; 0: none
  double free_to{0};    ///< without obstacle: smallest disparity of the free road; 0: nothing is known
};

/// Free before the boundary, occupied at it, unknown behind.
[[nodiscard]] Image<float> boundary_grid(const DisparityFrame& frame, const std::vector<ColumnBoundary>& columns,
                                         const ColumnGridParameters& parameters, const Levels& levels,
                                         const GridGeometry& grid);

/// Smallest disparity at which each column shows road, but for its four farthest pixels; 0: no road.
[[nodiscard]] std::vector<double> farthest_road(const DisparityFrame& frame);

/// One state per column, by dynamic programming: the least sum of costs(column, state) and, between neighbours,
/// jump_cost·min(|difference of states|, jump_max). `costs` is (states, columns).
[[nodiscard]] std::vector<int> best_path(const Image<float>& costs, double jump_cost, int jump_max);

/// The upper one of two in the middle; `values` must not be empty.
[[nodiscard]] inline double median(std::vector<double>& values) {
  const auto middle{values.begin() + std::ssize(values) / 2};
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median of the disparities, road or obstacle, in `columns` columns and the rows first_v … last_v; 0: none.
[[nodiscard]] inline double median_disparity(const DisparityFrame& frame, int first_u, int columns, int first_v,
                                             int last_v) {
  std::vector<double> found;
  for (int v{first_v}; v <= std::min(last_v, frame.obstacle.height - 1); ++v) {
    for (int u{first_u}; u < std::min(first_u + columns, frame.obstacle.width); ++u) {
      const float d{std::max(frame.obstacle(u, v), frame.road(u, v))};
      if (d > 0) found.push_back(static_cast<double>(d));
    }
  }
  return found.empty() ? 0 : median(found);
}

}  // namespace stereogrid::research
