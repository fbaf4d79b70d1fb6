// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Walks over disparities that are computed from height profiles. A car's camera has f·b = 85 px·m, a robot's 37 px·m.
#include "terrain/terrain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "terrain/frame_terrain.hpp"
#include "terrain/rules.hpp"
#include "terrain_scene.hpp"

namespace stereogrid::test {
namespace {

float tangent_of(float degrees) {
  return std::tan(degrees * 3.14159265f / 180);
}

struct Vehicle {
  Rig rig;
  TerrainLimits limits;
  GridGeometry grid;
  double near_m;    ///< first range that is scored
  double far_m;     ///< last one
  double margin_m;  ///< around an edge
};

Vehicle car() {
  return {{640, 360, 425, 320, 180, 0.2, 1.0, 0, 0},
          {0.15f, tangent_of(20), 1.8f, tangent_of(6)},
          {0, -10, 0.2, 100, 100},
          2.8,
          8,
          0.4};
}

Vehicle robot() {
  return {{640, 400, 411, 320, 142, 0.09, 0.35, 0, 0},
          {0.03f, tangent_of(20), 0.5f, tangent_of(6)},
          {0, -3, 0.05, 120, 120},
          0.6,
          2,
          0.1};
}

struct Seen {
  Image<float> elevation_m;
  Image<float> sigma_m;
  Image<TerrainClass> kind;
  Image<std::int16_t> relief;
};

Seen walked(const Vehicle& vehicle, const Image<float>& disparity) {
  const GridGeometry& grid{vehicle.grid};
  Seen seen{{grid.nx, grid.ny}, {grid.nx, grid.ny}, {grid.nx, grid.ny}, {}};
  const Image<float> none{disparity.width(), disparity.height()};
  Terrain terrain{vehicle.rig,
                  vehicle.limits,
                  static_cast<float>(grid.cell_size_m),
                  static_cast<float>(grid.nx * grid.cell_size_m),
                  64,
                  9};
  const auto in_order = [](int count, const auto& work) { work(0, count); };
  Ground ground;
  ground.height_m = vehicle.rig.camera_height_m;
  terrain.find(disparity.view(), none.view(), ground, in_order);
  terrain.visit(grid_in_vehicle(grid, {}), 0, grid.ny, [&](int ix, int iy, const CellGround& cell) {
    seen.elevation_m(ix, iy) = cell.elevation_m;
    seen.sigma_m(ix, iy) = cell.sigma_m;
    seen.kind(ix, iy) = cell.kind;
  });
  const View<const std::int16_t> rows{terrain.relief().rows};
  seen.relief = {rows.width, rows.height};
  for (int sector{0}; sector < rows.height; ++sector) {
    std::copy_n(rows.row(sector), rows.width, seen.relief.row(sector));
  }
  return seen;
}

Seen walked(const Vehicle& vehicle, const HeightField& height, bool has_errors) {
  Image<float> disparity{disparity_of(vehicle.rig, height)};
  if (has_errors) add_errors(0.25f, 7, disparity);
  return walked(vehicle, disparity);
}

struct Share {
  int of{0};
  int all{0};

