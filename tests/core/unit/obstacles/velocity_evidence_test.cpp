// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "filter_run.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

constexpr int cells{20};
constexpr GridGeometry geometry{0, 0, 0.2, cells, cells};

double mass_at(const FilterState& state, int x, int y) {
  double sum{0};
  for (std::size_t k{0}; k < 25; ++k) sum += mass_of(state, k, x, y);
  return sum;
}

VelocitySums sums_of(const FilterRun<Cpu>& run, int x, int y) {
  VelocitySums sums;
  for (std::size_t row{0}; row < 5; ++row) {
    LatticeRowSums<float> of_row;
    for (std::size_t i{0}; i < 5; ++i) of_row.add(run.tables.axis_mps[i], mass_of(run.now, 5 * row + i, x, y));
    sums.add(run.tables.axis_mps[row], of_row);
  }
  return sums;
}

// A thing that has just been seen at (8, 8), 4 × 4 cells.
struct Seen {
  Seen() : run{cpu, method_config(FilterModel::joint), geometry} {
    for (int i{0}; i < 3; ++i) run.step(scene(cells, 8, 8, 4, 4));
  }

  void weigh(std::span<const VelocityEvidence> evidence) {
    WeighingWorkspace space{cells, run.tables, cpu.threads()};
    weigh_velocities(cpu, evidence, run.tables, space, run.now, run.layers);
  }

  Cpu cpu{1};
  FilterRun<Cpu> run;
};

TEST(VelocityEvidence, IsBayesRuleOverTheLattice) {
  Seen seen;
  FilterRun<Cpu>& run{seen.run};
  const VelocityEvidence evidence{9 * cells + 10, 2, 0, 1.5f, 0.2f, 0.8f};
  const FilterState before{run.now};
  seen.weigh({&evidence, 1});

  double all{0};
  for (std::size_t k{0}; k < run.tables.lattice.size(); ++k) {
    const Point2 v{run.tables.lattice[k]};
    all += mass_of(before, k, 10, 9) * likelihood_of(evidence, static_cast<float>(v.x), static_cast<float>(v.y));
  }
  const double total{mass_at(before, 10, 9)};
  double mean_x{0};
  for (std::size_t k{0}; k < run.tables.lattice.size(); ++k) {
    const Point2 v{run.tables.lattice[k]};
    const double share{mass_of(before, k, 10, 9) *
                       likelihood_of(evidence, static_cast<float>(v.x), static_cast<float>(v.y)) / all};
    EXPECT_NEAR(mass_of(run.now, k, 10, 9), total * share, 1e-6) << k;
    mean_x += share * v.x;
  }
  const float standing{mass_of(run.now, 12, 10, 9)};
  const WeighedCell cell{sums_of(run, 10, 9), standing};
  EXPECT_NEAR(estimate_of(cell.sums).x, mean_x, 1e-4);
  EXPECT_NEAR(run.layers.velocity_x(10, 9), refined(evidence, run.tables.axis_mps.data(), 5, cell).x, 1e-4);
  EXPECT_NEAR(run.layers.moving(10, 9), run.layers.occupancy(10, 9) - mass_of(run.now, 12, 10, 9), 1e-6);
}

// The lattice of the test has steps of 2 m/s.
TEST(VelocityEvidence, RefinesTheVelocityBetweenThoseOfTheLattice) {
  Seen seen;
  const float j{1 / (0.1f + 2 * 2 / 6.0f)};  // for a variance of 0.1 m²/s²
  const VelocityEvidence evidence{9 * cells + 10, 2.8f, 0, j, 0, j};
  for (int i{0}; i < 8; ++i) seen.weigh({&evidence, 1});
  const FilterRun<Cpu>& run{seen.run};
  const float of_lattice{estimate_of(sums_of(run, 10, 9)).x};
  EXPECT_GT(std::abs(of_lattice - 2.8f), 0.4f);
  EXPECT_LT(std::abs(run.layers.velocity_x(10, 9) - 2.8f), 0.2f);
}

TEST(VelocityEvidence, LeavesWhetherACellIsOccupiedAndOtherCellsAlone) {
  Seen seen;
  FilterRun<Cpu>& run{seen.run};
  const VelocityEvidence evidence{9 * cells + 10, 2, 0, 4, 0, 4};
  const GridLayers layers{run.layers};
  const FilterState before{run.now};
  seen.weigh({&evidence, 1});
  EXPECT_EQ(run.layers.occupancy, layers.occupancy);
  EXPECT_NEAR(mass_at(run.now, 10, 9), mass_at(before, 10, 9), 1e-5);
  EXPECT_GT(run.layers.velocity_x(10, 9), layers.velocity_x(10, 9) + 0.8);
  EXPECT_EQ(run.layers.velocity_x(11, 9), layers.velocity_x(11, 9));
  for (std::size_t k{0}; k < run.tables.lattice.size(); ++k) {
    EXPECT_EQ(mass_of(run.now, k, 11, 9), mass_of(before, k, 11, 9));
  }
}

