// SPDX-License-Identifier: Apache-2.0
//
// Given extrinsics before stairs, slopes, edges, docks, tables and pallets: they stay, and no grid is free beyond an
// edge without a status.
#include "chain_run.hpp"

namespace stereogrid::test {
namespace {

constexpr const char* car{"width=320&height=200&focal=212&baseline=0.4&camera_height=1&frames=16&rate=4"};
constexpr const char* robot{
    "width=320&height=240&focal=210&baseline=0.1&camera_height=0.35&pitch_deg=8&frames=16&rate=4"};

struct Layout {
  const char* scene;
  const char* camera;
  double edge_m;
  double rise_m;
  double incline_deg{90};
  int steps{1};
};

std::string text_of(const Layout& layout) {
  return std::string{layout.scene} + "?" + layout.camera + "&edge=" + std::to_string(layout.edge_m) +
         "&rise=" + std::to_string(layout.rise_m) + "&incline_deg=" + std::to_string(layout.incline_deg) +
         "&steps=" + std::to_string(layout.steps);
}

bool has(const FrameResult& result, FrameStatus status) {
  return std::ranges::count(result.status, status) > 0;
}

// Cells of the observed grid for which `is_wanted(p)`, `from_m` to `to_m` ahead and within 1 m to either side.
template <class IsWanted>
double share_of(const FrameResult& result, double from_m, double to_m, const IsWanted& is_wanted) {
  const GridGeometry& grid{result.vehicle.geometry};
  int all{0};
  int wanted{0};
  for (const auto [ix, iy] : raster(grid.nx, grid.ny)) {
    const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m};
    const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
    if (x < from_m || x > to_m || std::abs(y) > 1) continue;
    ++all;
    wanted += is_wanted(result.observed(ix, iy)) ? 1 : 0;
  }
  return all > 0 ? static_cast<double>(wanted) / all : 0;
}

double free_beyond(const FrameResult& result, double edge_m) {
  return share_of(result, edge_m + 0.3, edge_m + 3, [](float p) { return p < 0.45f; });
}

// Drives through a layout; calls check(result, distance to the edge) after each frame.
template <class Check>
void drive(const Layout& layout, const Check& check) {
  SCOPED_TRACE(text_of(layout));
  const Scene scene{text_of(layout)};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2, .stages = false}};
  const double edge_x_m{scene.load(scene.size() - 1).world_from_vehicle->x_m + layout.edge_m};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const StereoFrame frame{scene.load(i)};
    const FrameResult& result{pipeline.process(frame)};
    check(result, edge_x_m - frame.world_from_vehicle->x_m);
    ASSERT_EQ(pipeline.next_rig(), scene.rig()) << "frame " << i;
  }
}

// A ramp with a box on it, from the second frame on.
TEST(Terrain, RampsAreFreeAndBoxesOnThemAreNot) {
  const auto last_frame = [](const std::string& text) {
    const Scene scene{text};
    Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2, .stages = false}};
    const FrameResult* result{nullptr};
    for (std::size_t i{0}; i < scene.size(); ++i) result = &pipeline.process(scene.load(i));
    EXPECT_TRUE(result->status.empty()) << text;
    EXPECT_TRUE(std::ranges::none_of(result->obstacles, [&](const Obstacle& one) {
      return one.confirmed && one.x_m < 12 && (text.find("box") == std::string::npos || one.length_m > 3);
    })) << text;
    return std::pair{share_of(*result, 3.4, 8, [](float p) { return p < 0.45f; }),
                     share_of(*result, 4, 8, [](float p) { return p > 0.65f; })};
  };
  for (const char* slope : {"5", "8", "12"}) {
    const auto [free, occupied] = last_frame("terrain?kind=ramp&frames=4&at=4&slope_deg=" + std::string{slope});
    EXPECT_GT(free, 0.97) << slope;
    EXPECT_EQ(occupied, 0) << slope;
  }
  EXPECT_GT(last_frame("terrain?kind=box&frames=4&at=5&slope_deg=8").second, 0.02);
}

