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

constexpr auto hidden = static_cast<std::uint8_t>(TruthCell::hidden);
constexpr auto seen_free = static_cast<std::uint8_t>(TruthCell::seen_free);
constexpr auto seen_occupied = static_cast<std::uint8_t>(TruthCell::seen_occupied);

TEST(TruthCells, EmptyRoadIsFreeWhereTheCameraLooks) {
  const Scene scene{parse_scene("empty")};
  const Rig rig{scene.rig()};
  const GridGeometry grid{scene.truth_grid().geometry};
  const FrameTruth truth{scene.truth(3)};
  for (const auto [ix, iy] : raster(grid.nx, grid.ny)) {
    const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m};
    const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
    const double u{rig.cx_px - rig.focal_px * y / x};
    const double v{rig.cy_px + rig.focal_px * rig.camera_height_m / x};
    const bool in_image{u >= -0.5 && u < rig.width_px - 0.5 && v < rig.height_px - 0.5};
    const double margin{0.15 * rig.focal_px / x};  // near the border the nine points decide, not the middle
    const bool undecided{std::min({std::abs(u + 0.5), std::abs(u - rig.width_px + 0.5)}) < margin ||
                         std::abs(v - rig.height_px + 0.5) < 2 * margin};
    EXPECT_EQ(truth.occupied(ix, iy), 0);
    if (!undecided) {
      EXPECT_EQ(truth.state(ix, iy), in_image ? seen_free : hidden) << x << " " << y;
    }
    if (!undecided) {
      EXPECT_EQ(truth.free_points(ix, iy), in_image ? 9 : 0) << x << " " << y;
    }
  }
}

TEST(TruthCells, NothingIsKnownBehindAWall) {
  const Scene scene{parse_scene("wall")};
  const GridGeometry grid{scene.truth_grid().geometry};
  const FrameTruth truth{scene.truth(0)};
  int occupied_seen{0};
  for (int iy{0}; iy < grid.ny; ++iy) {
    EXPECT_EQ(truth.occupied(39, iy), 0);
    EXPECT_EQ(truth.occupied(40, iy), 1);  // the face lies on the border at 8 m
    EXPECT_EQ(truth.occupied(41, iy), 1);
    EXPECT_EQ(truth.occupied(42, iy), 0);
    if (truth.state(40, iy) == seen_occupied) ++occupied_seen;
    for (int ix{41}; ix < grid.nx; ++ix) EXPECT_EQ(truth.state(ix, iy), hidden);
    for (int ix{0}; ix < 40; ++ix) EXPECT_NE(truth.state(ix, iy), seen_occupied);
  }
  EXPECT_NEAR(occupied_seen, 50, 1);  // 512 px / 410 px · 8 m / 0.2 m
  EXPECT_EQ(truth.owner(41, 50), truth.objects.front().id);
}

TEST(TruthCells, PersonBehindTheCrateIsSeenThoughItsGroundIsNot) {
  const Scene scene{parse_scene("occlusion")};
  const GridGeometry grid{scene.truth_grid().geometry};
  const FrameTruth truth{scene.truth(0)};
  const TruthObject& crate{truth.objects.at(0)};
  const TruthObject& person{truth.objects.at(1)};
  ASSERT_EQ(crate.kind, "box");
  ASSERT_EQ(person.kind, "pedestrian");
  int cells{0};
  for (std::size_t i{0}; i < truth.state.size(); ++i) {
    if (truth.state.data()[i] == seen_occupied && truth.owner.data()[i] == person.id) ++cells;
  }
  EXPECT_GE(cells, 2);
  const int iy{static_cast<int>((0.1 - grid.y_min_m) / grid.cell_size_m)};
  for (double x{7.1}; x < 8.1; x += 0.2) {
    EXPECT_EQ(truth.state(static_cast<int>(x / grid.cell_size_m), iy), hidden) << x;
  }
  // In each of the person's columns the crate is nearer: a rule that stops at the first obstacle never gets to him.
  const Rig rig{scene.rig()};
  for (int u{0}; u < rig.width_px; ++u) {
    bool person_seen{false};
    bool crate_seen{false};
    for (int v{0}; v < rig.height_px; ++v) {
      if (truth.instance(u, v) == crate.id) crate_seen = true;
      if (truth.instance(u, v) != person.id) continue;
      person_seen = true;
      const double depth{rig.focal_px * rig.baseline_m / truth.disparity(u, v)};
      const double height{rig.camera_height_m - (v - rig.cy_px) * depth / rig.focal_px};
      EXPECT_GT(height, 0.8);
    }
    if (person_seen) {
      EXPECT_TRUE(crate_seen) << u;
    }
  }
  EXPECT_GT(person.pixels, 300);
}