  void add(bool is_one) {
    ++all;
    of += is_one ? 1 : 0;
  }
  [[nodiscard]] double value() const { return all > 0 ? static_cast<double>(of) / all : -1; }
};

/// Calls visit(ix, iy, place) for the cells in view between two ranges.
template <class Visit>
void for_cells(const Vehicle& vehicle, double from_m, double to_m, const Visit& visit) {
  for (int iy{0}; iy < vehicle.grid.ny; ++iy) {
    for (int ix{0}; ix < vehicle.grid.nx; ++ix) {
      const Point2 place{vehicle.grid.centre(ix, iy)};
      if (place.x >= from_m && place.x < to_m && std::abs(place.y) < 0.6 * place.x) visit(ix, iy, place);
    }
  }
}

double drivable_share(const Vehicle& vehicle, const Seen& seen, double from_m, double to_m) {
  Share share;
  for_cells(vehicle, from_m, to_m,
            [&](int ix, int iy, Point2) { share.add(seen.kind(ix, iy) == TerrainClass::drivable); });
  return share.value();
}

/// Share of the grid's rows with a cell of `kind` within the margin of `x`.
double marked_share(const Vehicle& vehicle, const Seen& seen, double x, TerrainClass kind) {
  Share share;
  for (int iy{0}; iy < vehicle.grid.ny; ++iy) {
    if (std::abs(vehicle.grid.centre(0, iy).y) > 0.5 * x) continue;
    bool is_marked{false};
    for (int ix{0}; ix < vehicle.grid.nx; ++ix) {
      const bool is_near{std::abs(vehicle.grid.centre(ix, iy).x - x) < vehicle.margin_m + vehicle.grid.cell_size_m};
      is_marked = is_marked || (is_near && seen.kind(ix, iy) == kind);
    }
    share.add(is_marked);
  }
  return share.value();
}

HeightField ramp(float foot_m, float degrees) {
  return [=](float x, float) { return std::max(x - foot_m, 0.0f) * tangent_of(degrees); };
}

HeightField step(float at_m, float rise_m) {
  return [=](float x, float) { return x < at_m ? 0.0f : rise_m; };
}

HeightField ditch(float at_m, float width_m) {
  return [=](float x, float) { return x > at_m && x < at_m + width_m ? -0.8f : 0.0f; };
}

HeightField stairs(float at_m, float rise_m) {
  return [=](float x, float) { return x < at_m ? 0.0f : rise_m * std::min(8.0f, 1 + std::floor((x - at_m) / 0.3f)); };
}

struct Surface {
  std::string name;
  HeightField height;
};

void PrintTo(const Surface& surface, std::ostream* out) {
  *out << surface.name;
}

class Drivable : public testing::TestWithParam<Surface> {};

TEST_P(Drivable, IsFree) {
  const Vehicle vehicle{car()};
  for (const bool has_errors : {false, true}) {
    const Seen seen{walked(vehicle, GetParam().height, has_errors)};
    EXPECT_GE(drivable_share(vehicle, seen, vehicle.near_m, vehicle.far_m), has_errors ? 0.985 : 0.999);
    EXPECT_GE(drivable_share(vehicle, seen, vehicle.far_m, 13), has_errors ? 0.96 : 0.999);
  }
}

INSTANTIATE_TEST_SUITE_P(Car, Drivable,
                         testing::Values(Surface{"flat", ramp(5, 0)}, Surface{"ramp 2", ramp(5, 2)},
                                         Surface{"ramp 5", ramp(5, 5)}, Surface{"ramp 12", ramp(5, 12)},
                                         Surface{"descent 2", ramp(5, -2)}, Surface{"descent 5", ramp(5, -5)},
                                         Surface{"descent 8", ramp(4, -8)}, Surface{"kerb up", step(5, 0.1f)},
                                         Surface{"kerb down", step(5, -0.1f)}));

struct Edge {
  std::string name;
  HeightField height;
  double at_m;
  double hidden_to_m;  ///< ground beyond may be connected again
  bool is_robot;
};

void PrintTo(const Edge& edge, std::ostream* out) {
  *out << edge.name;
}

class Edges : public testing::TestWithParam<Edge> {};

TEST_P(Edges, AreMarkedAndNothingBehindIsDrivable) {
  const Edge& edge{GetParam()};
  const Vehicle vehicle{edge.is_robot ? robot() : car()};
  for (const bool has_errors : {false, true}) {
    const Seen seen{walked(vehicle, edge.height, has_errors)};
    EXPECT_GE(marked_share(vehicle, seen, edge.at_m, TerrainClass::drop), 0.95);
    EXPECT_EQ(drivable_share(vehicle, seen, edge.at_m + vehicle.margin_m, edge.hidden_to_m), 0);
    EXPECT_GE(drivable_share(vehicle, seen, vehicle.near_m, edge.at_m - 2 * vehicle.margin_m), 0.98);
  }
}

INSTANTIATE_TEST_SUITE_P(Car, Edges,
                         testing::Values(Edge{"platform 0.25 m at 4 m", step(4, -0.25f), 4, 20, false},
                                         Edge{"platform 1 m at 6 m", step(6, -1), 6, 20, false},
                                         Edge{"cliff at 6 m", step(6, -3.5f), 6, 20, false},
                                         Edge{"stairs down at 5 m", stairs(5, -0.17f), 5, 20, false},
                                         Edge{"ditch 0.6 m at 4 m", ditch(4, 0.6f), 4, 6, false},
                                         Edge{"ditch 1 m at 5.5 m", ditch(5.5f, 1), 5.5, 7.5, false},
                                         Edge{"robot, 0.1 m at 1 m", step(1, -0.1f), 1, 6, true},
                                         Edge{"robot, 0.9 m at 1.8 m", step(1.8f, -0.9f), 1.8, 6, true}));

/// A jump to a farther surface turned into a slope over the eight rows before it, as a matcher leaves it.
Image<float> smeared(Image<float> disparity) {
  constexpr int rows{8};
  for (int v{1}; v + rows < disparity.height(); ++v) {
    for (int u{0}; u < disparity.width(); ++u) {
      const float behind{disparity(u, v - 1)};
      const float before{disparity(u, v + rows)};
      if (disparity(u, v) - behind < 0.8f) continue;
      for (int i{0}; i < rows; ++i) disparity(u, v + i) = behind + (before - behind) * static_cast<float>(i) / rows;
    }
  }
  return disparity;
}

TEST(Terrain, TrenchesAreDropsThoughTheMatcherSmearsTheirEdges) {
  const Vehicle vehicle{car()};
  const Seen trench{walked(vehicle, smeared(disparity_of(vehicle.rig, ditch(5.6f, 0.8f))))};
  EXPECT_GE(marked_share(vehicle, trench, 5.6, TerrainClass::drop), 0.95);
  EXPECT_EQ(drivable_share(vehicle, trench, 6, 8), 0);
  // a hollow has no upright wall, a step that the vehicle climbs none below the ground
  const HeightField hollow{[](float x, float) { return -0.12f * std::max(0.0f, 1 - std::abs(x - 6)); }};
  const Seen level{walked(vehicle, smeared(disparity_of(vehicle.rig, hollow)))};
  EXPECT_GE(drivable_share(vehicle, level, vehicle.near_m, 8), 0.99);
  const Seen kerb{walked(vehicle, smeared(disparity_of(vehicle.rig, step(5.6f, 0.1f))))};
  EXPECT_GE(drivable_share(vehicle, kerb, vehicle.near_m, 8), 0.99);
}

TEST(Terrain, PassagesBetweenEdgesAreAsWideAsAVehicle) {
  const Vehicle vehicle{car()};
  const auto bridge = [](float width_m) {
    return HeightField{[=](float x, float y) { return std::abs(y) < width_m / 2 ? 0.0f : ditch(4, 2)(x, y); }};
  };
  EXPECT_EQ(drivable_share(vehicle, walked(vehicle, bridge(0.4f), false), 6.4, 8), 0);
  EXPECT_GE(drivable_share(vehicle, walked(vehicle, bridge(2.5f), false), 6.4, 8), 0.9);
  EXPECT_GE(drivable_share(vehicle, walked(vehicle, bridge(1.1f), false), 6.4, 8), 0.9) << "from 0.4 heights on";
  const Seen narrow{walked(vehicle, bridge(0.4f), false)};
  for (const int iy : {49, 50}) {
    for (int ix{22}; ix < 30; ++ix) EXPECT_EQ(narrow.kind(ix, iy), TerrainClass::hidden) << ix;
  }
}

// Wrong matches look like edges in a sector or two; three sectors are 0.25 m.
TEST(Terrain, HolesOfTwoSectorsAreNoEdges) {
  const Vehicle vehicle{car()};
  const auto drops_of = [&](float width_m) {
    const HeightField hole{[=](float x, float y) { return std::abs(y) < width_m / 2 ? ditch(4.5f, 1)(x, y) : 0.0f; }};
    const Seen seen{walked(vehicle, hole, false)};
    return std::ranges::count(seen.kind, TerrainClass::drop);
  };
  for (const float width_m : {0.16f, 0.25f}) EXPECT_EQ(drops_of(width_m), 0) << width_m;
  EXPECT_GT(drops_of(0.8f), 3);
}

TEST(Terrain, GroundWithoutSamplesIsUnknown) {
  const Vehicle vehicle{car()};
  Image<float> disparity{disparity_of(vehicle.rig, ramp(5, 0))};
  for (float& d : disparity) {
    if (d > 85 / 6.0f && d < 85 / 5.0f) d = 0;
  }
  const Seen seen{walked(vehicle, disparity)};
  EXPECT_GE(drivable_share(vehicle, seen, vehicle.near_m, 4.8), 0.99);
  EXPECT_EQ(drivable_share(vehicle, seen, 5.2, 5.8), 0);
  EXPECT_GE(drivable_share(vehicle, seen, 6.4, 8), 0.99) << "the same surface";
}

TEST(Terrain, StepsUpAreObstacles) {
  for (const bool has_errors : {false, true}) {
    EXPECT_EQ(marked_share(car(), walked(car(), step(4, 0.25f), has_errors), 4, TerrainClass::obstacle), 1);
    EXPECT_EQ(marked_share(car(), walked(car(), stairs(5, 0.17f), has_errors), 5, TerrainClass::obstacle), 1);
    EXPECT_EQ(marked_share(robot(), walked(robot(), step(1.2f, 0.05f), has_errors), 1.2, TerrainClass::obstacle), 1);
  }
}

TEST(Terrain, BoxOnARampIsAnObstacleAndTheRampBesideItIsFree) {
  const Vehicle vehicle{car()};
  const auto is_box = [](double x, double y) { return x > 7 && x < 7.5 && std::abs(y) < 0.4; };
  const HeightField height{[&](float x, float y) { return ramp(5, 8)(x, y) + (is_box(x, y) ? 0.5f : 0.0f); }};
  const Seen seen{walked(vehicle, height, true)};
  int rows_found{0};
  for (int iy{0}; iy < vehicle.grid.ny; ++iy) {
    bool is_found{false};
    for (int ix{0}; ix < vehicle.grid.nx; ++ix) {
      const Point2 place{vehicle.grid.centre(ix, iy)};
      const bool is_front{std::abs(place.x - 7) < vehicle.margin_m && std::abs(place.y) < 0.35};
      is_found = is_found || (is_front && seen.kind(ix, iy) == TerrainClass::obstacle);
    }
    rows_found += is_found ? 1 : 0;
  }
  EXPECT_EQ(rows_found, 4);
  Share free;
  for_cells(vehicle, 6, 9, [&](int ix, int iy, Point2 place) {
    if (std::abs(place.y) > 0.9) free.add(seen.kind(ix, iy) == TerrainClass::drivable);
  });
  EXPECT_GE(free.value(), 0.98);
}

/// Height of the relief in the middle of the image, m.
double relief_at(const Vehicle& vehicle, const Seen& seen, double x) {
  const double disparity{vehicle.rig.focal_px * vehicle.rig.baseline_m / x};
  return seen.relief(static_cast<int>(2 * disparity), seen.relief.height() / 2) * vehicle.rig.baseline_m / disparity;
}

TEST(Terrain, ReliefOfARampIsItsElevation) {
  const Vehicle vehicle{car()};
  for (const float degrees : {5.0f, 10.0f, 15.0f}) {
    const Seen seen{walked(vehicle, ramp(4, degrees), true)};
    for (const double x : {3.5, 6.0, 8.0, 10.0}) {
      const double expected{std::max(x - 4, 0.0) * tangent_of(degrees)};
      EXPECT_NEAR(relief_at(vehicle, seen, x), expected, 0.06 + 0.02 * x) << degrees << "° " << x << " m";
    }
  }
}

TEST(Terrain, LevelGroundAndNarrowRisesHaveNoRelief) {
  const Vehicle vehicle{car()};
  const HeightField flat{[](float, float) { return 0.0f; }};
  const HeightField verge{[](float, float y) { return std::abs(y) < 1 ? 0.0f : 0.3f; }};
  const HeightField wall{[](float x, float) { return x < 8 ? 0.0f : 2.0f; }};
  for (const HeightField& height : {flat, verge, wall}) {
    const Seen seen{walked(vehicle, height, true)};
    for (double x{3}; x < 10; x += 0.5) EXPECT_LT(std::abs(relief_at(vehicle, seen, x)), 0.05) << x << " m";
  }
}

TEST(Terrain, StonesAreObstacles) {
  const Vehicle vehicle{robot()};
  const auto middle_of = [](int i) { return Point2{0.9 + 0.13 * i, -0.4 + std::fmod(0.37 * i, 0.8)}; };
  const HeightField height{[&](float x, float y) {
    float z{0};
    for (int i{0}; i < 8; ++i) {
      const float away{static_cast<float>(std::hypot(x - middle_of(i).x, y - middle_of(i).y)) / 0.06f};
      if (away < 1) z = std::max(z, 0.08f * std::sqrt(1 - away * away));
    }
    return z;
  }};
  const Seen seen{walked(vehicle, height, true)};
  Share found;
  for (int i{0}; i < 8; ++i) {
    bool is_found{false};
    for_cells(vehicle, middle_of(i).x - 0.12, middle_of(i).x + 0.12, [&](int ix, int iy, Point2 place) {
      is_found = is_found || (std::abs(place.y - middle_of(i).y) < 0.1 && seen.kind(ix, iy) == TerrainClass::obstacle);
    });
    found.add(is_found);
  }
  EXPECT_EQ(found.value(), 1);
}

TEST(Terrain, ElevationIsThatOfTheSurfaceWithinItsDeviation) {
  const Vehicle vehicle{car()};
  const HeightField height{ramp(5, 8)};
  const Seen seen{walked(vehicle, height, true)};
  double squares{0};
  int count{0};
  for_cells(vehicle, vehicle.near_m, 12, [&](int ix, int iy, Point2 place) {
    if (seen.kind(ix, iy) != TerrainClass::drivable) return;
    const double truth{height(static_cast<float>(place.x), 0)};
    const double error{(seen.elevation_m(ix, iy) - truth) / seen.sigma_m(ix, iy)};
    squares += error * error;
    ++count;
  });
  ASSERT_GT(count, 500);
  EXPECT_LT(squares / count, 1.5);
}

TEST(Terrain, DeviationGrowsWithTheNoiseOfTheFrame) {
  const Vehicle vehicle{car()};
  const auto sigma_with = [&](float noise_px) {
    Image<float> disparity{disparity_of(vehicle.rig, ramp(5, 0))};
    add_errors(noise_px, 7, disparity);
    const Seen seen{walked(vehicle, disparity)};
    double sum{0};
    int count{0};
    for_cells(vehicle, 3, 6, [&](int ix, int iy, Point2) {
      if (seen.kind(ix, iy) != TerrainClass::drivable) return;
      sum += seen.sigma_m(ix, iy);
      ++count;
    });
    return sum / count;
  };
  EXPECT_GT(sigma_with(0.7f), 1.5 * sigma_with(0.2f));
}

// Three standard deviations of the elevation are a step at 14 m.
TEST(Terrain, ObstaclesAreMarkedAsFarAsTheNoiseAllows) {
  const auto share_at = [](float at_m) {
    const HeightField box{[=](float x, float) { return x < at_m || x > at_m + 1 ? 0.0f : 0.5f; }};
    return marked_share(car(), walked(car(), box, false), at_m, TerrainClass::obstacle);
  };
  EXPECT_EQ(share_at(12), 1);
  EXPECT_EQ(share_at(18), 0);
}

TEST(Terrain, RingsAreAsLongAsACellTwoDeviationsOrTwoRows) {
  const Rig rig{car().rig};
  Ground ground;
  ground.height_m = rig.camera_height_m;
  const TerrainCamera camera{rig, ground};
  Rings rings{0.2f, 20, 64};
  rings.place(camera, 2.4f);
  ASSERT_GT(rings.count(), 20);
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float x{rings.begin_m(ring)};
    const float length{std::max({0.2f, 2 * 0.3f * x * x / 85, 2 * x * x / 425})};
    const float sixteenth_px{x * x / 85 / 16};
    EXPECT_GE(rings.end_m(ring) - x, length - 1e-4f);
    EXPECT_LE(rings.end_m(ring) - x, length + 1.5f * sixteenth_px + 1e-3f) << x;
  }
}

// P(occupied) before and after a rule.
TEST(CellRules, BoundTheObservedOccupancy) {
  const auto expect = [](CellRule rule, float before, float after) { EXPECT_EQ(ruled(before, rule), after) << before; };
  for (const float p : {0.01f, 0.2f, 0.3f, 0.5f, 0.9f}) expect(CellRule::as_observed, p, p);
  for (const float p : {0.01f, 0.2f, 0.5f, 0.9f}) expect(CellRule::ground_not_seen, p, p);
  for (const float p : {0.21f, 0.3f, 0.49f}) expect(CellRule::ground_not_seen, p, 0.5f);
  for (const float p : {0.01f, 0.3f}) expect(CellRule::not_free, p, 0.5f);
  expect(CellRule::not_free, 0.9f, 0.9f);
  expect(CellRule::free, 0.1f, 0.1f);
  expect(CellRule::free, 0.9f, 0.2f);
  for (const CellRule rule : {CellRule::obstacle, CellRule::edge}) {
    expect(rule, 0.1f, 0.7f);
    expect(rule, 0.9f, 0.9f);
  }
}

/// The stage of a frame with a height field ahead.
struct FrameOf {
  explicit FrameOf(const HeightField& height) : terrain{vehicle.rig, config(), vehicle.grid, 8} {
    const GridGeometry& grid{vehicle.grid};
    FrameResult result;
    result.elevation_m = result.elevation_sigma_m = Image<float>{grid.nx, grid.ny};
    result.terrain = Image<TerrainClass>{grid.nx, grid.ny};
    Ground ground;
    ground.height_m = vehicle.rig.camera_height_m;
    const Image<float> none{vehicle.rig.width_px, vehicle.rig.height_px};
    const auto in_order = [](int count, const auto& work) { work(0, count); };
    terrain.find(disparity_of(vehicle.rig, height).view(), none.view(), ground, grid_in_vehicle({0, 0, 0.2, 8, 8}, {}),
                 in_order, result);
  }
  static Config config() {
    Config config;
    config.matching.disparities = 64;
    return config;
  }
  [[nodiscard]] CellRule rule_at(double x) const {
    return terrain.rules().vehicle(static_cast<int>(x / vehicle.grid.cell_size_m), vehicle.grid.ny / 2);
  }

