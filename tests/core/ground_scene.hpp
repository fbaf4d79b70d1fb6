// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ground/plane_evidence.hpp"
#include "support.hpp"

namespace stereogrid::test {

/// Camera of the scenes: 640 × 400 px, f·b = 50 px·m.
inline Rig scene_rig() {
  Rig rig;
  rig.width_px = 640;
  rig.height_px = 400;
  rig.focal_px = 420;
  rig.cx_px = 320;
  rig.cy_px = 200;
  rig.baseline_m = 0.12;
  return rig;
}

/// Disparity of a pixel.
struct GroundSample {
  float u;
  float v;
  float disparity;
};

/// Surfaces in view; a pixel has the largest disparity of all.
struct GroundScene {
  Ground floor{1.2, 0.2, 0};
  bool has_floor{true};
  double floor_ends_at_m{1e9};  ///< distance along the optical axis; beyond it lies `lower_floor_m`
  double lower_floor_m{0};      ///< 0: none; height of the camera above it
  double wall_m{0};             ///< upright wall across; 0: none
  int boxes{0};                 ///< boxes of a quarter of the width, 0.4 m high
  double mirrored{0};           ///< share of the floor's pixels that show a mirrored wall at 12 m: a wet road
  int bonnet_from_row{0};       ///< the vehicle's own bonnet, at 1 m; 0: none
  double noise_px{0.3};
  double outliers{0.05};

  [[nodiscard]] double disparity(const Rig& rig, int u, int v) const {
    double d{0};
    const double own{road_plane(rig, floor).disparity(u, v)};
    const double far_px{rig.focal_px * rig.baseline_m / floor_ends_at_m};
    if (has_floor && own > far_px) d = own;
    if (lower_floor_m > 0 && own <= far_px) {
      d = std::min(road_plane(rig, {lower_floor_m, floor.pitch_rad, floor.roll_rad}).disparity(u, v), far_px);
    }
    for (int i{0}; i < boxes; ++i) {
      const double foot_px{8.0 + 5 * i};
      const bool is_on_it{(u / (rig.width_px / 4) + i) % 4 == 0};
      const double top{road_plane(rig, {floor.height_m - 0.4, floor.pitch_rad, 0}).disparity(u, v)};
      if (is_on_it && own < foot_px && top >= foot_px) d = std::max(d, foot_px);
    }
    if (wall_m > 0) d = std::max(d, rig.focal_px * rig.baseline_m / wall_m);
    if (bonnet_from_row > 0 && v >= bonnet_from_row) d = rig.focal_px * rig.baseline_m;
    return d;
  }

  /// Disparities at every `step`-th pixel.
  [[nodiscard]] std::vector<GroundSample> samples(const Rig& rig, int step = 6, unsigned seed = 1) const {
    std::mt19937 generator{seed};
    std::vector<GroundSample> samples;
    for (int v{step / 2}; v < rig.height_px; v += step) {
      for (int u{step / 2}; u < rig.width_px; u += step) {
        double d{disparity(rig, u, v)};
        if (d > 0) d += noise_px * gaussian(generator);
        const double wall_px{rig.focal_px * rig.baseline_m / 12};
        if (d > wall_px && mirrored > 0 && uniform(generator, 0, 1) < mirrored) d = wall_px;
        if (uniform(generator, 0, 1) < outliers) d = uniform(generator, 1, 60);
        if (d > 0.5) samples.push_back({static_cast<float>(u), static_cast<float>(v), static_cast<float>(d)});
      }
    }
    return samples;
  }
};

inline PlaneSamples weighed(const Rig& rig, const std::vector<GroundSample>& samples, int step = 6) {
  PlaneSamples weighed;
  weighed.resize(samples.size());
  for (std::size_t i{0}; i < samples.size(); ++i) {
    weighed.x[i] = static_cast<float>(samples[i].u - rig.cx_px);
    weighed.y[i] = static_cast<float>(samples[i].v - rig.cy_px);
    weighed.disparity[i] = samples[i].disparity;
  }
  std::vector<float> blocks;
  weigh(rig, step, blocks, weighed);
  weighed.fit_weight = weighed.weight;
  weighed.first_x = static_cast<float>(-rig.cx_px);
  weighed.last_x = static_cast<float>(rig.width_px - rig.cx_px);
  weighed.last_y = static_cast<float>(rig.height_px - rig.cy_px);
  weighed.disparities = 128;
  return weighed;
}

}  // namespace stereogrid::test