TEST(TruthCells, MoversCarryTheirVelocity) {
  const Scene scene{parse_scene("street")};
  const FrameTruth truth{scene.truth(20)};  // yaw is 0.1: world axes are not the vehicle's
  int moving{0};
  for (std::size_t i{0}; i < truth.state.size(); ++i) {
    const std::int32_t owner{truth.owner.data()[i]};
    EXPECT_EQ(owner != 0, truth.occupied.data()[i] == 1);
    const double vx{owner == 0 ? 0 : truth.objects.at(static_cast<std::size_t>(owner) - 1).vx_mps};
    const double vy{owner == 0 ? 0 : truth.objects.at(static_cast<std::size_t>(owner) - 1).vy_mps};
    EXPECT_FLOAT_EQ(truth.velocity_x.data()[i], static_cast<float>(vx));
    EXPECT_FLOAT_EQ(truth.velocity_y.data()[i], static_cast<float>(vy));
    if (vx != 0 || vy != 0) ++moving;
  }
  EXPECT_GT(moving, 2);
}

class CellRules : public testing::TestWithParam<const char*> {};

TEST_P(CellRules, Hold) {
  const Scene scene{parse_scene(GetParam())};
  for (std::size_t index{0}; index < scene.size(); index += 9) {
    const FrameTruth truth{scene.truth(index)};
    for (std::size_t i{0}; i < truth.state.size(); ++i) {
      const bool pixels{truth.pixels.data()[i] > 0};
      const bool occupied{truth.occupied.data()[i] == 1};
      EXPECT_EQ(truth.state.data()[i] == seen_occupied, pixels);
      EXPECT_EQ(truth.state.data()[i] == seen_free, !occupied && !pixels && truth.free_points.data()[i] >= 5);
      if (pixels) {
        EXPECT_TRUE(occupied);
      }
      EXPECT_EQ(truth.seen_object.data()[i] != 0, pixels);
      if (pixels) {
        EXPECT_EQ(truth.seen_object.data()[i], truth.owner.data()[i]);
      }
    }
    for (std::size_t i{0}; i < truth.objects.size(); ++i) {
      const TruthObject& object{truth.objects[i]};
      EXPECT_EQ(object.id, static_cast<std::int64_t>(i) + 1);
      EXPECT_GE(object.footprint.size(), 4U) << object.kind;
      EXPECT_GT(object.height_m, 0.15);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, CellRules, testing::Values("crossing", "occlusion", "street?pitch_deg=3", "wall"));

TEST(TruthCells, PixelsFallWhereTheirObjectStands) {
  // An independent count: from disparity and column to a cell, as a reader of the files would.
  const Scene scene{parse_scene("crossing")};
  const Rig rig{scene.rig()};
  const GridGeometry grid{scene.truth_grid().geometry};
  const FrameTruth truth{scene.truth(20)};
  int checked{0};
  int agreeing{0};
  for (const auto [u, v] : raster(rig.width_px, rig.height_px)) {
    if (truth.instance(u, v) == 0) continue;
    const double x{rig.focal_px * rig.baseline_m / truth.disparity(u, v)};
    const double y{-(u - rig.cx_px) * x / rig.focal_px};
    const double z{rig.camera_height_m - (v - rig.cy_px) * x / rig.focal_px};
    const int ix{static_cast<int>(std::floor((x - grid.x_min_m) / grid.cell_size_m))};
    const int iy{static_cast<int>(std::floor((y - grid.y_min_m) / grid.cell_size_m))};
    if (z < 0.15 || z > 1.8 || ix < 0 || iy < 0 || ix >= grid.nx || iy >= grid.ny) continue;
    ++checked;
    if (truth.state(ix, iy) == seen_occupied) ++agreeing;
  }
  EXPECT_GT(checked, 2000);
  EXPECT_GT(agreeing, 0.97 * checked);
}

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
  for (const auto [u, v] : raster(truth.instance)) {
    if (truth.instance(u, v) != id) continue;
    sum += u;
    ++count;
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