  Vehicle vehicle{car()};
  FrameTerrain terrain;
};

TEST(Terrain, RaisedGroundIsFreeAndLevelGroundAsObserved) {
  const FrameOf frame{ramp(4, 10)};
  for (const double x : {3.5, 4.5}) EXPECT_EQ(frame.rule_at(x), CellRule::as_observed) << "up to 9 cm";
  for (const double x : {5.5, 7.0, 9.0}) EXPECT_EQ(frame.rule_at(x), CellRule::free) << x;
}

TEST(Terrain, EdgesHaveTheVisibleFall) {
  const FrameOf frame{step(4, -0.25f)};
  ASSERT_GT(frame.terrain.edges().size(), 40u);
  for (const EdgePoint& edge : frame.terrain.edges()) {
    EXPECT_NEAR(edge.place.x, 4, 0.4);
    EXPECT_NEAR(edge.fall_m, 0.25, 0.1);
  }
}

TEST(Terrain, WithoutDisparitiesNothingIsSeen) {
  const Vehicle vehicle{car()};
  const Seen seen{walked(vehicle, Image<float>{vehicle.rig.width_px, vehicle.rig.height_px})};
  for (const TerrainClass kind : seen.kind) EXPECT_EQ(kind, TerrainClass::unknown);
  for (const float z : seen.elevation_m) EXPECT_TRUE(std::isnan(z));
}

}  // namespace
}  // namespace stereogrid::test
