// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "filter_run.hpp"
#include "support.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

constexpr double cell_m{0.2};

// Patches of free, occupied, unknown and in-between.
Image<float> random_observation(int cells, std::mt19937& generator) {
  Image<float> observed{cells, cells, 0.5f};
  for (float& p : observed) {
    const double kind{uniform(generator, 0, 1)};
    p = static_cast<float>(kind < 0.3 ? 0.5 : (kind < 0.4 ? 1.0 : (kind < 0.6 ? 0.0 : uniform(generator, 0, 1))));
  }
  return observed;
}

bool same_bits(float a, float b) {
  return a == b || (std::isinf(a) && std::isinf(b));
}

int differences(const Image<float>& a, const Image<float>& b) {
  int different{0};
  for (std::size_t i{0}; i < a.size(); ++i) different += same_bits(a.data()[i], b.data()[i]) ? 0 : 1;
  return different;
}

constexpr Image<float> GridLayers::*all_layers[]{
    &GridLayers::occupancy,   &GridLayers::velocity_x,  &GridLayers::velocity_y,  &GridLayers::age_s,
    &GridLayers::velocity_xx, &GridLayers::velocity_xy, &GridLayers::velocity_yy, &GridLayers::moving};

struct Move {
  int x;
  int y;
};

class FilterOfEachModel : public testing::TestWithParam<FilterModel> {};

TEST_P(FilterOfEachModel, CpuEqualsReference) {
  std::mt19937 generator{17};
  for (const int cells : {1, 5, 23, 34, 137, 261}) {  // the last: wider than a tile of the vector code
    for (const int threads : {1, 2}) {
      FilterConfig config{method_config(GetParam())};
      config.speeds_mps = {1.3, 2.6, 3.9};  // fractions of a cell
      config.likelihood_exponent = 0.6;
      Reference reference;
      Cpu cpu{threads};
      GridGeometry geometry{-1, 2, cell_m, cells, cells};
      FilterRun slow{reference, config, geometry};
      FilterRun fast{cpu, config, geometry};
      const double steps_s[]{0.1, 0.033, 0.25, 0.1, 0.1, 0.1, 0.0};
      const Move moves[]{{0, 0}, {1, 0}, {-2, 3}, {0, -1}, {40, 0}, {0, -40}, {3, 3}};
      const std::size_t steps{cells > 200 ? 2 : std::size(moves)};
      for (std::size_t i{0}; i < steps; ++i) {
        geometry.x_min_m += moves[i].x * cell_m;
        geometry.y_min_m += moves[i].y * cell_m;
        const Image<float> observed{random_observation(cells, generator)};
        slow.step(observed, steps_s[i], geometry);
        fast.step(observed, steps_s[i], geometry);
        const auto where = testing::Message() << cells << " cells, " << threads << " threads, step " << i;
        for (const auto layer : all_layers) {
          EXPECT_EQ(differences(slow.layers.*layer, fast.layers.*layer), 0) << where;
        }
        for (std::size_t k{0}; k < slow.tables.lattice.size(); ++k) {
          EXPECT_EQ(differences(masses_of(slow.now, k), masses_of(fast.now, k)), 0) << where << ", velocity " << k;
        }
        EXPECT_EQ(fast.layers.geometry, geometry);
        EXPECT_EQ(fast.now.geometry, geometry);
      }
    }
  }
}

// Rows whose length is no multiple of any vector's.
TEST_P(FilterOfEachModel, EveryInstructionSetEqualsTheReference) {
  constexpr int cells{31};
  FilterConfig config{method_config(GetParam())};
  config.speeds_mps = {1.3, 2.6, 3.9};
  const GridGeometry geometry{0, 0, cell_m, cells, cells};
  for (const std::int64_t target : vector_targets()) {
    const ForcedTarget forced{target};
    std::mt19937 generator{19};
    Reference reference;
    Cpu cpu{1};
    FilterRun slow{reference, config, geometry};
    FilterRun fast{cpu, config, geometry};
    for (int step{0}; step < 4; ++step) {
      const Image<float> observed{random_observation(cells, generator)};
      slow.step(observed);
      fast.step(observed);
      for (const auto layer : all_layers) {
        EXPECT_EQ(differences(slow.layers.*layer, fast.layers.*layer), 0) << name_of_target(target);
      }
    }
  }
}

