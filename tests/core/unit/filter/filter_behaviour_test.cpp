// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "filter_run.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr double cell_m{0.2};
constexpr int cells{32};

GridGeometry still_window() {
  return {0, 0, cell_m, cells, cells};
}

class FilterBehaviour : public testing::TestWithParam<FilterModel> {};

TEST_P(FilterBehaviour, AStandingObjectIsOccupiedAndStands) {
  Cpu cpu{2};
  FilterRun run{cpu, method_config(GetParam()), still_window()};
  for (int step{0}; step < 15; ++step) run.step(scene(cells, 14, 12, 4, 4));
  EXPECT_GT(mean_over(run.layers.occupancy, 14, 12, 4, 4), 0.95);
  EXPECT_NEAR(mean_over(run.layers.velocity_x, 14, 12, 4, 4), 0, 0.3);
  EXPECT_NEAR(mean_over(run.layers.velocity_y, 14, 12, 4, 4), 0, 0.3);
  EXPECT_LT(run.layers.occupancy(13, 13), 0.1);
  EXPECT_LT(run.layers.occupancy(18, 13), 0.1);
  EXPECT_LT(run.layers.occupancy(5, 5), 0.1);
}

// The car drives: the window scrolls by whole cells, the object keeps its place in the world.
TEST_P(FilterBehaviour, StaysStandingWhileTheWindowScrolls) {
  Cpu cpu{2};
  FilterRun run{cpu, method_config(GetParam()), still_window()};
  GridGeometry geometry{still_window()};
  int x{24};
  int y{6};
  for (int step{0}; step < 15; ++step) {
    if (step > 0) {
      // a cell a step, as fast as the lattice; the object comes nearer by as much
      geometry.x_min_m += cell_m;
      geometry.y_min_m -= step % 2 == 0 ? cell_m : 0;
      --x;
      y += step % 2 == 0 ? 1 : 0;
    }
    run.step(scene(cells, x, y, 4, 4), 0.1, geometry);
  }
  EXPECT_GT(mean_over(run.layers.occupancy, x, y, 4, 4), 0.95);
  EXPECT_NEAR(mean_over(run.layers.velocity_x, x, y, 4, 4), 0, 0.3);
  EXPECT_NEAR(mean_over(run.layers.velocity_y, x, y, 4, 4), 0, 0.3);
  // no smear along the way, in front or behind
  EXPECT_LT(mean_over(run.layers.occupancy, x + 4, y, 2, 4), 0.1);
  EXPECT_LT(mean_over(run.layers.occupancy, x - 2, y, 2, 4), 0.1);
}

// A free world with an object of nx × ny cells whose left edge lies at x (in cells, fractions allowed).
Image<float> covered(int size, double x, int y, int nx, int ny, float object, float free) {
  Image<float> observed{size, size, free};
  for (int ix{0}; ix < size; ++ix) {
    const double share{std::clamp(std::min(x + nx, ix + 1.0) - std::max(x, ix * 1.0), 0.0, 1.0)};
    for (int iy{y}; iy < y + ny; ++iy) observed(ix, iy) = static_cast<float>(free + (object - free) * share);
  }
  return observed;
}

struct Direction {
  int x;
  int y;
};

// One cell a step is 2 m/s; within half a bin.
TEST_P(FilterBehaviour, AMovingObjectMovesTheRightWay) {
  for (const Direction direction : {Direction{1, 0}, Direction{-1, 0}, Direction{0, 1}, Direction{0, -1}}) {
    Cpu cpu{2};
    FilterRun run{cpu, method_config(GetParam()), still_window()};
    int x{14 - 8 * direction.x};
    int y{14 - 8 * direction.y};
    for (int step{0}; step < 18; ++step) {
      if (step > 0) {
        x += direction.x;
        y += direction.y;
      }
      run.step(scene(cells, x, y, 4, 4));
    }
    EXPECT_GT(mean_over(run.layers.occupancy, x, y, 4, 4), 0.9);
    EXPECT_NEAR(mean_over(run.layers.velocity_x, x, y, 4, 4), 2 * direction.x, 1) << direction.x << direction.y;
    EXPECT_NEAR(mean_over(run.layers.velocity_y, x, y, 4, 4), 2 * direction.y, 1) << direction.x << direction.y;
  }
}

