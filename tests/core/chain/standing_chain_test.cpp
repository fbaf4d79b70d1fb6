// SPDX-License-Identifier: Apache-2.0
//
// Vehicles that stand: repeated frames add nothing, and an obstacle that is too close stays.
#include "chain_run.hpp"
#include "layouts/layouts.hpp"
#include "render/render.hpp"
#include "world/world.hpp"

namespace stereogrid::test {

/// Camera of the staged scenes: f·b = 56 px·m. With 64 disparities, surfaces nearer than 0.9 m cannot be matched.
inline Rig staged_rig() {
  return {.width_px = 320,
          .height_px = 200,
          .focal_px = 256,
          .cx_px = 160,
          .cy_px = 100,
          .baseline_m = 0.22,
          .camera_height_m = 1.25};
}

/// A drive whose poses are chosen frame by frame, at 10 Hz unless set otherwise.
class Staged {
 public:
  explicit Staged(scenes::World world, BackEnd back_end = BackEnd::cpu, const Config& config = preset("default"),
                  const Rig& rig = staged_rig())
      : rig_{rig}, world_{std::move(world)}, pipeline_{config, rig, {.back_end = back_end, .threads = 2}} {
    world_.road = scenes::two_lanes(3.5, 0);
  }

  /// The frame with the vehicle at (x_m, 0).
  StereoFrame frame_at(double x_m) {
    const Pose2 pose{x_m, 0, 0};
    const scenes::Frame3 vehicle{scenes::standing_at(world_.ground, pose, world_.wheels)};
    const auto parts = world_.at(time_s_);
    StereoFrame frame;
    frame.index = index_;
    frame.stamp_ns = std::llround(time_s_ * 1e9);
    frame.world_from_vehicle = pose;
    const auto seed = static_cast<std::uint64_t>(2 * index_);
    frame.left =
        render(world_, scenes::Caster{scenes::left_camera(rig_, vehicle), parts, world_.ground}, {1, 2.5, seed});
    frame.right = render(world_, scenes::Caster{scenes::right_camera(rig_, vehicle), parts, world_.ground},
                         {1.05, 2.5, seed + 1});
    ++index_;
    time_s_ += interval_s_;
    return frame;
  }
  const FrameResult& step(double x_m) { return pipeline_.process(frame_at(x_m)); }
  /// Frames from one place to another, both included.
  const FrameResult& drive(double from_m, double to_m, double step_m) {
    const int steps{static_cast<int>(std::lround(std::abs(to_m - from_m) / step_m))};
    const FrameResult* result{nullptr};
    for (int i{0}; i <= steps; ++i) result = &step(from_m + (to_m - from_m) * i / steps);
    return *result;
  }

  void set_interval(double interval_s) { interval_s_ = interval_s; }
  scenes::World& world() { return world_; }
  Pipeline& pipeline() { return pipeline_; }

