// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::scenes {
namespace {

constexpr auto road = static_cast<std::uint8_t>(TruthLabel::road);
constexpr auto obstacle = static_cast<std::uint8_t>(TruthLabel::obstacle);
constexpr auto low = static_cast<std::uint8_t>(TruthLabel::low);
constexpr auto sky = static_cast<std::uint8_t>(TruthLabel::sky);

TEST(TruthPixels, RoadDisparityIsThePlanesEquation) {
  for (const char* text : {"empty", "empty?pitch_deg=3", "empty?width=333&height=201&pitch_deg=-2"}) {
    const Scene scene{parse_scene(text)};
    const Rig rig{scene.rig()};
    const FrameTruth truth{scene.truth(1)};
    const double horizon{rig.cy_px - rig.focal_px * std::tan(rig.camera_pitch_rad)};
    for (int v{0}; v < rig.height_px; ++v) {
      const double expected{rig.baseline_m * std::cos(rig.camera_pitch_rad) / rig.camera_height_m * (v - horizon)};
      for (int u{0}; u < rig.width_px; u += 7) {
        EXPECT_NEAR(truth.disparity(u, v), std::max(0.0, expected), 1e-5) << text << " " << u << " " << v;
        EXPECT_EQ(truth.label(u, v), v > horizon ? road : sky);
        EXPECT_EQ(truth.seen_by_both(u, v), v > horizon && u - expected >= -0.5 ? 255 : 0);
      }
    }
    EXPECT_TRUE(truth.objects.empty());
  }
}

const TruthObject& object_of(const FrameTruth& truth, const std::string& kind) {
  for (const TruthObject& object : truth.objects) {
    if (object.kind == kind) return object;
  }
  throw std::runtime_error{"no " + kind};
}

/// Mean column of an object's pixels.
double mean_u(const FrameTruth& truth, std::int64_t id) {
  double sum{0};
  int count{0};
  for (int v{0}; v < truth.instance.height(); ++v) {
    for (int u{0}; u < truth.instance.width(); ++u) {
      if (truth.instance(u, v) != id) continue;
      sum += u;
      ++count;
    }
  }
  return sum / count;
}

TEST(TruthPixels, LeftIsPositiveY) {
  const Scene scene{parse_scene("crossing")};
  const FrameTruth begin{scene.truth(4)};
  const FrameTruth end{scene.truth(36)};
  const TruthObject walker{object_of(begin, "pedestrian")};
  EXPECT_LT(walker.world_from_object.y_m, -2);
  EXPECT_GT(mean_u(begin, walker.id), scene.rig().cx_px + 50);
  EXPECT_GT(object_of(end, "pedestrian").world_from_object.y_m, 2);
  EXPECT_LT(mean_u(end, walker.id), scene.rig().cx_px - 50);
  EXPECT_NEAR(mean_u(scene.truth(20), walker.id), scene.rig().cx_px, 1.5);
}

TEST(TruthPixels, DisparityOfAnObjectIsItsDistances) {
  const Scene scene{parse_scene("wall")};
  const FrameTruth truth{scene.truth(0)};
  const double expected{scene.rig().focal_px * scene.rig().baseline_m / 8.0};
  int count{0};
  for (std::size_t i{0}; i < truth.label.size(); ++i) {
    if (truth.label.data()[i] != obstacle) continue;
    EXPECT_NEAR(truth.disparity.data()[i], expected, 1e-4);
    ++count;
  }
  EXPECT_EQ(count, truth.objects.front().pixels);
  EXPECT_GT(count, 50000);
}

TEST(TruthPixels, LabelsAndInstancesAgree) {
  const Scene scene{parse_scene("street")};
  int low_pixels{0};
  for (const std::size_t index : {0U, 20U, 59U}) {
    const FrameTruth truth{scene.truth(index)};
    std::vector<std::int64_t> pixels(truth.objects.size() + 1);
    for (std::size_t i{0}; i < truth.label.size(); ++i) {
      const std::uint8_t label{truth.label.data()[i]};
      EXPECT_EQ(label == obstacle, truth.instance.data()[i] != 0);
      EXPECT_EQ(label == sky, truth.disparity.data()[i] == 0);
      if (label == sky) {
        EXPECT_EQ(truth.seen_by_both.data()[i], 0);
      }
      if (label == low) ++low_pixels;
      ++pixels.at(truth.instance.data()[i]);
    }
    for (const TruthObject& object : truth.objects) {
      EXPECT_EQ(object.pixels, pixels.at(static_cast<std::size_t>(object.id))) << object.kind;
    }
  }
  EXPECT_GT(low_pixels, 200);
}

TEST(TruthPixels, HiddenFromTheRightCameraBesideNearThings) {
  // Left of a near edge, the right camera sees less of the background: the strip is as wide as the disparities differ.
  const Scene scene{parse_scene("occlusion")};
  const FrameTruth truth{scene.truth(0)};
  const TruthObject pole{object_of(truth, "pole")};
  const int v{190};
  int first{0};
  while (truth.instance(first, v) != pole.id) ++first;
  const double step{truth.disparity(first, v) - truth.disparity(first - 1, v)};
  ASSERT_GT(step, 1.5);
  EXPECT_EQ(truth.seen_by_both(first, v), 255);
  EXPECT_EQ(truth.seen_by_both(first - 1, v), 0);
  EXPECT_EQ(truth.seen_by_both(first - 2 - static_cast<int>(std::ceil(step)), v), 255);
}

TEST(TruthMotion, CrossingSpeedsAreAsPromised) {
  const Scene scene{parse_scene("crossing")};
  const TruthObject walker{object_of(scene.truth(10), "pedestrian")};
  EXPECT_NEAR(walker.vx_mps, 0, 1e-12);
  EXPECT_NEAR(walker.vy_mps, 1.4, 1e-12);
  EXPECT_NEAR(walker.height_m, 1.75, 1e-9);
  const TruthObject car{object_of(scene.truth(10), "car")};
  EXPECT_NEAR(car.vx_mps, 0, 1e-12);
  EXPECT_NEAR(car.vy_mps, -6, 1e-12);
  EXPECT_NEAR(car.world_from_object.y_m, 5, 1e-12);
}

TEST(TruthMotion, VelocitiesAreTheDerivativesOfPositions) {
  const Scene scene{parse_scene("street")};
  int moving{0};
  for (std::size_t index{1}; index + 1 < scene.size(); index += 4) {
    const FrameTruth before{scene.truth(index - 1)};
    const FrameTruth now{scene.truth(index)};
    const FrameTruth after{scene.truth(index + 1)};
    for (std::size_t i{0}; i < now.objects.size(); ++i) {
      const auto speed = [i](const FrameTruth& t) { return std::hypot(t.objects[i].vx_mps, t.objects[i].vy_mps); };
      if (std::abs(speed(before) - speed(after)) > 1e-9) continue;  // begins or stops here
      const Pose2 a{before.objects[i].world_from_object};
      const Pose2 b{after.objects[i].world_from_object};
      EXPECT_NEAR((b.x_m - a.x_m) / 0.2, now.objects[i].vx_mps, 2e-3);
      EXPECT_NEAR((b.y_m - a.y_m) / 0.2, now.objects[i].vy_mps, 2e-3);
      if (speed(now) > 0) ++moving;
    }
    EXPECT_NEAR((after.ego.world_from_vehicle.x_m - before.ego.world_from_vehicle.x_m) / 0.2, now.ego.vx_mps, 2e-3);
    EXPECT_NEAR((after.ego.world_from_vehicle.y_m - before.ego.world_from_vehicle.y_m) / 0.2, now.ego.vy_mps, 2e-3);
  }
  EXPECT_GT(moving, 20);
}

TEST(TruthMotion, StreetEgoDrivesOnAnArc) {
  const Scene scene{parse_scene("street")};
  EXPECT_EQ(scene.load(0).world_from_vehicle, (Pose2{0, 0, 0}));
  const TruthEgo ego{scene.truth(40).ego};
  EXPECT_EQ(scene.load(40).world_from_vehicle, ego.world_from_vehicle);
  EXPECT_NEAR(ego.world_from_vehicle.yaw_rad, 0.2, 1e-12);
  EXPECT_NEAR(ego.world_from_vehicle.x_m, 160 * std::sin(0.2), 1e-9);
  EXPECT_NEAR(ego.world_from_vehicle.y_m, 160 * (1 - std::cos(0.2)), 1e-9);
  EXPECT_NEAR(ego.vx_mps, 8 * std::cos(0.2), 1e-12);
  EXPECT_NEAR(ego.vy_mps, 8 * std::sin(0.2), 1e-12);
  EXPECT_NEAR(ego.yaw_rate_radps, 0.05, 1e-12);
}

}  // namespace
}  // namespace stereogrid::scenes
