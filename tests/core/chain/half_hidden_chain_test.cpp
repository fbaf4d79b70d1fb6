// SPDX-License-Identifier: Apache-2.0
//
// The paper's own case (figure 6): a person behind a crate, seen from the waist up, in the scene `occlusion`. Ground
// that no frame has observed is unknown to the filter, too, except where a moving obstacle has driven into it.
#include "chain_run.hpp"
#include "ground_drive.hpp"

namespace stereogrid::test {
namespace {

constexpr std::size_t frames{4};

Pose2 pose_of_pedestrian(const FrameTruth& truth) {
  const auto found{std::find_if(truth.objects.begin(), truth.objects.end(),
                                [](const TruthObject& object) { return object.kind == "pedestrian"; })};
  if (found == truth.objects.end()) throw std::logic_error{"no pedestrian"};
  return found->world_from_object;
}

struct Person {
  explicit Person(const Scene& scene) : rig{scene.rig()}, pose{pose_of_pedestrian(scene.truth(0))} {}

  [[nodiscard]] double disparity_px() const { return rig.focal_px * rig.baseline_m / pose.x_m; }
  [[nodiscard]] int bin() const { return static_cast<int>(std::lround(disparity_px())); }
  [[nodiscard]] int column() const {
    return static_cast<int>(std::lround(rig.cx_px - rig.focal_px * pose.y_m / pose.x_m));
  }

  Rig rig;
  Pose2 pose;
};

/// A rule that stops at a column's nearest obstacle cannot see the person.
void expect_a_nearer_obstacle(const Person& person, const FrameResult& result) {
  int nearer{0};
  for (int v{0}; v < person.rig.height_px; ++v) {
    if (result.stages.obstacle_disparity(person.column(), v) > person.disparity_px() + 1.5) ++nearer;
  }
  EXPECT_GT(nearer, 20);
}

/// The largest probability of the cells that the person stands on.
float at_person(const Person& person, const FrameResult& result, const Image<float>& cells) {
  const GridGeometry& grid{result.vehicle.geometry};
  float highest{0};
  for (const auto [ix, iy] : raster(grid.nx, grid.ny)) {
    const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m - person.pose.x_m};
    const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m - person.pose.y_m};
    if (std::hypot(x, y) <= 0.25) highest = std::max(highest, cells(ix, iy));
  }
  return highest;
}

// About half of the rays that are possible at the person get there, so eq. 8, however sure of an obstacle, allows a bin
// no more than 3/4 in a single frame. All of that has to be there; the Gaussian then takes some of it from a person who
// is one bin deep.
TEST(HalfHidden, APersonIsFoundAsFarAsThePapersEquationsAllow) {
  const Config config{preset("paper")};
  Drive run{"occlusion", config};
  const Person person{run.scene};
  for (std::size_t i{0}; i < frames; ++i) {
    const FrameResult& result{run.step(i)};
    expect_a_nearer_obstacle(person, result);
    const double visibility{result.stages.visibility(person.column(), person.bin())};
    EXPECT_NEAR(visibility, 0.5, 0.05) << i;
    const double allowed{visibility * (1 - config.paper.false_positive) + (1 - visibility) / 2};
    EXPECT_NEAR(result.stages.occupancy(person.column(), person.bin()), allowed, 0.01) << i;
    EXPECT_GT(at_person(person, result, result.observed), 0.6) << i;
  }
}

// The default's rays count matches that end in the cell, not its hidden part.
TEST(HalfHidden, APersonIsFoundForSureByDefault) {
  Drive run{"occlusion"};
  const Person person{run.scene};
  for (std::size_t i{0}; i < frames; ++i) {
    const FrameResult& result{run.step(i)};
    expect_a_nearer_obstacle(person, result);
    EXPECT_GT(at_person(person, result, result.observed), 0.75) << i;
    EXPECT_GT(at_person(person, result, result.vehicle.occupancy), 0.75) << i;
  }
}

struct Run {
  const char* scene;
  const char* preset;
  double cell_size_m;
};

class NeverObserved : public testing::TestWithParam<Run> {};

TEST_P(NeverObserved, IsUnknownOrMoves) {
  Config config{preset(GetParam().preset)};
  config.grid.cell_size_m = GetParam().cell_size_m;
  Drive drive{GetParam().scene, config};
  NeverObservedCells cells;
  for (std::size_t i{0}; i < drive.scene.size(); ++i) cells.add(drive.step(i));
  EXPECT_EQ(cells.unfounded(), 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NeverObserved,
                         testing::Values(Run{"corridor?frames=16", "robot", 0.05},
                                         Run{"corridor?frames=12&camera=robot", "robot", 0.1},
                                         Run{"street?frames=12", "default", 0.2},
                                         Run{"street?frames=12&width=320&height=200&focal=256", "robot", 0.05},
                                         Run{"van?frames=25&width=320&height=200&focal=256", "default", 0.2},
                                         Run{"occlusion?frames=12", "default", 0.1}),
                         [](const auto& run) {
                           const std::string scene{run.param.scene};
                           return scene.substr(0, scene.find('?')) + "_" + run.param.preset + std::to_string(run.index);
                         });

}  // namespace
}  // namespace stereogrid::test
