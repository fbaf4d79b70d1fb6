// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::scenes {
namespace {

/// The last frame of a scene, by cells whose centres are looked up in the vehicle frame.
struct Truth {
  explicit Truth(const std::string& text)
      : scene{parse_scene("scene:terrain?" + text)},
        grid{scene.truth_grid().geometry},
        truth{scene.truth(scene.size() - 1)} {}

  [[nodiscard]] TerrainCell at(double x, double y) const {
    const CellIndex cell{*grid.cell_at({x, y})};
    return static_cast<TerrainCell>(truth.terrain(cell.ix, cell.iy));
  }
  [[nodiscard]] float elevation(double x, double y) const {
    const CellIndex cell{*grid.cell_at({x, y})};
    return truth.elevation_m(cell.ix, cell.iy);
  }
  [[nodiscard]] float step(double x, double y) const {
    const CellIndex cell{*grid.cell_at({x, y})};
    return truth.step_m(cell.ix, cell.iy);
  }
  [[nodiscard]] int count(TerrainCell cell) const {
    return static_cast<int>(std::ranges::count(truth.terrain, static_cast<std::uint8_t>(cell)));
  }

  Scene scene;
  GridGeometry grid;
  FrameTruth truth;
};

using enum TerrainCell;

TEST(TerrainTruth, ADitchIsAnEdgeAndWhatLiesBeyond) {
  const Truth ditch{"kind=ditch&depth=0.8&span=1&at=5"};
  const double half_width{256.0 / 410};  // half of the view's width, per metre ahead
  for (double x{4.1}; x < 15; x += 0.2) {
    for (double y{-8.9}; y < 9; y += 0.2) {
      if (std::abs(std::abs(y) - half_width * x) < 0.4) continue;
      const TerrainCell expected{std::abs(y) > half_width * x ? hidden : x < 5 ? drivable : x < 5.2 ? drop : beyond};
      ASSERT_EQ(ditch.at(x, y), expected) << x << " " << y;
      ASSERT_NEAR(ditch.elevation(x, y), x > 5 && x < 6 ? -0.8 : 0, 1e-6) << x;
      ASSERT_NEAR(ditch.step(x, y), expected == drop ? -0.8 : 0, 1e-6) << x;
    }
  }
}

TEST(TerrainTruth, AShallowDitchIsDrivable) {
  EXPECT_EQ(Truth{"kind=ditch&depth=0.1&span=1&at=5"}.count(drop), 0);
  EXPECT_EQ(Truth{"kind=ditch&depth=0.1&span=1&at=5"}.at(7.1, 0.1), drivable);
  EXPECT_GT(Truth{"kind=ditch&depth=0.1&span=0.2&at=1.5&camera=robot"}.count(drop), 10);
}

TEST(TerrainTruth, StepsUpHideWhatTheyDoNotBound) {
  const Truth kerb{"kind=kerb&rise=0.25&at=6"};
  EXPECT_EQ(kerb.at(5.9, 0.1), drivable);
  EXPECT_EQ(kerb.at(6.1, 0.1), obstacle);
  EXPECT_NEAR(kerb.step(6.1, 0.1), 0.25, 1e-6);
  EXPECT_EQ(kerb.at(8.1, 0.1), hidden) << "seen, but out of reach";
  EXPECT_EQ(kerb.count(beyond), 0);
  const Truth low{"kind=kerb&rise=0.1&at=6"};
  EXPECT_EQ(low.at(8.1, 0.1), drivable);
  EXPECT_NEAR(low.elevation(8.1, 0.1), 0.1, 1e-6);
}

TEST(TerrainTruth, StepsOfSeveralHeightsStandSideBySide) {
  const Truth steps{"kind=steps&rise=0.6&at=5&steps=3"};  // 0.2, 0.4 and 0.6 m, from right to left
  EXPECT_EQ(steps.at(5.1, -1.5), obstacle);
  EXPECT_NEAR(steps.step(5.1, -1.5), 0.2, 1e-6);
  EXPECT_NEAR(steps.step(5.1, -0.3), 0.4, 1e-6);
  EXPECT_NEAR(steps.step(5.1, 0.9), 0.6, 1e-6);
  EXPECT_EQ(Truth("kind=steps&rise=-0.6&at=5&steps=3").at(5.1, 0.9), drop);
}

TEST(TerrainTruth, TheFarRimOfAPitIsNoEdge) {
  const Scene scene{parse_scene("scene:course?speed=10&rate=1&frames=2")};
  const FrameTruth truth{scene.truth(1)};
  const GridGeometry grid{scene.truth_grid().geometry};
  // the ditch to the left, 9.67 to 10.47 m ahead
  const auto at{[&](double x, double y) {
    const CellIndex cell{*grid.cell_at({x, y})};
    return static_cast<TerrainCell>(truth.terrain(cell.ix, cell.iy));
  }};
  EXPECT_EQ(at(9.5, 3.1), drivable);
  EXPECT_EQ(at(9.7, 3.1), drop);
  EXPECT_EQ(at(10.1, 3.1), beyond);
  EXPECT_NE(at(10.5, 3.1), drop);
  EXPECT_EQ(at(10.7, 3.1), drivable);
}

TEST(TerrainTruth, SlopesUpToTwentyDegreesAreDrivable) {
  for (const char* slope : {"15", "-15", "8", "-2"}) {
    const Truth ramp{std::string{"kind=ramp&at=3&span=20&slope_deg="} + slope};
    EXPECT_EQ(ramp.count(drop), 0) << slope;
    EXPECT_EQ(ramp.count(obstacle), 0) << slope;
    const double rise_m{std::tan(std::stod(slope) * 0.017453292519943295)};
    EXPECT_NEAR(ramp.elevation(12.1, 0.1), (12.1 - 3.5) * rise_m, 1e-5) << slope;
  }
  EXPECT_EQ(Truth("kind=ramp&at=3&slope_deg=15").at(12.1, 0.1), drivable);
  const Truth steep{"kind=steep&at=5&slope_deg=40"};
  EXPECT_GT(steep.count(obstacle), 20);
  EXPECT_EQ(steep.count(drop), 0);
  const Truth falling{"kind=steep&at=5&slope_deg=-40"};
  EXPECT_GT(falling.count(drop), 20);
  EXPECT_EQ(falling.at(9.1, 0.1), beyond);
}

TEST(TerrainTruth, BodiesAreMeasuredFromTheGroundBelowThem) {
  const Truth box{"kind=box&slope_deg=10&at=6&rise=0.5&span=0.6"};
  EXPECT_EQ(box.at(6.1, 0.1), obstacle);
  EXPECT_EQ(box.at(6.1, 1.1), drivable);
  EXPECT_NEAR(box.truth.objects.front().height_m, 0.5, 1e-9);
  EXPECT_EQ(Truth("kind=bridge").at(6.1, 0.1), drivable);
  EXPECT_EQ(Truth("kind=bridge&rise=1.5").at(5.1, 0.1), obstacle);
  EXPECT_EQ(Truth("kind=table").at(5.1, 0.1), obstacle);
  EXPECT_EQ(Truth("kind=rubble&rise=0.12").count(obstacle), 0);
  EXPECT_GT(Truth("kind=rubble&camera=robot").count(obstacle), 10);
}

TEST(TerrainTruth, GroundBesideAShortDitchIsReached) {
  const Scene scene{parse_scene("scene:course?frames=3&speed=1")};
  const FrameTruth truth{scene.truth(0)};
  EXPECT_GT(std::ranges::count(truth.terrain, static_cast<std::uint8_t>(obstacle)), 0);
  EXPECT_GT(std::ranges::count(truth.terrain, static_cast<std::uint8_t>(drop)), 0);
  const GridGeometry grid{scene.truth_grid().geometry};
  const CellIndex far{*grid.cell_at({14.1, 0.1})};
  EXPECT_EQ(truth.terrain(far.ix, far.iy), static_cast<std::uint8_t>(drivable));
}

TEST(Course, Has24HazardsAnd12HarmlessThings) {
  for (const char* camera : {"car", "robot"}) {
    const Scene scene{parse_scene(std::string{"scene:course?camera="} + camera)};
    const std::vector<TruthZone> zones{scene.truth_grid().zones};
    EXPECT_EQ(zones.size(), 36U);
    EXPECT_EQ(std::ranges::count(zones, true, &TruthZone::is_hazard), 24);
    EXPECT_LT(zones.back().low.x, 170);
    EXPECT_NEAR(static_cast<double>(scene.size()), 170 / (camera[0] == 'c' ? 8 : 1.5) * 10, 1);
  }
}

TEST(TerrainTruth, StateFollowsTheClass) {
  const Truth edge{"kind=edge&at=5"};
  for (std::size_t i{0}; i < edge.truth.terrain.size(); ++i) {
    const auto cell{static_cast<TerrainCell>(edge.truth.terrain.data()[i])};
    const TruthCell state{cell == drivable                   ? TruthCell::seen_free
                          : cell == obstacle || cell == drop ? TruthCell::seen_occupied
                                                             : TruthCell::hidden};
    ASSERT_EQ(edge.truth.state.data()[i], static_cast<std::uint8_t>(state));
  }
}

TEST(TerrainTruth, DisparityIsThatOfTheHeightField) {
  const Truth ramp{"kind=ramp&at=3&span=20&slope_deg=10&pitch_noise_deg=1&roll_noise_deg=1&height_noise=0.02"};
  const Rig rig{ramp.scene.rig()};
  const TruthEgo ego{ramp.truth.ego};
  ASSERT_NE(ego.camera_pitch_rad, 0);
  const double slope{std::tan(10 * 0.017453292519943295)};
  int checked{0};
  for (int v{0}; v < rig.height_px; v += 7) {
    for (int u{0}; u < rig.width_px; u += 11) {
      if (ramp.truth.disparity(u, v) <= 0) continue;
      const double z{rig.focal_px * rig.baseline_m / static_cast<double>(ramp.truth.disparity(u, v))};
      const double right{(u - rig.cx_px) * z / rig.focal_px};
      const double down{(v - rig.cy_px) * z / rig.focal_px};
      const double cr{std::cos(ego.camera_roll_rad)};
      const double sr{std::sin(ego.camera_roll_rad)};
      const double cp{std::cos(ego.camera_pitch_rad)};
      const double sp{std::sin(ego.camera_pitch_rad)};
      const double below{cr * down + sr * right};
      const double x{cp * z - sp * below};
      const double height{ego.camera_height_m - sp * z - cp * below};
      if (x > 15 || (x > 2.9 && x < 4.1)) continue;
      EXPECT_NEAR(height, x < 3 ? 0 : (x - 3.5) * slope, 1e-4) << u << " " << v;
      ++checked;
    }
  }
  EXPECT_GT(checked, 300);
}

TEST(TerrainScene, SuspensionMovesTheCameraAlone) {
  const std::string noisy{"kind=flat&pitch_noise_deg=1&roll_noise_deg=0.5&height_noise=0.02&frames=40"};
  const Scene scene{parse_scene("scene:terrain?width=64&height=40&" + noisy)};
  double pitch{0};
  double height{0};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const TruthEgo ego{scene.truth(i).ego};
    pitch += ego.camera_pitch_rad * ego.camera_pitch_rad / 40;
    height += (ego.camera_height_m - 1.25) * (ego.camera_height_m - 1.25) / 40;
    EXPECT_EQ(ego.pitch_rad, 0);
    EXPECT_EQ(ego.z_m, 0);
  }
  EXPECT_NEAR(std::sqrt(pitch), 0.01745, 0.005);
  EXPECT_NEAR(std::sqrt(height), 0.02, 0.006);
  EXPECT_EQ(scene.rig().camera_pitch_rad, 0);
}

TEST(TerrainScene, EveryKindRenders) {
  for (const std::string& kind : terrain_kinds()) {
    for (const char* camera : {"car", "robot"}) {
      const Scene scene{parse_scene("scene:terrain?width=64&height=40&frames=1&kind=" + kind + "&camera=" + camera)};
      EXPECT_EQ(scene.load(0).left.width(), 64) << kind;
      EXPECT_FALSE(scene.truth(0).terrain.empty()) << kind;
    }
  }
  EXPECT_THROW(static_cast<void>(parse_scene("scene:terrain?kind=ocean")), std::exception);
}

TEST(TerrainScene, RandomLayoutsFollowTheSeed) {
  const auto first_row{[](int seed) {
    const Scene scene{
        parse_scene("scene:terrain?kind=random&width=64&height=40&frames=1&seed=" + std::to_string(seed))};
    return scene.truth(0).elevation_m;
  }};
  EXPECT_EQ(first_row(3), first_row(3));
  int different{0};
  for (int seed{2}; seed < 12; ++seed) different += first_row(seed) == first_row(1) ? 0 : 1;
  EXPECT_GE(different, 5) << "half of the kinds are level";
}

}  // namespace
}  // namespace stereogrid::scenes
