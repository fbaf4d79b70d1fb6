// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/evaluation/labels.hpp"

namespace stereogrid::evaluation {

/// The road as y = right · x + ahead · z + down in the camera's frame.
struct RoadPlane {
  double right{0};
  double ahead{0};
  double down_m{0};

  [[nodiscard]] double height_of(const CameraPoint& p) const { return p.x_m * right + p.z_m * ahead + down_m - p.y_m; }
};

/// Least squares through low points: 4–30 m ahead, within 8 m of the axis; within 0.35 m of `start`, then
/// twice within 0.12 m of the plane before. Stays where it is with too few points.
[[nodiscard]] RoadPlane fit_road(std::span<const CameraPoint> points, const RoadPlane& start);

/// From the frame of a camera that is mounted as a rig says to that of the same camera turned level about the baseline,
/// as LevelMapping turns its images: there z is the vehicle's x, and −x its y.
class LevelFrame {
 public:
  explicit LevelFrame(const Rig& rig);

  [[nodiscard]] CameraPoint operator()(const CameraPoint& point) const {
    return {point.x_m, cos_ * point.y_m + sin_ * point.z_m, cos_ * point.z_m - sin_ * point.y_m};
  }
  [[nodiscard]] std::vector<CameraPoint> operator()(std::span<const CameraPoint> points) const;
  /// Road according to the extrinsics, `camera_height_m` below the camera.
  [[nodiscard]] RoadPlane road(double camera_height_m) const;

 private:
  Rig rig_;
  double sin_;
  double cos_;
};

/// Nearest obstacle of every image column, and the cells that it hides from methods which end at the nearest obstacle.
class NearestObstacle {
 public:
  explicit NearestObstacle(const Rig& rig);

  /// An obstacle at (x ahead, y to the left), vehicle frame. It covers the columns within `columns` of its own.
  void add(double x_m, double y_m, double columns);

  /// Every column that the cell covers has an obstacle nearer than its near edge by hiding_margin_m.
  [[nodiscard]] bool hides(const GridGeometry& grid, int ix, int iy) const;

 private:
  [[nodiscard]] double column_of(double x_m, double y_m) const;

  Rig rig_;
  std::vector<double> nearest_m_;
};

/// Fills `labels.partly_hidden` of the cells that are labelled.
void mark_partly_hidden(const NearestObstacle& nearest, Labels& labels);

}  // namespace stereogrid::evaluation
