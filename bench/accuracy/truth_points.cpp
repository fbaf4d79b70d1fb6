// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/truth_points.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace stereogrid::bench {
namespace {

int column(double u) {
  return static_cast<int>(std::lround(u));
}

bool inside(int u, int v, int width, int height) {
  return u >= 0 && v >= 0 && u < width && v < height;
}

/// The largest disparity at each pixel of one camera; 0: no point. `shift`: 0 for the left camera, 1 for the right.
Image<float> nearest_points(const Rig& rig, const std::vector<TruthPoint>& points, float shift) {
  Image<float> nearest{rig.width_px, rig.height_px};
  for (const TruthPoint& point : points) {
    const int u{column(point.u - shift * point.disparity)};
    const int v{column(point.v)};
    if (inside(u, v, rig.width_px, rig.height_px)) nearest(u, v) = std::max(nearest(u, v), point.disparity);
  }
  return nearest;
}

bool is_hidden(const Rig& rig, const Image<float>& nearest, const TruthPoint& point, float shift) {
  const int u{column(point.u - shift * point.disparity)};
  const int v{column(point.v)};
  const double slope{1.5 * rig.baseline_m / rig.camera_height_m};
  for (int row{std::max(0, v - 2)}; row <= std::min(rig.height_px - 1, v + 7); ++row) {
    const double clearly{point.disparity + 1 + slope * std::abs(row - v)};
    for (int k{std::max(0, u - 3)}; k <= std::min(rig.width_px - 1, u + 3); ++k) {
      if (nearest(k, row) > clearly) return true;
    }
  }
  return false;
}

/// 1 where a set pixel lies within `reach` rows and columns.
Image<std::uint8_t> grown(const Image<std::uint8_t>& set, int reach) {
  Image<std::uint8_t> across{set.width(), set.height()};
  for (int v{0}; v < set.height(); ++v) {
    for (int u{0}; u < set.width(); ++u) {
      if (set(u, v) != 0)
        std::fill(across.row(v) + std::max(0, u - reach), across.row(v) + std::min(set.width(), u + reach + 1), 1);
    }
  }
  Image<std::uint8_t> both{set.width(), set.height()};
  for (int v{0}; v < set.height(); ++v) {
    for (int row{std::max(0, v - reach)}; row <= std::min(set.height() - 1, v + reach); ++row) {
      for (int u{0}; u < set.width(); ++u) both(u, row) |= across(u, v);
    }
  }
  return both;
}

void mark_contact(int width, int height, std::vector<TruthPoint>& points) {
  const auto near{[&](Surface surface) {
    Image<std::uint8_t> set{width, height};
    for (const TruthPoint& point : points) {
      const bool is_in{inside(column(point.u), column(point.v), width, height)};
      if (point.surface == surface && is_in) set(column(point.u), column(point.v)) = 1;
    }
    return grown(set, contact_px);
  }};
  const Image<std::uint8_t> near_road{near(Surface::road)};
  const Image<std::uint8_t> near_obstacle{near(Surface::obstacle)};
  for (TruthPoint& point : points) {
    const int u{column(point.u)};
    const int v{column(point.v)};
    if (!inside(u, v, width, height) || point.surface == Surface::other) continue;
    point.near_contact = (point.surface == Surface::road ? near_obstacle : near_road)(u, v) != 0;
  }
}

double depth_m(const Rig& rig, const TruthPoint& point) {
  return rig.focal_px * rig.baseline_m / point.disparity;
}

/// Least squares of (disparity − plane)/disparity, which is the height up to a factor.
RoadPlane fit(const Rig& rig, const std::vector<TruthPoint>& points, const RoadPlane& start, double farthest_m,
              double band_m) {
  cv::Matx33d normal{cv::Matx33d::zeros()};
  cv::Vec3d right{0, 0, 0};
  for (const TruthPoint& point : points) {
    const double depth{depth_m(rig, point)};
    const double aside_m{(point.u - rig.cx_px) * depth / rig.focal_px};
    if (depth < 4 || depth > farthest_m || std::abs(aside_m) > 8) continue;
    if (std::abs(height_above(start, rig.camera_height_m, point)) > band_m) continue;
    const cv::Vec3d row{cv::Vec3d{1, point.u - rig.cx_px, point.v - rig.cy_px} / point.disparity};
    normal += row * row.t();
    right += row;
  }
  if (normal(0, 0) == 0 || std::abs(cv::determinant(normal)) < 1e-12) return start;
  const cv::Vec3d solved{normal.solve(right, cv::DECOMP_CHOLESKY)};
  return {solved[0], solved[1], solved[2], rig.cx_px, rig.cy_px};
}

}  // namespace

