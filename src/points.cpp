// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/points.hpp"

#include <algorithm>
#include <cmath>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

/// From a pixel and its disparity to the vehicle frame. docs/method.md §1.1, §1.2.
class PointAt {
 public:
  PointAt(const Rig& rig, const Ground& ground)
      : rig_{rig},
        place_{camera_place(rig)},
        height_m_{ground.height_m},
        down_x_{std::cos(ground.pitch_rad) * std::sin(ground.roll_rad)},
        down_y_{std::cos(ground.pitch_rad) * std::cos(ground.roll_rad)},
        down_z_{std::sin(ground.pitch_rad)} {}

  [[nodiscard]] LabelledPoint operator()(int u, int v, float disparity, PointLabel label) const {
    const double z{rig_.focal_px * rig_.baseline_m / static_cast<double>(disparity)};
    const double x{(u - rig_.cx_px) * z / rig_.focal_px};
    const double y{(v - rig_.cy_px) * z / rig_.focal_px};
    const Point2 at{place_ == Pose2{} ? Point2{z, -x} : place_ * Point2{z, -x}};
    return {static_cast<float>(at.x), static_cast<float>(at.y),
            static_cast<float>(height_m_ - (down_x_ * x + down_y_ * y + down_z_ * z)), label};
  }

 private:
  Rig rig_;
  Pose2 place_;
  double height_m_;
  // towards the road, in camera axes
  double down_x_;
  double down_y_;
  double down_z_;
};

/// Measurements of a camera in a frame.
struct Measured {
  const FrameResult& result;  // status and ground
  const StageImages& stages;
  const Rig& level_rig;
};

void add_points(const Measured& of, std::vector<LabelledPoint>& points) {
  const Image<float>& obstacle{of.stages.obstacle_disparity};
  const Image<float>& road{of.stages.road_disparity};
  const auto fits = [&](const Image<float>& image) {
    return image.width() == of.level_rig.width_px && image.height() == of.level_rig.height_px;
  };
  if (obstacle.empty() || !fits(obstacle) || !fits(road)) {
    throw InputError{"frame result", "its disparities do not have the rig's size.",
                     "Ask for them with PipelineOptions::stages, and pass FrameResult::level_rig."};
  }
  if (has_any(of.result.status, {FrameStatus::few_matches, FrameStatus::road_unknown})) return;
  const auto has_disparity = [](float d) { return d > 0; };
  points.reserve(points.size() + static_cast<std::size_t>(std::ranges::count_if(obstacle, has_disparity) +
                                                          std::ranges::count_if(road, has_disparity)));
  const PointAt point_at{of.level_rig, of.result.ground};
  for (int v{0}; v < obstacle.height(); ++v) {
    for (int u{0}; u < obstacle.width(); ++u) {
      // no pixel has both
      if (obstacle(u, v) > 0) {
        points.push_back(point_at(u, v, obstacle(u, v), PointLabel::obstacle));
      } else if (road(u, v) > 0) {
        points.push_back(point_at(u, v, road(u, v), PointLabel::road));
      }
    }
  }
}

}  // namespace

std::vector<LabelledPoint> points_of(const FrameResult& result, const Rig& level_rig) {
  std::vector<LabelledPoint> points;
  if (result.cameras.empty()) add_points({result, result.stages, level_rig}, points);
  for (const FrameResult& camera : result.cameras)
    add_points({camera, &camera == &result.cameras.front() ? result.stages : camera.stages, camera.level_rig}, points);
  return points;
}

}  // namespace stereogrid
