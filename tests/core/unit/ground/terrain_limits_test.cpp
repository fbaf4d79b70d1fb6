// SPDX-License-Identifier: Apache-2.0
//
// Limits of the terrain stage: rings, noise, missing samples, effect on the grids (docs/terrain.md).
#include "terrain/rules.hpp"
#include "terrain_frame.hpp"

namespace stereogrid::test {
namespace {

// Wrong matches look like edges in a sector or two; three sectors are 0.25 m.
TEST(Terrain, HolesOfTwoSectorsAreNoEdges) {
  const Vehicle vehicle{car()};
  const auto drops_of = [&](float width_m) {
    const HeightField hole{[=](float x, float y) { return std::abs(y) < width_m / 2 ? ditch(4.5f, 1)(x, y) : 0.0f; }};
    const Seen seen{walked(vehicle, hole, false)};
    return std::ranges::count(seen.kind, TerrainClass::drop);
  };
  for (const float width_m : {0.16f, 0.25f}) EXPECT_EQ(drops_of(width_m), 0) << width_m;
  EXPECT_GE(drops_of(0.8f), 3);
}

// slope_max is 20°. The walk's line follows a slope: each ring is hardly above the one before.
TEST(Terrain, SlopesThatAreTooSteepAreObstaclesFromTheirFootOn) {
  const Vehicle vehicle{car()};
  const auto drivable = [&](float degrees, double from_m, double to_m) {
    return drivable_share(vehicle, walked(vehicle, ramp(5, degrees), true), from_m, to_m);
  };
  for (const float degrees : {15.0f, 25.0f}) EXPECT_GE(drivable(degrees, vehicle.near_m, 4.6), 0.98) << degrees;
  EXPECT_GE(drivable(15, 5.4, 7), 0.95);
  EXPECT_LE(drivable(25, 5.4, 7), 0.05);
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

TEST(HeightMemory, ABarIsSeenInThreeOfEightFrames) {
  HeightMemory memory{3};
  bool is_in_view{true};
  const auto bars_after = [&](std::initializer_list<bool> frames) {
    int bars{0};
    for (const bool is_tall : frames) {
      memory.pass_bars([&](int, int) { return is_in_view; });
      if (is_tall) memory.add_tall(1, 2);
    }
    memory.for_obstacles([](int, int, const HeightMemory::Mean&) { ADD_FAILURE() << "a bar has no mean"; });
    memory.for_bars([&](int ix, int iy) {
      ++bars;
      EXPECT_EQ(ix, 1);
      EXPECT_EQ(iy, 2);
    });
    return bars;
  };
  EXPECT_EQ(bars_after({true, false, false, true, false, false, false}), 0);
  EXPECT_EQ(bars_after({true}), 1);
  memory.add(1, 2, 0, 1, HeightMemory::samples_enough);  // ground below it
  memory.clear(1, 2);                                    // beside something tall
  EXPECT_EQ(bars_after({}), 1);
  is_in_view = false;
  EXPECT_EQ(bars_after({false, false, false}), 1);
  is_in_view = true;
  EXPECT_EQ(bars_after({false}), 0) << "the first one was nine frames ago";
  EXPECT_EQ(bars_after({true}), 1);
  memory.clear_tall(1, 2);
  EXPECT_EQ(bars_after({true, true}), 0) << "rays saw it";
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
  for (const CellRule rule : {CellRule::obstacle, CellRule::edge}) {
    expect(rule, 0.1f, 0.7f);
    expect(rule, 0.9f, 0.9f);
  }
}

// A bar below the image is not in view.
TEST(Terrain, LowObstaclesAreInViewFromTheLowestRowToTheLastSamples) {
  const Vehicle vehicle{car()};
  const Rig& rig{vehicle.rig};
  const Window window{vehicle.grid};
  const GridGeometry cells{window.at({})};
  Ground ground;
  ground.height_m = rig.camera_height_m;
  constexpr float checked_m{6};
  LowModel model{rig, vehicle.limits, cells.cell_size_m, window.cells(), 9, 64};
  model.begin(TerrainCamera{rig, ground}, grid_in_vehicle(cells, {}), checked_m);
  const double nearest_m{rig.camera_height_m * rig.focal_px / (rig.height_px - 1 - rig.cy_px)};
  int seen{0};
  for (int iy{0}; iy < cells.ny; ++iy) {
    for (int ix{0}; ix < cells.nx; ++ix) {
      const Point2 at{cells.centre(ix, iy)};
      const double u{rig.cx_px - rig.focal_px * at.y / at.x};
      const bool is_seen{at.x >= nearest_m && at.x < checked_m && u >= 0 && u < rig.width_px};
      EXPECT_EQ(model.is_in_view(ix, iy), is_seen) << at.x << ' ' << at.y;
      seen += is_seen ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 100);
}

TEST(Terrain, EdgesHaveTheVisibleFall) {
  const FrameOf frame{step(4, -0.25f)};
  ASSERT_GT(frame.terrain.edges().size(), 40u);
  for (const EdgePoint& edge : frame.terrain.edges()) {
    EXPECT_NEAR(edge.place.x, 4, 0.4);
    EXPECT_NEAR(edge.fall_m, 0.25, 0.1);
  }
}

// On the way to an edge or a kerb, which the vehicle passes after it has seen them once.
TEST(Terrain, HazardsStayUntilGroundIsSeenThere) {
  for (const float rise_m : {-0.25f, 0.3f}) {
    FrameOf frame{step(4, rise_m)};
    EXPECT_EQ(frame.filtered_at(4), 0.7f);
    frame.pose = {1.1, 0.3, 0.1};
    frame.see(Image<float>{frame.vehicle.rig.width_px, frame.vehicle.rig.height_px});
    EXPECT_EQ(frame.filtered_at(2.9), 0.7f) << "no ground is seen";
    frame.see(disparity_of(frame.vehicle.rig, ramp(5, 0)));
    EXPECT_EQ(frame.filtered_at(2.9, false), 0.7f) << "the frame is rejected";
    EXPECT_EQ(frame.filtered_at(2.9), 0) << "drivable ground";
  }
}

// A stone of 0.2 m, which rays do not show, outlasts frames that do not see it.
TEST(Terrain, ALowObstacleIsRemembered) {
  const auto stone = [](float x, float y) { return x > 4 && x < 4.3f && std::abs(y) < 0.15f ? 0.2f : 0.0f; };
  const Image<float> seen{disparity_of(car().rig, stone)};
  const Image<float> level{disparity_of(car().rig, ramp(5, 0))};
  FrameOf frame{stone};
  EXPECT_EQ(frame.rule_at(4.1), CellRule::obstacle);
  for (int i{0}; i < 4; ++i) {
    EXPECT_EQ(frame.filtered_at(4.1), 0.7f) << "frames: " << i;
    frame.see(seen);
  }
  frame.see(level);
  EXPECT_EQ(frame.filtered_at(4.1), 0.7f) << "a frame misses it";
  frame.see(seen);
  EXPECT_EQ(frame.filtered_at(4.1), 0.7f);
  frame.pose = {1.1, 0, 0};
  for (int i{0}; i < 20; ++i) {
    frame.see(Image<float>{frame.vehicle.rig.width_px, frame.vehicle.rig.height_px});
    EXPECT_EQ(frame.filtered_at(3.0), 0.7f) << "unseen for frames: " << i;
  }
  const CellIndex cell{*frame.result.world.geometry.cell_at({4.1, 0.1})};
  EXPECT_EQ(frame.result.world_terrain(cell.ix, cell.iy), TerrainClass::obstacle);
  EXPECT_NEAR(frame.result.world_elevation_m(cell.ix - 5, cell.iy), 0, 0.05f);
}

// Before the nearest ground in view, at 2.4 m, a bar is still in the image, but frames do not count there.
TEST(Terrain, ABarIsRememberedUntilTheVehicleReachesIt) {
  const Rig rig{car().rig};
  const auto bar_at = [&](double x) {
    Image<float> disparity{disparity_of(rig, ramp(5, 0))};
    const int v{static_cast<int>(rig.cy_px + rig.focal_px * (rig.camera_height_m - 0.6) / x)};
    for (int u{rig.width_px / 4}; u < rig.width_px * 3 / 4; ++u)
      disparity(u, v) = disparity(u, v + 1) = static_cast<float>(rig.focal_px * rig.baseline_m / x);
    return disparity;
  };
  FrameOf frame{ramp(5, 0)};
  for (const double x : {4.1, 3.9, 3.7, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1}) {
    frame.pose = {4.1 - x, 0, 0};
    frame.see(bar_at(x));
    EXPECT_EQ(frame.filtered_at(x) == 0.7f, x < 3.8) << x;
  }
}

// The memory of level ground outweighs a stone that a single frame shows; the frame itself does not pass it over.
TEST(Terrain, ALowObstacleOfAFrameCountsInThatFrame) {
  const auto stone = [](float x, float y) { return x > 4 && x < 4.3f && std::abs(y) < 0.15f ? 0.2f : 0.0f; };
  FrameOf frame{ramp(5, 0)};
  for (int i{0}; i < 10; ++i) {
    EXPECT_EQ(frame.filtered_at(4.1), 0);
    frame.see(disparity_of(frame.vehicle.rig, ramp(5, 0)));
  }
  frame.see(disparity_of(frame.vehicle.rig, stone));
  EXPECT_EQ(frame.filtered_at(4.1), 0.7f);
  frame.see(Image<float>{frame.vehicle.rig.width_px, frame.vehicle.rig.height_px});
  EXPECT_EQ(frame.filtered_at(4.1), 0.5f) << "not remembered";
}

// The cells of the vehicle's grid lie across those of the filter's window.
TEST(Terrain, ALowObstacleIsInBothGridsWhereverTheirCellsLie) {
  for (const Pose2 pose : {Pose2{0.07, 0.13, 0}, Pose2{3.31, -2.05, 0.4}, Pose2{-1.19, 0.02, -2.3}}) {
    FrameOf frame{ramp(5, 0)};
    frame.pose = pose;
    frame.see(disparity_of(frame.vehicle.rig, ramp(5, 0)));
    EXPECT_EQ(frame.filtered_at(4.1), 0) << pose.yaw_rad;
    frame.see(disparity_of(frame.vehicle.rig,
                           [](float x, float y) { return x > 4 && x < 4.3f && std::abs(y) < 0.25f ? 0.2f : 0.0f; }));
    EXPECT_EQ(frame.filtered_at(4.1), 0.7f) << pose.yaw_rad;
    EXPECT_EQ(frame.filtered_at(5.5), 0) << pose.yaw_rad;
  }
}

// Stones on half of the ground do not raise the plane by which their heights are measured.
TEST(Terrain, StonesInAFieldAreAsHighAsAloneOnes) {
  const auto is_stone = [](float x, float y) {
    return x > 3.6f && x < 6 && std::fmod(x, 0.6f) < 0.3f && std::fmod(y + 6, 0.4f) < 0.3f;
  };
  const FrameOf frame{[=](float x, float y) { return is_stone(x, y) ? 0.15f : 0.0f; }};
  int found{0};
  int rows{0};
  for (int iy{frame.vehicle.grid.ny / 2 - 4}; iy < frame.vehicle.grid.ny / 2 + 4; ++iy) {
    for (const int ix : {18, 21, 24, 27}) {  // first cells of the rows of stones
      const auto rule = [&](int x) { return frame.terrain.rules().vehicle(x, iy); };
      found += rule(ix) == CellRule::obstacle || rule(ix + 1) == CellRule::obstacle ? 1 : 0;
      ++rows;
    }
  }
  EXPECT_GE(found, 3 * rows / 4);
}

// Errors of the matcher are as deep as they are high.
TEST(Terrain, PatchesBesideDeepOnesAreNoObstacles) {
  for (const float deep_m : {0.0f, 0.12f}) {
    const FrameOf frame{[=](float x, float y) {
      if (x > 4 && x < 4.3f && std::abs(y) < 0.15f) return 0.14f;
      return x > 4 && x < 5.4f && y > 0.5f && y < 0.9f ? -deep_m : 0.0f;
    }};
    EXPECT_EQ(frame.rule_at(4.1) == CellRule::obstacle, deep_m == 0) << deep_m;
  }
}

// A patch of wrong matches hangs over level ground: as high as the stone, but smaller.
TEST(Terrain, WrongMatchesAreSmallerThanStones) {
  for (const float width_m : {0.05f, 0.3f}) {
    const auto seen = [=](float x, float y) { return x > 4 && x < 4.1f && y > 0 && y < width_m ? 0.2f : 0.0f; };
    FrameOf frame{seen};
    EXPECT_EQ(frame.filtered_at(4.05) == 0.7f, width_m == 0.3f) << width_m;
  }
}

// The matcher leaves only the middle of a stone as high as an obstacle of a frame.
TEST(Terrain, SidesOfAStoneCountForItsSize) {
  for (const float sides_m : {0.0f, 0.1f}) {
    const FrameOf frame{[=](float x, float y) {
      if (x < 4 || x > 4.3f || std::abs(y) > 0.3f) return 0.0f;
      return std::abs(y) < 0.08f ? 0.14f : sides_m;
    }};
    EXPECT_EQ(frame.rule_at(4.1) == CellRule::obstacle, sides_m > 0) << sides_m;
  }
}

TEST(Terrain, ALowObstacleThatIsGoneIsDropped) {
  const auto stone = [](float x, float y) { return x > 4 && x < 4.3f && std::abs(y) < 0.15f ? 0.2f : 0.0f; };
  const Image<float> seen{disparity_of(car().rig, stone)};
  const Image<float> level{disparity_of(car().rig, ramp(5, 0))};
  FrameOf frame{stone};
  for (int i{0}; i < 30; ++i) {
    frame.see(seen);
    frame.filtered_at(4.1);
  }
  int frames{0};
  for (; frames < 30; ++frames) {
    frame.see(level);
    if (frame.filtered_at(4.1) == 0) break;
  }
  EXPECT_GE(frames, 2);
  EXPECT_LE(frames, 10);
}

// The plane around a cell follows slopes up to the limit, and their ends.
TEST(Terrain, SlopesHaveNoLowObstacles) {
  for (const float degrees : {-4.0f, 5.0f, 10.0f, 15.0f}) {
    const FrameOf frame{ramp(4, degrees)};
    for (double x{3}; x < 7; x += 0.2) EXPECT_NE(frame.rule_at(x), CellRule::obstacle) << degrees << " deg, x " << x;
  }
}

}  // namespace
}  // namespace stereogrid::test