 private:
  Rig rig_;
  scenes::World world_;
  Pipeline pipeline_;
  std::int64_t index_{0};
  double time_s_{0};
  double interval_s_{0.1};
};

namespace {

constexpr float occupied{0.55f};
/// Distance of a surface that cannot be matched.
constexpr double close_m{0.7};
constexpr double face_m{8};

scenes::World with(const scenes::Body& body) {
  scenes::World world;
  world.add(body);
  return world;
}

/// A wall across the drive at `face_m`.
scenes::World wall(double left_m = 0, double length_m = 40) {
  scenes::Random random{3};
  return with(scenes::make_wall({face_m + 0.125, left_m, pi / 2}, length_m, 3, random));
}

scenes::World box() {
  scenes::Random random{3};
  return with(scenes::make_crate({face_m + 0.4, 0.3, 0}, {0.8, 1.2, 1.6}, random));
}

/// Cells that are occupied although no frame has observed more than 0.5 there.
int count_unfounded(Staged& staged, int frames) {
  Image<float> most;
  int unfounded{0};
  for (int i{0}; i < frames; ++i) {
    const FrameResult& result{staged.step(0)};
    if (i == 0) most = result.observed;
    unfounded = 0;
    for (std::size_t cell{0}; cell < most.size(); ++cell) {
      most.data()[cell] = std::max(most.data()[cell], result.observed.data()[cell]);
      unfounded += most.data()[cell] <= 0.5f && result.vehicle.occupancy.data()[cell] > occupied ? 1 : 0;
    }
  }
  return unfounded;
}

TEST(Standing, BeforeAnEmptyFloorNoCellRisesAboveItsFrames) {
  Staged staged{{}};
  EXPECT_EQ(count_unfounded(staged, 30), 0);
}

TEST(Standing, BehindAWallNoCellBecomesOccupied) {
  Staged staged{wall()};
  EXPECT_EQ(count_unfounded(staged, 12), 0);
}

/// Least occupancy, over the cells in `from_m` … `to_m` to the left, of the nearest occupied place before 1.2 m.
float least_ahead(const FrameResult& result, double from_m, double to_m) {
  const GridGeometry& grid{result.vehicle.geometry};
  float least{1};
  for (double y{from_m}; y <= to_m; y += grid.cell_size_m) {
    float most{0};
    for (double x{0.1}; x < 1.2; x += grid.cell_size_m) {
      const auto cell = grid.cell_at({x, y});
      most = std::max(most, result.vehicle.occupancy(cell->ix, cell->iy));
    }
    least = std::min(least, most);
  }
  return least;
}

bool has_obstacle(const FrameResult& result) {
  return std::ranges::any_of(result.obstacles, [](const Obstacle& obstacle) {
    return obstacle.confirmed && obstacle.x_m < 2 && std::abs(obstacle.y_m) < 3;
  });
}

bool has(const FrameResult& result, FrameStatus flag) {
  return std::ranges::count(result.status, flag) == 1;
}

struct Close {
  const char* name;
  scenes::World world;
  double left_m;  ///< extent of the visible part of the obstacle
  double right_m;
};

std::vector<Close> close_scenes() {
  return {{"wall", wall(), 0.3, -0.3}, {"half", wall(10, 20), 0.3, 0.1}, {"box", box(), 0.3, -0.1}};
}

class TooClose : public testing::TestWithParam<Close> {};

TEST_P(TooClose, StaysForTenSecondsAndIsSeenAgain) {
  const Close& scene{GetParam()};
  Staged staged{scene.world};
  staged.drive(face_m - 3, face_m - close_m, 0.1);
  staged.set_interval(0.25);
  for (int i{0}; i < 40; ++i) {
    const FrameResult& result{staged.step(face_m - close_m)};
    EXPECT_GT(least_ahead(result, scene.right_m, scene.left_m), occupied) << i;
    EXPECT_TRUE(has_obstacle(result)) << i;
    EXPECT_TRUE(has(result, FrameStatus::too_close)) << i;
    EXPECT_FALSE(result.warnings.empty());
  }
  staged.set_interval(0.1);
  const FrameResult& back{staged.drive(face_m - close_m, face_m - 4, 0.1)};
  EXPECT_TRUE(back.status.empty());
  const auto ahead = back.vehicle.geometry.cell_at({3.5, 0.2});
  EXPECT_LT(back.vehicle.occupancy(ahead->ix, ahead->iy), 0.45f);
  EXPECT_TRUE(std::ranges::any_of(
      back.obstacles, [](const Obstacle& obstacle) { return !obstacle.coasting && std::abs(obstacle.x_m - 4) < 1; }));
}

TEST_P(TooClose, EndsSoonWhenItIsGone) {
  Staged staged{GetParam().world};
  staged.drive(face_m - 3, face_m - close_m, 0.1);
  for (int i{0}; i < 5; ++i) staged.step(face_m - close_m);
  staged.world().bodies.clear();
  for (int i{0}; i < 15; ++i) staged.step(face_m - close_m);
  const FrameResult& result{staged.step(face_m - close_m)};
  EXPECT_LT(least_ahead(result, GetParam().right_m, GetParam().left_m), occupied);
  EXPECT_FALSE(has_obstacle(result));
  EXPECT_FALSE(has(result, FrameStatus::too_close));
}

INSTANTIATE_TEST_SUITE_P(Standing, TooClose, testing::ValuesIn(close_scenes()),
                         [](const auto& test) { return std::string{test.param.name}; });

// It is matched, but the road in front of it is not in view: after 3 s the road is unknown.
TEST(Standing, AWallThatHidesTheGroundStays) {
  Staged staged{wall()};
  staged.drive(face_m - 3.5, face_m - 1.5, 0.1);
  staged.set_interval(0.25);
  for (int i{0}; i < 40; ++i) {
    const FrameResult& result{staged.step(face_m - 1.5)};
    const auto ahead = result.vehicle.geometry.cell_at({1.5, 0.1});
    EXPECT_GT(result.vehicle.occupancy(ahead->ix, ahead->iy), occupied) << i;
    EXPECT_TRUE(has_obstacle(result)) << i;
    EXPECT_EQ(has(result, FrameStatus::road_unknown), has(result, FrameStatus::too_close)) << i;
  }
}

TEST(Standing, ABoxThatPassesCloseByLeavesNothing) {
  scenes::Random random{3};
  scenes::Body crate{scenes::make_crate({1.4, -3, pi / 2}, {0.8, 0.8, 1.6}, random)};
  crate.motion.speed_mps = 1.5;
  Staged staged{with(crate)};
  for (int i{0}; i < 35; ++i) staged.step(0);
  const FrameResult& result{staged.step(0)};
  const GridGeometry& grid{result.vehicle.geometry};
  for (double y{-0.5}; y <= 0.5; y += grid.cell_size_m) {
    const auto cell = grid.cell_at({1.4, y});
    EXPECT_LT(result.vehicle.occupancy(cell->ix, cell->iy), occupied) << y;
  }
  EXPECT_FALSE(has(result, FrameStatus::too_close));
}

Config small_close() {
  Config config{preset("default")};
  config.grid.length_m = 4;
  config.grid.width_m = 3;
  config.matching.disparities = 40;
  return config;
}

Rig small_rig() {
  Rig rig{staged_rig()};
  rig.width_px = 128;
  rig.height_px = 96;
  rig.focal_px = 128;
  rig.cx_px = 64;
  rig.cy_px = 48;
  return rig;
}

constexpr double too_near_m{0.7};
constexpr double approach_m[]{0.95, 0.85, 0.75, too_near_m};

TEST(Standing, TooCloseIsTheSameOnTheReference) {
  Staged cpu{wall(), BackEnd::cpu, small_close(), small_rig()};
  Staged reference{wall(), BackEnd::reference, small_close(), small_rig()};
  for (const double ahead_m : approach_m) {
    const FrameResult& result{cpu.step(face_m - ahead_m)};
    expect_equal(result, reference.step(face_m - ahead_m));
    const bool is_too_close{has(result, FrameStatus::too_close)};
    EXPECT_TRUE(is_too_close || ahead_m > too_near_m);
    EXPECT_TRUE(!is_too_close || ahead_m < approach_m[0]);
  }
}

TEST(Standing, ASavedStateHoldsWhatIsTooClose) {
  Staged first{wall(), BackEnd::cpu, small_close(), small_rig()};
  for (const double ahead_m : approach_m) first.step(face_m - ahead_m);
  Pipeline second{small_close(), small_rig(), {.threads = 1}};
  second.load_state(first.pipeline().save_state());
  for (int i{0}; i < 3; ++i) {
    const StereoFrame frame{first.frame_at(face_m - too_near_m)};
    const FrameResult& expected{first.pipeline().process(frame)};
    expect_equal(expected, second.process(frame));
    EXPECT_TRUE(has(expected, FrameStatus::too_close));
  }
}

}  // namespace

}  // namespace stereogrid::test