// Hard contradictions, 0 against 1, for a hundred frames.
TEST_P(FilterOfEachModel, MassStaysBetweenZeroAndOne) {
  std::mt19937 generator{23};
  Cpu cpu{2};
  constexpr int cells{20};
  GridGeometry geometry{0, 0, cell_m, cells, cells};
  FilterRun run{cpu, method_config(GetParam()), geometry};
  for (int step{0}; step < 100; ++step) {
    Image<float> observed{random_observation(cells, generator)};
    for (int x{0}; x < cells; ++x) observed(x, 3) = step % 2 == 0 ? 0.0f : 1.0f;
    if (step % 7 == 0) geometry.x_min_m += cell_m;
    run.step(observed, 0.1, geometry);
    for (const auto [x, y] : raster(cells, cells)) {
      double mass{0};
      for (std::size_t k{0}; k < run.tables.lattice.size(); ++k) {
        ASSERT_GE(mass_of(run.now, k, x, y), 0) << x << " " << y << " step " << step;
        mass += mass_of(run.now, k, x, y);
      }
      const float occupancy{run.layers.occupancy(x, y)};
      ASSERT_TRUE(occupancy >= 0 && occupancy <= 1.000001f) << occupancy;
      // joint: the mass is the occupancy; tay2008: velocities are a distribution of their own
      const bool joint{GetParam() == FilterModel::joint};
      ASSERT_NEAR(mass, joint ? occupancy : 1.0f, 1e-4f);
      ASSERT_LE(std::abs(run.layers.velocity_x(x, y)), 4.0001f);
      ASSERT_LE(std::abs(run.layers.velocity_y(x, y)), 4.0001f);
      ASSERT_TRUE(run.layers.moving(x, y) >= 0 && run.layers.moving(x, y) <= occupancy + 1e-6f);
      const float xx{run.layers.velocity_xx(x, y)};
      const float yy{run.layers.velocity_yy(x, y)};
      const float xy{run.layers.velocity_xy(x, y)};
      ASSERT_TRUE(xx >= 0 && yy >= 0 && xy * xy <= xx * yy + 1e-4f) << xx << " " << xy << " " << yy;
    }
  }
}

TEST_P(FilterOfEachModel, NeverObservedStaysUnknown) {
  Cpu cpu{1};
  constexpr int cells{20};
  GridGeometry geometry{0, 0, cell_m, cells, cells};
  FilterRun run{cpu, method_config(GetParam()), geometry};
  const Image<float> nothing{cells, cells, 0.5f};
  for (int step{0}; step < 40; ++step) {
    geometry.y_min_m += step % 3 == 0 ? cell_m : 0;
    run.step(nothing, 0.1, geometry);
  }
  // mass from cells that entered the window moves a little between unobserved cells
  for (const float p : run.layers.occupancy) EXPECT_NEAR(p, 0.5, 0.03);
  for (const float age : run.layers.age_s) EXPECT_TRUE(std::isinf(age));
}

// With one velocity, standstill, the posterior is Bayes' rule for two coins and can be written down.
TEST_P(FilterOfEachModel, OneCellByHand) {
  Cpu cpu{1};
  FilterConfig config{method_config(GetParam())};
  config.speeds_mps = {};
  FilterRun run{cpu, config, {0, 0, cell_m, 5, 5}};
  run.step(Image<float>(5, 5, 0.8f), 0.1);
  // the prediction of 0.5 is 0.5 with any decay; then 0.8
  EXPECT_NEAR(run.layers.occupancy(2, 2), 0.8, 1e-5);
  run.step(Image<float>(5, 5, 0.3f), 0.1);
  // eps = (1 − exp(−0.1/4.95))/2 = 0.0100; prediction 0.8·0.9900 + 0.2·0.0100 = 0.7940;
  // 0.3·0.7940/(0.3·0.7940 + 0.7·0.2060) = 0.62291
  EXPECT_NEAR(run.layers.occupancy(2, 2), 0.62291, 2e-5);
}