// The same object while the car drives after it: velocities are those over ground.
TEST_P(FilterBehaviour, VelocityIsThatOverGround) {
  Cpu cpu{2};
  FilterRun run{cpu, method_config(GetParam()), still_window()};
  GridGeometry geometry{still_window()};
  for (int step{0}; step < 18; ++step) {
    if (step > 0) geometry.x_min_m += cell_m;
    run.step(scene(cells, 14, 14, 4, 4), 0.1, geometry);  // always at the same place of the window
  }
  EXPECT_NEAR(mean_over(run.layers.velocity_x, 14, 14, 4, 4), 2, 1);
  EXPECT_NEAR(mean_over(run.layers.velocity_y, 14, 14, 4, 4), 0, 0.5);
}

// All velocities are equally probable at first, as in the papers. A static prior delays the detection of motion.
FilterConfig without_static_prior(FilterModel model) {
  FilterConfig config{method_config(model)};
  config.static_prior = 1.0 / 25;
  return config;
}

// Half a cell a step lies between two velocities of the lattice.
TEST_P(FilterBehaviour, ASlowObjectLiesBetweenTwoBins) {
  Cpu cpu{2};
  FilterRun run{cpu, without_static_prior(GetParam()), still_window()};
  for (int step{0}; step < 20; ++step) run.step(scene(cells, 8 + step / 2, 14, 4, 4));
  EXPECT_NEAR(mean_over(run.layers.velocity_x, 17, 14, 4, 4), 1, 0.5);
  EXPECT_NEAR(mean_over(run.layers.velocity_y, 17, 14, 4, 4), 0, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Models, FilterBehaviour, testing::Values(FilterModel::tay2008, FilterModel::joint),
                         [](const auto& name) {
                           return std::string{names_of(name.param)[static_cast<std::size_t>(name.param)]};
                         });

double hidden_for(const FilterConfig& config, int frames) {
  Cpu cpu{2};
  FilterRun run{cpu, config, still_window()};
  for (int step{0}; step < 30; ++step) run.step(scene(cells, 14, 14, 4, 4));
  for (int step{0}; step < frames; ++step) run.step(Image<float>(cells, cells, 0.5f));
  return mean_over(run.layers.occupancy, 15, 15, 2, 2);
}

// docs/method.md §8.6 and §8.7: inner cells of a 4 × 4 object that is hidden.
TEST(FilterHiding, JointKeepsWhatIsHidden) {
  for (const FilterConfig& config : {method_config(FilterModel::joint), without_static_prior(FilterModel::joint)}) {
    EXPECT_GT(hidden_for(config, 1), 0.95);
    EXPECT_GT(hidden_for(config, 10), 0.8);
  }
}

TEST(FilterHiding, TayLosesWhatIsHidden) {
  EXPECT_NEAR(hidden_for(without_static_prior(FilterModel::tay2008), 1), 0.73, 0.1);
  EXPECT_NEAR(hidden_for(without_static_prior(FilterModel::tay2008), 5), 0.19, 0.1);
  EXPECT_LT(hidden_for(method_config(FilterModel::tay2008), 10), 0.5);
}

// A dynamic object continues behind an obstacle: after 5 unobserved steps its mass is 5 cells further.
TEST(FilterHiding, JointMovesWhatIsHidden) {
  Cpu cpu{1};
  FilterRun run{cpu, method_config(FilterModel::joint), still_window()};
  for (int step{0}; step < 12; ++step) run.step(scene(cells, 4 + step, 14, 4, 4));
  for (int step{0}; step < 5; ++step) run.step(Image<float>(cells, cells, 0.5f));
  EXPECT_GT(mean_over(run.layers.occupancy, 21, 15, 2, 2), 0.6);
  EXPECT_LT(mean_over(run.layers.occupancy, 15, 15, 2, 2), 0.3);
}

// A pedestrian walks at 1.4 m/s for 1.5 s and is hidden for 1.2 s: P > 0.5 at their place, for at least a second.
TEST(FilterHiding, AWalkerIsKeptForASecond) {
  Cpu cpu{2};
  const auto survived_s = [&](FilterModel model) {
    FilterConfig config;
    config.model = model;
    config.scene_flow = false;  // no measured velocity
    FilterRun run{cpu, config, still_window()};
    double x{4};
    const auto walker = [&](float free) { return covered(cells, x, 14, 3, 4, 0.9f, free); };
    for (int step{0}; step < 15; ++step, x += 0.7) run.step(walker(0.05f));
    double seconds{0};
    for (; seconds < 1.2; seconds += 0.1, x += 0.7) {
      run.step(Image<float>(cells, cells, 0.5f));
      if (mean_over(run.layers.occupancy, static_cast<int>(std::lround(x)), 14, 3, 4) <= 0.5) break;
    }
    return seconds;
  };
  EXPECT_GE(survived_s(FilterModel::joint), 1.0);
  EXPECT_LT(survived_s(FilterModel::tay2008), 0.5);
}

// With the default noise: speed and mass after a second behind something.
TEST(FilterHiding, JointKeepsTheSpeedOfWhatIsHidden) {
  constexpr int wide{64};
  Cpu cpu{2};
  FilterRun run{cpu, FilterConfig{}, {0, 0, cell_m, wide, wide}};
  for (int step{0}; step < 15; ++step) run.step(scene(wide, 4 + 2 * step, 30, 5, 5, 0.9f, 0.05f));
  EXPECT_NEAR(mean_over(run.layers.velocity_x, 32, 30, 5, 5), 4, 0.2);
  for (int step{0}; step < 10; ++step) run.step(Image<float>(wide, wide, 0.5f));
  EXPECT_GT(mean_over(run.layers.occupancy, 52, 30, 5, 5), 0.8);
  EXPECT_GT(mean_over(run.layers.velocity_x, 52, 30, 5, 5), 2.9);
}

// An object must be able to come in over the border with its velocity.
TEST(FilterBorder, EnteringObjectsHaveTheRightVelocity) {
  for (const FilterModel model : {FilterModel::tay2008, FilterModel::joint}) {
    Cpu cpu{1};
    FilterRun run{cpu, method_config(model), still_window()};
    for (int step{0}; step < 10; ++step) run.step(scene(cells, 0, 14, 1, 4, 0.02f));
    for (int step{1}; step <= 6; ++step) run.step(scene(cells, std::max(step - 4, 0), 14, std::min(step, 4), 4));
    EXPECT_GT(mean_over(run.layers.velocity_x, 2, 14, 4, 4), 1) << names_of(model)[static_cast<std::size_t>(model)];
  }
}

TEST(FilterModelFunctions, AntecedentsSplitAFractionalShift) {
  // a shift of 1.25 cells to the right and 0.5 down: from a cell at −1.25 (between −2 and −1) and +0.5
  const Antecedents from{antecedents(1.25, -0.5, 0, 0)};
  EXPECT_EQ(from.ix, -2);
  EXPECT_EQ(from.iy, 0);
  EXPECT_NEAR(from.fx, 0.75, 1e-6);
  EXPECT_NEAR(from.fy, 0.5, 1e-6);
  const Antecedents still{antecedents(0, 0, 3, -2)};
  EXPECT_EQ(still.ix, 3);
  EXPECT_EQ(still.iy, -2);
  EXPECT_EQ(still.fx, 0);
  EXPECT_EQ(still.fy, 0);
}

}  // namespace
}  // namespace stereogrid::test
