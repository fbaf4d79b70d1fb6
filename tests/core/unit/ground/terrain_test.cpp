// SPDX-License-Identifier: Apache-2.0
//
// Walks over disparities that are computed from height profiles. A car's camera has f·b = 85 px·m, a robot's 37 px·m.
#include "support.hpp"
#include "terrain_walk.hpp"

namespace stereogrid::test {
namespace {

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

float ditch_in_ramp(float x, float y) {
  return ramp(2, 8)(x, y) + ditch(6, 1.3f)(x, y);
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
                                         Edge{"ditch 1.3 m in a ramp", ditch_in_ramp, 6, 7.8, false},
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

TEST(Terrain, NothingIsVisibleBetweenAnEdgeAndTheSurfaceBehindIt) {
  const Vehicle vehicle{car()};
  const HeightField beside{[](float x, float y) { return y > 1 ? ditch_in_ramp(x, y) : ramp(2, 8)(x, y); }};
  const Seen seen{walked(vehicle, smeared(disparity_of(vehicle.rig, beside)))};
  for_cells(vehicle, 6.4, 7.2, [&](int ix, int iy, Point2 place) {
    if (place.y < 1.4) return;
    EXPECT_NE(seen.kind(ix, iy), TerrainClass::drivable) << place.x << " " << place.y;
  });
}

// The smear of an edge that lies aslant is a flight of steps, each lower than what a wheel climbs.
TEST(Terrain, BridgesWithoutGroundBetweenThemAreOneFall) {
  const Vehicle vehicle{car()};
  const HeightField pit{[](float x, float y) { return y > 1 && x > 4 + 0.6f * y ? -0.3f : 0.0f; }};
  const Seen seen{walked(vehicle, smeared(disparity_of(vehicle.rig, pit)))};
  Share drivable;
  for_cells(vehicle, 4.5, 8, [&](int ix, int iy, Point2 place) {
    if (place.y < 1.4 || place.x < 4.5 + 0.6 * place.y) return;
    drivable.add(seen.kind(ix, iy) == TerrainClass::drivable);
  });
  EXPECT_LE(drivable.value(), 0.3) << "0.56 where each bridge counts alone";
}

TEST(Terrain, WaysBetweenEdgesAreAsWideAsAVehicleIsHigh) {
  const Vehicle vehicle{car()};
  const auto bridge = [](float width_m) {
    return HeightField{[=](float x, float y) { return std::abs(y) < width_m / 2 ? 0.0f : ditch(4, 2)(x, y); }};
  };
  EXPECT_EQ(drivable_share(vehicle, walked(vehicle, bridge(0.4f), false), 6.4, 8), 0);
  EXPECT_GE(drivable_share(vehicle, walked(vehicle, bridge(2.5f), false), 6.4, 8), 0.9);
  EXPECT_EQ(drivable_share(vehicle, walked(vehicle, bridge(1.5f), false), 6.4, 8), 0);
  const Seen narrow{walked(vehicle, bridge(0.4f), false)};
  for (const int iy : {49, 50}) {
    for (int ix{22}; ix < 30; ++ix) EXPECT_EQ(narrow.kind(ix, iy), TerrainClass::hidden) << ix;
  }
}

TEST(Terrain, ColumnsAreGroundFromWhereTheRightCameraSeesThem) {
  const Vehicle vehicle{car()};
  const Rig& rig{vehicle.rig};
  const Seen seen{walked(vehicle, ramp(5, 0), false)};
  const double half_m{vehicle.grid.cell_size_m / 2};
  Share ground;
  for (int iy{0}; iy < vehicle.grid.ny; ++iy) {
    for (int ix{0}; ix < vehicle.grid.nx; ++ix) {
      const Point2 at{vehicle.grid.centre(ix, iy)};
      if (at.x < 3 || at.x > 8 || at.y < 0) continue;
      const double first{rig.cx_px - rig.focal_px * (at.y + half_m) / (at.x - half_m)};
      const double last{rig.cx_px - rig.focal_px * (at.y - half_m) / (at.x + half_m)};
      const double unseen{rig.focal_px * rig.baseline_m / (at.x - half_m)};
      if (last < unseen - sector_px) {
        EXPECT_NE(seen.kind(ix, iy), TerrainClass::drivable) << at.x << ' ' << at.y;
      }
      if (first > unseen + samples_min && first < unseen + 4 * sector_px)
        ground.add(seen.kind(ix, iy) == TerrainClass::drivable);
    }
  }
  EXPECT_GT(ground.all, 20);
  EXPECT_GE(ground.value(), 0.95);
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

// A slope begins between the vehicle and the first visible ground.
TEST(Terrain, WalksBeginOnASlopeThatFillsTheView) {
  constexpr float begin_m{0.2f};
  const Vehicle vehicle{robot()};
  for (const float degrees : {-8.0f, -5.5f, 5.5f, 10.0f}) {
    const float radians{degrees * 3.14159265f / 180};
    const Ground slope{vehicle.rig.camera_height_m * std::cos(radians) + begin_m * std::sin(radians), radians, 0};
    const Image<float> disparity{disparity_of(vehicle.rig, ramp(begin_m, degrees))};
    const Seen seen{walked(vehicle, disparity, &slope)};
    EXPECT_GE(drivable_share(vehicle, seen, vehicle.near_m + 0.2, 1.8), 0.99) << degrees;
    EXPECT_NEAR(relief_at(vehicle, seen, 1.5), (1.5 - begin_m) * tangent_of(degrees), 0.02) << degrees;
    if (degrees > 0) continue;
    EXPECT_LT(drivable_share(vehicle, walked(vehicle, disparity), vehicle.near_m, 1.8), 0.1) << "as level ground";
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

TEST(Terrain, WithoutDisparitiesNothingIsSeen) {
  const Vehicle vehicle{car()};
  const Seen seen{walked(vehicle, Image<float>{vehicle.rig.width_px, vehicle.rig.height_px})};
  for (const TerrainClass kind : seen.kind) EXPECT_EQ(kind, TerrainClass::unknown);
  for (const float z : seen.elevation_m) EXPECT_TRUE(std::isnan(z));
}

}  // namespace
}  // namespace stereogrid::test
