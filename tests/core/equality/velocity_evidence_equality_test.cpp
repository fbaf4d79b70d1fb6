// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Evidence of velocities for the filter: cells in vectors give the same as one by one, bit for bit.
#include <gtest/gtest.h>

#include <random>

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "filter_run.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

struct World {
  explicit World(int cells, unsigned seed) : config{config_of()}, tables{config}, state{cells, config} {
    layers = grid_layers({0, 0, 0.2, cells, cells});
    std::mt19937 random{seed};
    std::uniform_real_distribution<float> share{0, 1};
    for (float& p : state.occupancy) p = share(random);
    layers.occupancy = state.occupancy;
    for (int i{0}; i < cells * cells; ++i) {
      const int x{i % cells};
      const int y{i / cells};
      state.standing(x, y) = share(random) * state.occupancy(x, y);
    }
    // every second block has masses, which are others than those spread evenly
    for (int block{0}; block < state.blocks.layout().count(); block += 2) state.blocks.want(block);
    allocate_marked_blocks(tables, state);
    for (int block{0}; block < state.blocks.layout().count(); block += 2) {
      for (int i{0}; i < 168 * block_cells; ++i) state.blocks.masses(block / 2)[i] *= 2 * share(random);
    }
  }

  static FilterConfig config_of() {
    FilterConfig config;
    config.model = FilterModel::joint;
    return config;
  }

  FilterConfig config;
  FilterTables tables;
  FilterState state;
  GridLayers layers;
};

// About `percent` of the cells, the last one among them.
std::vector<VelocityEvidence> some_evidence(int cells, unsigned percent, std::mt19937& random) {
  std::uniform_real_distribution<float> unit{-1, 1};
  std::vector<VelocityEvidence> evidence;
  for (int cell{0}; cell < cells * cells; ++cell) {
    if (random() % 100 >= percent && cell + 1 < cells * cells) continue;
    evidence.push_back({cell, 10 * unit(random), 10 * unit(random), 2 + unit(random), unit(random), 2 + unit(random), 0,
                        cell % 3 == 0 ? 1 : 0});
  }
  return evidence;
}

void expect_equal(const World& expected, const World& actual) {
  EXPECT_EQ(actual.state.standing, expected.state.standing);
  for (std::size_t k{0}; k < expected.tables.lattice.size(); ++k) {
    EXPECT_EQ(masses_of(actual.state, k), masses_of(expected.state, k)) << k;
  }
  EXPECT_EQ(actual.layers.moving, expected.layers.moving);
  EXPECT_EQ(actual.layers.velocity_x, expected.layers.velocity_x);
  EXPECT_EQ(actual.layers.velocity_y, expected.layers.velocity_y);
  EXPECT_EQ(actual.layers.velocity_xx, expected.layers.velocity_xx);
  EXPECT_EQ(actual.layers.velocity_xy, expected.layers.velocity_xy);
  EXPECT_EQ(actual.layers.velocity_yy, expected.layers.velocity_yy);
}

void compare_on_random_evidence() {
  std::mt19937 random{11};
  Reference reference;
  for (const int cells : {3, 4, 29}) {
    for (const unsigned percent : {2u, 30u, 100u}) {
      World expected{cells, 5};
      World actual{expected};
      const std::vector<VelocityEvidence> evidence{some_evidence(cells, percent, random)};
      weigh_velocities(reference, evidence, expected.tables, expected.state, expected.layers);
      Cpu cpu{static_cast<int>(1 + percent % 3)};
      WeighingWorkspace space{cells, actual.tables, cpu.threads()};
      weigh_velocities(cpu, evidence, actual.tables, space, actual.state, actual.layers);
      SCOPED_TRACE(testing::Message() << cells << " cells along a side, " << percent << " %");
      expect_equal(expected, actual);
    }
  }
}

TEST(Evidence, CpuEqualsReferenceOnEveryTarget) {
  for (const std::int64_t target : vector_targets()) {
    SCOPED_TRACE(name_of_target(target));
    const ForcedTarget forced{target};
    compare_on_random_evidence();
  }
}

}  // namespace
}  // namespace stereogrid::test