TEST_P(FilterOfEachModel, ExponentTempersTheEvidence) {
  Cpu cpu{1};
  FilterConfig config{method_config(GetParam())};
  config.speeds_mps = {};
  config.likelihood_exponent = 0.5;
  FilterRun run{cpu, config, {0, 0, cell_m, 5, 5}};
  run.step(Image<float>(5, 5, 0.9f), 0.1);
  // sqrt(0.9)/(sqrt(0.9) + sqrt(0.1)) = 3/4
  EXPECT_NEAR(run.layers.occupancy(2, 2), 0.75, 1e-5);
}

TEST_P(FilterOfEachModel, AnUnknownObservationLeavesThePrediction) {
  Cpu cpu{1};
  FilterConfig config{method_config(GetParam())};
  config.speeds_mps = {};
  FilterRun run{cpu, config, {0, 0, cell_m, 5, 5}};
  run.step(Image<float>(5, 5, 0.8f), 0.1);
  run.step(Image<float>(5, 5, 0.5f), 0.1);
  EXPECT_NEAR(run.layers.occupancy(2, 2), 0.7940, 2e-5);
}

TEST_P(FilterOfEachModel, DecayDoesNotDependOnTheFrameRate) {
  Cpu cpu{1};
  FilterConfig config{method_config(GetParam())};
  config.speeds_mps = {};
  config.decay_time_s = 2;
  const GridGeometry geometry{0, 0, cell_m, 5, 5};
  FilterRun coarse{cpu, config, geometry};
  FilterRun fine{cpu, config, geometry};
  const Image<float> nothing{5, 5, 0.5f};
  for (auto* run : {&coarse, &fine}) run->step(Image<float>(5, 5, 0.9f), 0.1);
  for (int i{0}; i < 10; ++i) coarse.step(nothing, 0.2);
  for (int i{0}; i < 20; ++i) fine.step(nothing, 0.1);
  // after one time constant 1/e of the departure from 0.5 is left
  EXPECT_NEAR(coarse.layers.occupancy(2, 2), 0.5 + 0.4 * std::exp(-1.0), 1e-4);
  EXPECT_NEAR(fine.layers.occupancy(2, 2), coarse.layers.occupancy(2, 2), 1e-4);
}

// The noise of a second is the same in one step as in twenty.
TEST(FilterNoise, DoesNotDependOnTheFrameRate) {
  const FilterConfig config{method_config(FilterModel::joint)};
  const FilterTables tables{config};
  const GridGeometry geometry{0, 0, cell_m, 5, 5};
  const FilterStep coarse{step_of({config, tables, geometry, 1.0})};
  const FilterStep fine{step_of({config, tables, geometry, 0.05})};
  EXPECT_NEAR(std::pow(fine.kept_moving, 20), coarse.kept_moving, 1e-5);
  EXPECT_NEAR(std::pow(fine.kept_standing, 20), coarse.kept_standing, 1e-5);
  EXPECT_NEAR(step_of({config, tables, geometry, 0.1}).kept_moving, 1 - config.velocity_noise, 1e-6);
  for (const FilterStep& step : {coarse, fine}) {
    // mass goes from one velocity to another and is not lost
    EXPECT_NEAR(step.kept_standing + 24 * step.start, 1, 1e-6);
    EXPECT_NEAR(step.kept_moving + 24 * step.spread + step.stop, 1, 1e-6);
  }
}

