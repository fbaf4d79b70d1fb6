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
        height_m_{ground.height_m},
        down_x_{std::cos(ground.pitch_rad) * std::sin(ground.roll_rad)},
        down_y_{std::cos(ground.pitch_rad) * std::cos(ground.roll_rad)},
        down_z_{std::sin(ground.pitch_rad)} {}

  [[nodiscard]] LabelledPoint operator()(int u, int v, float disparity, PointLabel label) const {
    const double z{rig_.focal_px * rig_.baseline_m / static_cast<double>(disparity)};
    const double x{(u - rig_.cx_px) * z / rig_.focal_px};
    const double y{(v - rig_.cy_px) * z / rig_.focal_px};
    return {static_cast<float>(z), static_cast<float>(-x),
            static_cast<float>(height_m_ - (down_x_ * x + down_y_ * y + down_z_ * z)), label};
  }

 private:
  Rig rig_;
  double height_m_;
  // towards the road, in camera axes
  double down_x_;
  double down_y_;
  double down_z_;
};

}  // namespace

std::vector<LabelledPoint> points_of(const FrameResult& result, const Rig& level_rig) {
  const Image<float>& obstacle{result.stages.obstacle_disparity};
  const Image<float>& road{result.stages.road_disparity};
  const auto fits = [&](const Image<float>& image) {
    return image.width() == level_rig.width_px && image.height() == level_rig.height_px;
  };
  if (obstacle.empty() || !fits(obstacle) || !fits(road)) {
    throw InputError{"frame result", "its disparities do not have the rig's size.",
                     "Ask for them with PipelineOptions::stages, and pass FrameResult::level_rig."};
  }
  std::vector<LabelledPoint> points;
  if (has_any(result.status, {FrameStatus::few_matches, FrameStatus::road_unknown})) return points;
  const auto has_disparity = [](float d) { return d > 0; };
  points.reserve(static_cast<std::size_t>(std::ranges::count_if(obstacle, has_disparity) +
                                          std::ranges::count_if(road, has_disparity)));
  const PointAt point_at{level_rig, result.ground};
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
  return points;
}

}  // namespace stereogrid
