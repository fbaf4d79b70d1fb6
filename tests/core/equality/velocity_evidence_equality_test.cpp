// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// What is told to the filter of velocities: cells side by side give the same as one after the other, bit for bit.
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
    for (Image<float>& masses : state.velocity) {
      for (float& mass : masses) mass = share(random) * share(random) / 169;
    }
    for (float& p : layers.occupancy) p = share(random);
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
    evidence.push_back({cell, 10 * unit(random), 10 * unit(random), 2 + unit(random), unit(random), 2 + unit(random)});
  }
  return evidence;
}

void expect_equal(const World& expected, const World& actual) {
  EXPECT_EQ(actual.state.velocity, expected.state.velocity);
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
      WeighingSpace space{cells, actual.tables, cpu.threads()};
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