TEST_P(FilterOfEachModel, AgeGrowsAndIsResetBySeeing) {
  Cpu cpu{1};
  GridGeometry geometry{0, 0, cell_m, 8, 8};
  FilterRun run{cpu, method_config(GetParam()), geometry};
  Image<float> observed{8, 8, 0.5f};
  observed(3, 4) = 0.9f;
  observed(5, 4) = 0.54f;  // too near to 0.5 to count
  run.step(observed, 0.1);
  EXPECT_EQ(run.layers.age_s(3, 4), 0);
  EXPECT_TRUE(std::isinf(run.layers.age_s(4, 4)));
  EXPECT_TRUE(std::isinf(run.layers.age_s(5, 4)));
  observed.fill(0.5f);
  run.step(observed, 0.1);
  // the window moves by a cell: (3, 4) becomes (2, 4)
  geometry.x_min_m += cell_m;
  run.step(observed, 0.25, geometry);
  EXPECT_NEAR(run.layers.age_s(2, 4), 0.35, 1e-6);
  EXPECT_TRUE(std::isinf(run.layers.age_s(3, 4)));
  observed(2, 4) = 0.1f;
  run.step(observed, 0.1);
  EXPECT_EQ(run.layers.age_s(2, 4), 0);
}

TEST_P(FilterOfEachModel, WhatEntersTheWindowIsUnknown) {
  Cpu cpu{1};
  GridGeometry geometry{0, 0, cell_m, 12, 12};
  FilterRun run{cpu, method_config(GetParam()), geometry};
  for (int i{0}; i < 5; ++i) run.step(Image<float>(12, 12, 0.02f));
  geometry.x_min_m += 3 * cell_m;
  run.step(Image<float>(12, 12, 0.5f), 0.1, geometry);
  for (int y{0}; y < 12; ++y) {
    // tay2008 lets free space from next door in: the prediction is a mean over antecedents
    EXPECT_NEAR(run.layers.occupancy(11, y), 0.5, GetParam() == FilterModel::joint ? 1e-4 : 0.02);
    EXPECT_TRUE(std::isinf(run.layers.age_s(9, y)));
    EXPECT_FALSE(std::isinf(run.layers.age_s(8, y)));
  }
  EXPECT_LT(run.layers.occupancy(4, 6), 0.15);
}

INSTANTIATE_TEST_SUITE_P(Models, FilterOfEachModel, testing::Values(FilterModel::tay2008, FilterModel::joint),
                         [](const auto& name) {
                           return std::string{names_of(name.param)[static_cast<std::size_t>(name.param)]};
                         });

// Repeated observations of a static vehicle move a cell to their own odds at most. With motion, evidence accumulates;
// contradicting evidence counts in full.
TEST(FilterRepetition, TheSameViewCountsOnce) {
  FilterStep step{};
  step.kept_moving = step.kept_standing = step.prior_static = 1;
  CellView view{1, 0, 1, 0, 0};
  const FilterTables tables{FilterConfig{}};
  const auto after = [&](float before, float observed, int steps) {
    const Likelihood likelihood{likelihood_of(tables.likelihood.data(), observed)};
    for (int i{0}; i < steps; ++i) before = joint_update(step, before, 0.0f, 0.1f, likelihood, view).occupancy;
    return before;
  };
  EXPECT_NEAR(after(0.5f, 0.7f, 50), 0.7f, 1e-4);
  EXPECT_NEAR(after(0.5f, 0.2f, 50), 0.2f, 1e-4);
  EXPECT_NEAR(after(0.9f, 0.7f, 50), 0.9f, 1e-4) << "what was known is not taken back";
  const float once{after(0.9f, 0.1f, 1)};
  view.repeated = 0;
  EXPECT_FLOAT_EQ(once, after(0.9f, 0.1f, 1));
  EXPECT_GT(after(0.5f, 0.7f, 50), 0.99f);
  view.repeated = 0.5f;
  const float half{after(0.5f, 0.7f, 5)};
  EXPECT_GT(half, 0.71f);
  EXPECT_LT(half, 0.98f);
}

}  // namespace
}  // namespace stereogrid::test