// From 2.6 m before a ramp on no other ground is seen, with a robot's camera from 0.7 m on.
TEST(Terrain, ARampThatFillsTheViewIsGround) {
  struct Ramp {
    const char* preset;
    const char* text;
    double from_m;
    double to_m;
  };
  for (const Ramp& ramp : {Ramp{"default", "at=1.1&slope_deg=8", 4, 7}, Ramp{"default", "at=1.1&slope_deg=-6", 4, 7},
                           Ramp{"robot", "camera=robot&at=0.15&slope_deg=-6", 1.6, 2.4}}) {
    SCOPED_TRACE(ramp.text);
    const Scene scene{"terrain?kind=ramp&frames=18&" + std::string{ramp.text}};
    Pipeline pipeline{preset(ramp.preset), scene.rig(), {.threads = 2, .stages = false}};
    for (std::size_t i{0}; i < scene.size(); ++i) {
      const FrameResult& result{pipeline.process(scene.load(i))};
      EXPECT_TRUE(result.status.empty()) << i;
      if (i + 4 < scene.size()) continue;
      const double free{share_of(result, ramp.from_m, ramp.to_m, [](float p) { return p < 0.45f; })};
      EXPECT_GT(free, 0.9) << i;
    }
    EXPECT_EQ(pipeline.next_rig(), scene.rig());
  }
}

TEST(Terrain, ACameraThatWasTurnedOnTheWayIsReported) {
  for (const char* pitch_deg : {"8", "-8"}) {
    const std::string text{"street?width=320&height=200&frames=6"};
    const Scene before{text};
    const Scene after{text + "&pitch_deg=" + pitch_deg};
    Pipeline pipeline{preset("default"), before.rig(), {.threads = 2, .stages = false}};
    for (std::size_t i{0}; i < 3; ++i) EXPECT_TRUE(pipeline.process(before.load(i)).status.empty()) << i;
    for (std::size_t i{3}; i < 6; ++i) {
      EXPECT_TRUE(has(pipeline.process(after.load(i)), FrameStatus::extrinsics_disagree)) << pitch_deg << " " << i;
    }
  }
}

// Falling ground: edges, stairs down, a steep slope.
TEST(Terrain, IsNotFreeBeyondAnEdge) {
  constexpr double searched_m{3.6};
  const auto check = [&](const FrameResult& result, double edge_m) {
    if (edge_m > searched_m || has(result, FrameStatus::road_unknown)) return;
    EXPECT_LE(free_beyond(result, edge_m), 0) << edge_m;
  };
  for (const double edge_m : {1.2, 2.0, 2.6, 3.2}) {
    for (const double depth_m : {0.3, 0.9, 1.5, 2.5}) drive({"step", car, edge_m, -depth_m}, check);
  }
  for (const double edge_m : {1.6, 3.0}) {
    for (const int steps : {4, 8}) drive({"step", car, edge_m, -0.17 * steps, 90, steps}, check);
  }
  for (const double incline_deg : {35.0, 60.0}) drive({"step", car, 2.5, -1.5, incline_deg}, check);
  const auto check_near = [&](const FrameResult& result, double edge_m) {
    if (edge_m < 1.6) check(result, edge_m);
  };
  for (const double edge_m : {0.6, 1.2}) {
    for (const double depth_m : {0.3, 0.9}) drive({"step", robot, edge_m, -depth_m}, check_near);
  }
}

// From 7 m the ditch and the kerb look like free ground; from 5 m on they are seen.
TEST(Terrain, HazardsOfAFrameAreNotFreeInTheFilteredGrid) {
  const auto drive_to = [](const std::string& text, TerrainClass kind, float least) {
    const Scene scene{text};
    Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2}};
    int cells{0};
    for (std::size_t frame{0}; frame < scene.size(); ++frame) {
      const FrameResult& result{pipeline.process(scene.load(frame))};
      for (const auto [ix, iy] : raster(result.terrain)) {
        if (result.terrain(ix, iy) != kind) continue;
        ++cells;
        EXPECT_GE(result.vehicle.occupancy(ix, iy), least) << frame << ": " << ix << " " << iy;
      }
    }
    return cells;
  };
  const std::string ditch{"terrain?kind=ditch&at=4&span=1&frames=14"};
  EXPECT_GT(drive_to(ditch, TerrainClass::hidden, 0.5f), 500);
  EXPECT_GT(drive_to(ditch, TerrainClass::drop, 0.7f), 50);
  EXPECT_GT(drive_to("terrain?kind=kerb&at=4&frames=14", TerrainClass::obstacle, 0.5f), 50);
}

