// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "figures/lidar_points.hpp"

#include <cmath>

#include "pictures/panels.hpp"

namespace stereogrid::app::figures {

std::vector<LidarPoint> in_vehicle(const std::vector<io::ScanPoint>& scan, const io::Transform& camera_from_velodyne,
                                   const Rig& rig, const Ground& ground) {
  const io::Transform& t{camera_from_velodyne};
  const auto row = [&t](const io::ScanPoint& p, std::size_t i) {
    return t[i] * static_cast<double>(p.x_m) + t[i + 1] * static_cast<double>(p.y_m) +
           t[i + 2] * static_cast<double>(p.z_m) + t[i + 3];
  };
  const double levelled_rad{is_levelled(rig) ? rig.camera_pitch_rad : 0.0};
  const double c{std::cos(levelled_rad)};
  const double s{std::sin(levelled_rad)};
  std::vector<LidarPoint> points;
  points.reserve(scan.size());
  for (const io::ScanPoint& point : scan) {
    const double right{row(point, 0)};
    const double down{c * row(point, 4) + s * row(point, 8)};
    const double ahead{c * row(point, 8) - s * row(point, 4)};
    // how far below the camera along the road's normal
    const double below{std::cos(ground.pitch_rad) *
                           (std::cos(ground.roll_rad) * down + std::sin(ground.roll_rad) * right) +
                       std::sin(ground.pitch_rad) * ahead};
    points.push_back({ahead, -right, ground.height_m - below});
  }
  return points;
}

}  // namespace stereogrid::app::figures