// A static object that several features see moving off.
TEST(VelocityEvidence, ThatStartsMotionIsAcceptedAtOnce) {
  const auto moving_after = [](int starts_motion) {
    Seen seen;
    seen.run.now.blocks.clear();
    for (int i{0}; i < cells * cells; ++i) {
      const int x{i % cells};
      const int y{i / cells};
      seen.run.now.standing(x, y) = 0.99f * seen.run.now.occupancy(x, y);
    }
    const VelocityEvidence evidence{9 * cells + 10, 2, 0, 8, 0, 8, 0, starts_motion};
    const double before{mass_at(seen.run.now, 10, 9)};
    seen.weigh({&evidence, 1});
    EXPECT_NEAR(mass_at(seen.run.now, 10, 9), before, 1e-5);
    return seen.run.layers.moving(10, 9);
  };
  EXPECT_LT(moving_after(0), 0.1f);
  EXPECT_GT(moving_after(1), 0.5f);
}

TEST(VelocityEvidence, OfSomethingElseChangesLittle) {
  Seen seen;
  FilterRun<Cpu>& run{seen.run};
  const VelocityEvidence evidence{9 * cells + 10, 60, -70, 4, 0, 4};
  const float before{run.layers.velocity_x(10, 9)};
  seen.weigh({&evidence, 1});
  EXPECT_NEAR(run.layers.velocity_x(10, 9), before, 0.05);
}

TEST(VelocityEvidence, MovesAThingOnWithTheNextStep) {
  Seen seen;
  FilterRun<Cpu>& run{seen.run};
  std::vector<VelocityEvidence> evidence;
  for (const auto [x, y] : raster(8, 12, 8, 12)) evidence.push_back({y * cells + x, 2, 0, 8, 0, 8});
  for (int i{0}; i < 3; ++i) seen.weigh(evidence);
  run.step(Image<float>{cells, cells, 0.5f});
  EXPECT_GT(run.layers.occupancy(12, 9), 0.7) << "a cell further, unseen";
  EXPECT_LT(run.layers.occupancy(8, 9), 0.3);
}

// Occupancy of a cell of which 30 frames show nothing, while points beside it are measured to stand. `seen`: in the
// frame before them.
template <class BackEndType>
float unobserved_after(BackEndType& back_end, float seen, int is_repeated) {
  FilterRun<BackEndType> run{back_end, method_config(FilterModel::joint), geometry};
  WeighingWorkspace space{cells, run.tables, 1};
  Image<float> observed{cells, cells, 0.5f};
  observed(2, 2) = 0.9f;
  observed(10, 9) = seen;
  const VelocityEvidence evidence{9 * cells + 10, 0, 0, 4, 0, 4, is_repeated};
  for (int i{0}; i < 30; ++i) {
    run.step(observed);
    weigh_velocities(back_end, std::span{&evidence, 1}, run.tables, space, run.now, run.layers);
    observed(10, 9) = 0.5f;
  }
  return run.layers.occupancy(10, 9);
}

TEST(VelocityEvidence, OfStandstillDoesNotFillAnUnobservedCellWhenRepeated) {
  Cpu cpu{1};
  Reference reference;
  EXPECT_GT(unobserved_after(cpu, 0.44f, 0), 0.6f) << "mass that arrives comes to stand";
  EXPECT_LT(unobserved_after(cpu, 0.44f, 1), 0.55f);
  EXPECT_EQ(unobserved_after(reference, 0.44f, 1), unobserved_after(cpu, 0.44f, 1));
}

TEST(VelocityEvidence, OfStandstillDoesNotFillACellThatWasNeverObserved) {
  Cpu cpu{1};
  Reference reference;
  EXPECT_LT(unobserved_after(cpu, 0.5f, 0), 0.55f);
  EXPECT_EQ(unobserved_after(reference, 0.5f, 0), unobserved_after(cpu, 0.5f, 0));
}

// Half of the cells have been observed.
TEST(VelocityEvidence, IsIgnoredAlikeByBothBackEnds) {
  Cpu cpu{2};
  Reference reference;
  FilterRun<Cpu> fast{cpu, method_config(FilterModel::joint), geometry};
  FilterRun<Reference> slow{reference, method_config(FilterModel::joint), geometry};
  WeighingWorkspace space{cells, fast.tables, 2};
  Image<float> observed{scene(cells, 8, 8, 4, 4)};
  std::vector<VelocityEvidence> evidence;
  for (int cell{0}; cell < cells * cells; cell += 3)
    evidence.push_back({cell, 0.5f, 1.5f, 4, 0, 4, cell % 2, 0, cell / 2 % 2});
  for (int i{0}; i < 4; ++i) {
    for (int y{0}; y < cells; y += 2) std::fill_n(observed.row(y), cells, 0.5f);
    fast.step(observed);
    slow.step(observed);
    weigh_velocities(cpu, evidence, fast.tables, space, fast.now, fast.layers);
    weigh_velocities(reference, evidence, slow.tables, slow.now, slow.layers);
    EXPECT_EQ(fast.layers.occupancy, slow.layers.occupancy);
    EXPECT_EQ(fast.layers.moving, slow.layers.moving);
    EXPECT_EQ(fast.layers.velocity_x, slow.layers.velocity_x);
  }
}

}  // namespace
}  // namespace stereogrid::test