// Its top has a few right matches a frame, and ground behind it that seems to be in its place.
TEST(Terrain, AThinTableTopIsAnObstacle) {
  const Scene scene{"terrain?kind=table&seed=3&frames=10"};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2, .stages = false}};
  constexpr std::size_t frames{4};
  int occupied{0};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const StereoFrame frame{scene.load(i)};
    const FrameResult& result{pipeline.process(frame)};
    if (i + frames < scene.size()) continue;
    const GridGeometry& grid{result.vehicle.geometry};
    for (const auto [ix, iy] : raster(grid.nx, grid.ny)) {
      const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m + frame.world_from_vehicle->x_m};
      const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
      if (x < 6.8 || x > 7.6 || std::abs(y) > 1.2) continue;
      occupied += result.vehicle.occupancy(ix, iy) >= 0.7f ? 1 : 0;
    }
  }
  EXPECT_GT(occupied, 50) << "of 192 cells; without memory of bars 39";
}

// Rising ground and large obstacles.
TEST(Terrain, KeepsTheExtrinsicsBeforeWhatRises) {
  const auto check = [](const FrameResult& result, double) {
    if (!result.ground.estimated) return;
    EXPECT_NEAR(result.ground.height_m, 1, 0.15);
  };
  for (const double edge_m : {1.5, 2.5}) {
    for (const int steps : {4, 8}) drive({"step", car, edge_m, 0.17 * steps, 90, steps}, check);
    for (const double incline_deg : {12.0, 18.0, 24.0, 30.0}) drive({"step", car, edge_m, 3, incline_deg}, check);
    drive({"step", car, edge_m, 0.6}, check);
    drive({"step", car, edge_m, 1.2}, check);
  }
  for (const double edge_m : {0.6, 1.2, 2.2}) {
    drive({"table", car, edge_m, 0.75}, check);
    drive({"pallet", car, edge_m, 0.5}, check);
  }
}

// The first riser is in the grid while the floor before it is in view.
TEST(Terrain, StairsUpAreObstaclesWhileTheFloorIsSeen) {
  drive({"step", car, 2.5, 1.36, 90, 8}, [](const FrameResult& result, double edge_m) {
    if (edge_m < 3.4) return;
    EXPECT_TRUE(result.status.empty());
    EXPECT_GT(share_of(result, edge_m - 0.2, edge_m + 0.4, [](float p) { return p > 0.55f; }), 0.3) << edge_m;
  });
}

TEST(Terrain, SaysWhatDisagrees) {
  int disagreeing{0};
  drive({"step", car, 1.2, -0.9}, [&](const FrameResult& result, double) {
    disagreeing += has(result, FrameStatus::extrinsics_disagree) ? 1 : 0;
    if (!has(result, FrameStatus::extrinsics_disagree)) return;
    const auto warning{std::ranges::find(result.warnings, FrameStatus::extrinsics_disagree, &Warning::status)};
    ASSERT_NE(warning, result.warnings.end());
    EXPECT_NE(warning->text.find("camera height 1.00 m"), std::string::npos) << warning->text;
    const std::size_t seen{warning->text.find("in use; height ")};
    ASSERT_NE(seen, std::string::npos) << warning->text;
    EXPECT_NEAR(std::stod(warning->text.substr(seen + 15)), 1.9, 0.3);
  });
  EXPECT_GE(disagreeing, 8);
}

TEST(Terrain, AFlatFloorIsKnown) {
  drive({"step", car, 40, 0.5}, [](const FrameResult& result, double) { EXPECT_TRUE(result.status.empty()); });
}

// The matcher's errors on the sides of a floor are larger than their expected deviation.
TEST(Terrain, AFloorHasFewLowObstacles) {
  const Scene scene{"terrain?kind=paint&seed=1&frames=10"};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2, .stages = false}};
  int marked{0};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const FrameResult& result{pipeline.process(scene.load(i))};
    const GridGeometry& grid{result.vehicle.geometry};
    for (const auto [ix, iy] : raster(grid.nx, grid.ny)) {
      const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m};
      marked += x > 8 && x < 13 && result.vehicle.occupancy(ix, iy) > 0.55f ? 1 : 0;
    }
  }
  EXPECT_LT(marked, 45) << "of 25,000 cells";
}

// Statements of docs/terrain.md about kerbs and low boxes, on the scene `boxes`.

constexpr const char* kitti_camera{"boxes?width=1242&height=375"};
constexpr std::size_t frames{4};
constexpr float free_below{0.45f};
constexpr float occupied_above{0.55f};

/// Largest probability of the cells between two corners.
float highest(const FrameResult& result, const Image<float>& cells, Point2 low, Point2 high) {
  const GridGeometry& grid{result.vehicle.geometry};
  float found{0};
  for (int iy{0}; iy < grid.ny; ++iy) {
    const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
    for (int ix{0}; ix < grid.nx; ++ix) {
      const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m};
      if (x >= low.x && x <= high.x && y >= low.y && y <= high.y) found = std::max(found, cells(ix, iy));
    }
  }
  return found;
}

