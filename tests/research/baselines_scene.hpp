// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../evaluation/support.hpp"
#include "baselines/baselines.hpp"

namespace stereogrid::research::testing {

using evaluation::testing::around;
using evaluation::testing::half_metre_grid;
using evaluation::testing::values_of;

/// f·b = 100 px·m: a wall of disparity d stands at x = 100/d m. The camera has the pitch `pitch_rad`.
inline Rig hundred_rig() {
  return {.width_px = 241,
          .height_px = 161,
          .focal_px = 200,
          .cx_px = 120,
          .cy_px = 60,
          .baseline_m = 0.5,
          .camera_height_m = 1.5};
}

/// Exact disparity images of a flat road with upright walls on it.
class DisparityScene {
 public:
  explicit DisparityScene(double pitch_rad = 0) : rig_{hundred_rig()} {
    ground_.height_m = rig_.camera_height_m;
    ground_.pitch_rad = pitch_rad;
  }

  /// The road up to a distance.
  DisparityScene& road(double to_m = 100) {
    for (int v{0}; v < rig_.height_px; ++v) {
      const double d{road_disparity(v)};
      if (d < rig_.focal_px * rig_.baseline_m / to_m) continue;
      for (int u{0}; u < rig_.width_px; ++u) road_(u, v) = static_cast<float>(d);
    }
    return *this;
  }

  /// A wall on the columns first_u … last_u. Nearer walls have to come after farther ones.
  DisparityScene& wall(int first_u, int last_u, double at_m, double top_m, double bottom_m = 0) {
    const double d{rig_.focal_px * rig_.baseline_m / at_m};
    const int top{std::max(0, static_cast<int>(std::ceil(row_at(d, top_m))))};
    const int bottom{std::min(rig_.height_px - 1, static_cast<int>(std::floor(row_at(d, bottom_m))))};
    for (int v{top}; v <= bottom; ++v) {
      for (int u{first_u}; u <= last_u; ++u) {
        obstacle_(u, v) = static_cast<float>(d);
        road_(u, v) = 0;
      }
    }
    return *this;
  }

  [[nodiscard]] DisparityFrame frame() const { return {rig_, ground_, 48, obstacle_.view(), road_.view()}; }

 private:
  // d = (b cos θ / H)(v − v_hor), v_hor = v0 − f tan θ
  [[nodiscard]] double horizon() const { return rig_.cy_px - rig_.focal_px * std::tan(ground_.pitch_rad); }
  [[nodiscard]] double road_disparity(int v) const {
    return rig_.baseline_m * std::cos(ground_.pitch_rad) / ground_.height_m * (v - horizon());
  }
  [[nodiscard]] double row_at(double d, double height_m) const {
    return horizon() + d * (ground_.height_m - height_m) / (rig_.baseline_m * std::cos(ground_.pitch_rad));
  }

  Rig rig_;
  Ground ground_;
  Image<float> obstacle_{rig_.width_px, rig_.height_px};
  Image<float> road_{rig_.width_px, rig_.height_px};
};

}  // namespace stereogrid::research::testing