std::vector<TruthPoint> points_of_scan(const std::vector<io::ScanPoint>& scan,
                                       const io::Transform& camera_from_velodyne, const Rig& rig) {
  std::vector<TruthPoint> points;
  const auto& t{camera_from_velodyne};
  for (const io::ScanPoint& p : scan) {
    const double x{t[0] * p.x_m + t[1] * p.y_m + t[2] * p.z_m + t[3]};
    const double y{t[4] * p.x_m + t[5] * p.y_m + t[6] * p.z_m + t[7]};
    const double z{t[8] * p.x_m + t[9] * p.y_m + t[10] * p.z_m + t[11]};
    if (z < 2) continue;
    const double u{rig.cx_px + rig.focal_px * x / z};
    const double v{rig.cy_px + rig.focal_px * y / z};
    if (!inside(column(u), column(v), rig.width_px, rig.height_px)) continue;
    points.push_back({static_cast<float>(u), static_cast<float>(v),
                      static_cast<float>(rig.focal_px * rig.baseline_m / z), Surface::other, false});
  }
  return points;
}

std::vector<TruthPoint> points_of_image(const Image<float>& disparity) {
  std::vector<TruthPoint> points;
  for (int v{0}; v < disparity.height(); ++v) {
    for (int u{0}; u < disparity.width(); ++u) {
      if (disparity(u, v) > 0)
        points.push_back({static_cast<float>(u), static_cast<float>(v), disparity(u, v), Surface::other, false});
    }
  }
  return points;
}

std::vector<TruthPoint> points_of_scene(const FrameTruth& truth) {
  std::vector<TruthPoint> points{points_of_image(truth.disparity)};
  const auto pixel{[](const TruthPoint& point, const auto& image) { return image(column(point.u), column(point.v)); }};
  for (TruthPoint& point : points) {
    const auto label{static_cast<TruthLabel>(pixel(point, truth.label))};
    if (label == TruthLabel::road) point.surface = Surface::road;
    if (label == TruthLabel::obstacle) point.surface = Surface::obstacle;
  }
  mark_contact(truth.disparity.width(), truth.disparity.height(), points);
  std::erase_if(points, [&](const TruthPoint& point) { return pixel(point, truth.seen_by_both) == 0; });
  return points;
}

void remove_hidden(const Rig& rig, std::vector<TruthPoint>& points) {
  const Image<float> left{nearest_points(rig, points, 0)};
  const Image<float> right{nearest_points(rig, points, 1)};
  std::erase_if(points, [&](const TruthPoint& point) {
    return is_hidden(rig, left, point, 0) || is_hidden(rig, right, point, 1);
  });
}

double height_above(const RoadPlane& plane, double camera_height_m, const TruthPoint& point) {
  return camera_height_m * (1 - plane.disparity(point.u, point.v) / point.disparity);
}

RoadPlane fit_road(const Rig& rig, const std::vector<TruthPoint>& points) {
  struct Step {
    double farthest_m;
    double band_m;
  };
  RoadPlane plane{road_plane(rig, {rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad})};
  for (const Step step : {Step{12, 0.3}, {12, 0.2}, {20, 0.2}, {30, 0.2}, {30, 0.1}, {30, 0.1}, {30, 0.1}}) {
    plane = fit(rig, points, plane, step.farthest_m, step.band_m);
  }
  return plane;
}

void label_by_height(const Rig& rig, const RoadPlane& plane, std::vector<TruthPoint>& points) {
  const double camera_height_m{ground_of(rig, plane).height_m};
  for (TruthPoint& point : points) {
    const double height{height_above(plane, camera_height_m, point)};
    point.surface = Surface::other;
    if (depth_m(rig, point) > 40) continue;
    if (std::abs(height) < 0.1) point.surface = Surface::road;
    if (height > 0.3) point.surface = Surface::obstacle;
  }
  mark_contact(rig.width_px, rig.height_px, points);
}

void turn_level(const Rig& pitched, const Rig& level, std::vector<TruthPoint>& points) {
  const double sin_pitch{std::sin(pitched.camera_pitch_rad)};
  const double cos_pitch{std::cos(pitched.camera_pitch_rad)};
  for (TruthPoint& point : points) {
    const double x{(point.u - pitched.cx_px) / pitched.focal_px};
    const double y{(point.v - pitched.cy_px) / pitched.focal_px};
    const double stretch{cos_pitch - y * sin_pitch};  // depth in the level camera per depth in the pitched one
    point.u = static_cast<float>(pitched.cx_px + pitched.focal_px * x / stretch);
    point.v = static_cast<float>(level.cy_px + pitched.focal_px * (y * cos_pitch + sin_pitch) / stretch);
    point.disparity = static_cast<float>(point.disparity / stretch);
  }
}

void keep_comparable(const Rig& rig, int disparities, std::vector<TruthPoint>& points) {
  std::erase_if(points, [&](const TruthPoint& point) {
    const int u{column(point.u)};
    return !inside(u, column(point.v), rig.width_px, rig.height_px) || u < disparities + 10 ||
           point.disparity >= static_cast<float>(disparities - 1);
  });
}

}  // namespace stereogrid::bench
