// SPDX-License-Identifier: Apache-2.0
//
// Velocities from images, against the motion of rendered objects.
#include "chain_run.hpp"

namespace stereogrid::test {
namespace {

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

struct Errors {
  int sightings{0};
  std::vector<double> speed_mps;
  std::vector<double> direction_deg;
};

// The confirmed obstacle nearest to each moving object that is in view, after a second.
void add_errors(Drive& drive, std::size_t frames, Errors& errors) {
  for (std::size_t i{0}; i < frames; ++i) {
    const FrameResult& result{drive.step(i)};
    if (i < 10) continue;
    const FrameTruth truth{drive.scene.truth(i)};
    const Pose2 vehicle_from_world{inverse(truth.ego.world_from_vehicle)};
    for (const TruthObject& object : truth.objects) {
      const Point2 place{vehicle_from_world * Point2{object.world_from_object.x_m, object.world_from_object.y_m}};
      const double speed{std::hypot(object.vx_mps, object.vy_mps)};
      if (speed < 0.3 || object.pixels < 100 || place.x > 19 || std::abs(place.y) > 9) continue;
      ++errors.sightings;
      const Obstacle* nearest{nullptr};
      double least{2};
      for (const Obstacle& obstacle : result.obstacles) {
        const double distance{std::hypot(obstacle.x_m - place.x, obstacle.y_m - place.y)};
        if (!obstacle.confirmed || distance > least) continue;
        least = distance;
        nearest = &obstacle;
      }
      if (nearest == nullptr) continue;
      const Point2 v{Pose2{0, 0, vehicle_from_world.yaw_rad} * Point2{object.vx_mps, object.vy_mps}};
      errors.speed_mps.push_back(std::abs(std::hypot(nearest->vx_mps, nearest->vy_mps) - speed));
      errors.direction_deg.push_back(
          std::abs(std::remainder(std::atan2(nearest->vy_mps, nearest->vx_mps) - std::atan2(v.y, v.x), 2 * pi)) /
          degree);
    }
  }
}

TEST(MotionChain, ObstaclesHaveTheSpeedOfWhatTheyAre) {
  Errors errors;
  for (const char* text : {"crossing", "street?seed=3"}) {
    Drive drive{text};
    add_errors(drive, 30, errors);
  }
  ASSERT_GT(errors.sightings, 40);
  EXPECT_GT(static_cast<double>(errors.speed_mps.size()), 0.7 * errors.sightings);
  EXPECT_LT(median(errors.speed_mps), 0.3);
  EXPECT_LT(median(errors.direction_deg), 5);
}

TEST(MotionChain, IsTheSameOnTheReferenceAndWithMoreThreads) {
  const char* text{"crossing?width=256&height=160"};
  Config config{preset("default")};
  config.grid.width_m = 6;  // the reference takes its time
  config.grid.length_m = 14;
  config.grid.cell_size_m = 0.4;
  Drive cpu{text, config, 2};
  Drive more{text, config, 5};
  Drive reference{text, config, 1, BackEnd::reference};
  config.filter.scene_flow = false;
  Drive without{text, config};
  for (std::size_t i{0}; i < 4; ++i) {
    const FrameResult& expected{reference.step(i)};
    expect_equal(cpu.step(i), expected);
    expect_equal(more.step(i), expected);
    without.step(i);
  }
  EXPECT_NE(without.step(4).world.velocity_x, cpu.step(4).world.velocity_x) << "no point was followed";
}

TEST(MotionChain, WithoutSceneFlowTheImagesSayNothingOfVelocities) {
  Config config{preset("default")};
  config.filter.scene_flow = false;
  Drive without{"crossing", config};
  Drive with{"crossing"};
  double moving[2]{};
  for (std::size_t i{0}; i < 5; ++i) {
    int k{0};
    for (Drive* drive : {&without, &with}) {
      const FrameResult& result{drive->step(i)};
      moving[k] = 0;
      for (const float p : result.world.moving) moving[k] += p > 0.5f ? 1 : 0;
      ++k;
    }
  }
  EXPECT_GT(moving[1], 1.3 * moving[0]);  // the grids alone indicate a part of the motion
}

}  // namespace
}  // namespace stereogrid::test