/// The filtered grid after some frames. Box i stands at (8.2, 2·i − 4) and (14.2, 2·i − 5).
class Boxes {
 public:
  explicit Boxes(const Config& config) : drive_{kitti_camera, config} {
    for (std::size_t i{0}; i < frames; ++i) result_ = &drive_.step(i);
  }

  [[nodiscard]] float near(int box) const { return at(8.2, 2.0 * box - 4); }
  [[nodiscard]] float far(int box) const { return at(14.2, 2.0 * box - 5); }
  [[nodiscard]] float kerb() const { return highest(*result_, result_->vehicle.occupancy, {10, -6.5}, {18, -5.6}); }

 private:
  [[nodiscard]] float at(double x, double y) const {
    return highest(*result_, result_->vehicle.occupancy, {x - 0.5, y - 0.4}, {x + 0.5, y + 0.4});
  }

  Drive drive_;
  const FrameResult* result_{nullptr};
};

// A box of 5 cm before a robot that climbs 3 cm, and a painted floor.
TEST(LowObstacles, AreObstaclesOfTheList) {
  const auto confirmed_in = [](const std::string& text) {
    const Scene scene{"terrain?camera=robot&frames=16&" + text};
    Pipeline pipeline{preset("robot"), scene.rig(), {.threads = 2, .stages = false}};
    std::vector<Obstacle> confirmed;
    for (std::size_t i{0}; i < scene.size(); ++i) {
      for (const Obstacle& one : pipeline.process(scene.load(i)).obstacles) {
        if (one.confirmed) confirmed.push_back(one);
      }
    }
    return confirmed;
  };
  const std::vector<Obstacle> box{confirmed_in("kind=box&rise=0.05")};
  ASSERT_GE(box.size(), 6u) << "frames";
  EXPECT_NEAR(box.back().x_m, 1.75, 0.2) << "1.5 m away in the last frame, 0.2 m wide";
  EXPECT_NEAR(box.back().y_m, 0, 0.1);
  EXPECT_NEAR(box.back().height_m, 0.05, 0.02);
  EXPECT_EQ(box.back().kind, ObstacleKind::object);
  EXPECT_EQ(box.back().vx_mps, 0);
  for (const Obstacle& one : box) EXPECT_EQ(one.id, box.front().id);
  EXPECT_TRUE(confirmed_in("kind=paint").empty());
}

enum Height { cm_10, cm_15, cm_20, cm_30, cm_50 };

TEST(LowObstacles, ByDefaultWhatAWheelClimbsIsRoad) {
  const Boxes boxes{preset("default")};
  EXPECT_LT(boxes.near(cm_10), free_below);
  EXPECT_LT(boxes.far(cm_10), free_below);
  EXPECT_LT(boxes.kerb(), free_below);
  for (const Height high : {cm_20, cm_30, cm_50}) EXPECT_GT(boxes.near(high), occupied_above) << high;
  EXPECT_GT(boxes.far(cm_50), occupied_above);
}

TEST(LowObstacles, OverAPlaneTwentyCentimetresAreRoad) {
  Config config{preset("default")};
  config.ground.model = GroundModel::plane;
  const Boxes boxes{config};
  for (const Height low : {cm_10, cm_15, cm_20}) {
    EXPECT_LT(boxes.near(low), free_below) << low;
    EXPECT_LT(boxes.far(low), free_below) << low;
  }
  EXPECT_LT(boxes.kerb(), free_below);
  EXPECT_GT(boxes.near(cm_30), occupied_above);
  EXPECT_GT(boxes.near(cm_50), occupied_above);
  EXPECT_GT(boxes.far(cm_50), occupied_above);
}

TEST(LowObstacles, WithoutALeastHeightFifteenCentimetresAndKerbsAreObstacles) {
  Config config{preset("default")};
  config.u_disparity.obstacle_min_height_m = 0;
  const Boxes boxes{config};
  for (const Height high : {cm_15, cm_20, cm_30, cm_50}) {
    EXPECT_GT(boxes.near(high), occupied_above) << high;
    EXPECT_GT(boxes.far(high), occupied_above) << high;
  }
  EXPECT_GT(boxes.kerb(), occupied_above);
}

}  // namespace
}  // namespace stereogrid::test
