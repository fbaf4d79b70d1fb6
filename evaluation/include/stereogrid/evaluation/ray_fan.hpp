// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "stereogrid/evaluation/labels.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::evaluation {

/// Hits on cells and rays through them.
struct RayCounts {
  Image<float> hits;
  Image<float> passes;
};

/// Rays from one point in fixed directions; how many end where is counted in steps of length.
class STEREOGRID_EXPORT Fan {
 public:
  /// `directions` need not have length 1: lengths are counted in multiples of them.
  Fan(Point2 origin, std::vector<Point2> directions, double length, double step);

  /// A ray that ends after `length`, on an obstacle or on the road.
  void add(std::size_t direction, double length, bool is_hit);

  /// Counts them on the cells of a grid which lies there as seen from the fan's frame. Rays pass the cells before the
  /// one they end in; those that end on the road pass that one too.
  [[nodiscard]] RayCounts cast(const GridGeometry& grid, const Pose2& grid_from_fan) const;

 private:
  void cast_direction(std::size_t direction, const GridGeometry& grid, const Pose2& grid_from_fan,
                      RayCounts& counts) const;
  [[nodiscard]] float ending_beyond(const std::vector<float>& beyond, double length) const;

  Point2 origin_;
  std::vector<Point2> directions_;
  double step_;
  Image<float> hits_;  // (directions, steps)
  Image<float> ends_;
};

/// Log-odds that points and rays give, as in OctoMap and the layers of Nav2.
struct LogOddsParameters {
  double height_min_m{0.25};  ///< points between these heights are hits
  double height_max_m{1.8};
  double road_m{0.2};    ///< points within this of the road end free rays
  double any_hit{1.5};   ///< log-odds of a cell with hits
  double hit{0.1};       ///< and of each of them
  double any_pass{1};    ///< log-odds, taken away, of a cell without hits that rays go through
  double pass{0.001};    ///< and of each ray, with hits or without
  double points_min{1};  ///< fewer hits are none
  double lowest{-5};     ///< log-odds are kept between these
  double highest{5};
};

/// Distance from the vehicle's origin to the grid's farthest corner.
[[nodiscard]] STEREOGRID_EXPORT double farthest_corner_m(const GridGeometry& grid);

/// Clamped log-odds of every cell.
[[nodiscard]] STEREOGRID_EXPORT Image<float> log_odds_of(const RayCounts& counts, const LogOddsParameters& parameters);
/// Occupancy probability of every cell.
[[nodiscard]] STEREOGRID_EXPORT Image<float> probabilities_of(Image<float> log_odds);

/// Inverse sensor model of a lidar (Thrun, Burgard, Fox: Probabilistic Robotics, table 9.2), summed over the returns of
/// a sweep.
struct LidarModelParameters {
  LogOddsParameters log_odds{.height_min_m = 0.3, .hit = 0.75, .any_pass = 2, .pass = 0};
  double beam_rad{0.0035};  ///< opening B
};
/// Heights are above the plane that lidar_labels fits, with the same `rig` and `camera_height_m`. `lidar`: where the
/// sensor is in the camera's frame.
[[nodiscard]] STEREOGRID_EXPORT Image<float> lidar_grid(std::span<const CameraPoint> points, const CameraPoint& lidar,
                                                        const Rig& rig, const GridGeometry& grid,
                                                        double camera_height_m = kitti_camera_height_m,
                                                        const LidarModelParameters& parameters = {});

}  // namespace stereogrid::evaluation
