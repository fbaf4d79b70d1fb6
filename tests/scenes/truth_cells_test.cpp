// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
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
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px; ++u) {
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
  }
  EXPECT_GT(checked, 2000);
  EXPECT_GT(agreeing, 0.97 * checked);
}

}  // namespace
}  // namespace stereogrid::scenes
