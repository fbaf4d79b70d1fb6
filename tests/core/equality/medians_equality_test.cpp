// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Medians of sectors by vectors, on every instruction set of this machine, against plain loops.
#include <gtest/gtest.h>

#include <random>
#include <utility>
#include <vector>

#include "geometry/relief.hpp"
#include "targets.hpp"
#include "terrain/medians.hpp"

namespace stereogrid::test {
namespace {

TEST(MediansEquality, OnEveryInstructionSet) {
  std::mt19937 random{5};
  for (const auto& [width, height] : {std::pair{5, 9}, {8, 1}, {16, 7}, {31, 8}, {64, 33}, {40, 100}}) {
    Image<float> obstacle{width, height};
    Image<float> road{width, height};
    for (int i{0}; i < width * height; ++i) {
      Image<float>& one{random() % 2 == 0 ? obstacle : road};
      if (random() % 3 != 0) one(i % width, i / width) = static_cast<float>(1 + random() % 60) / 4;
    }
    const View<const float> obstacles{std::as_const(obstacle).view()};
    const View<const float> roads{std::as_const(road).view()};
    for (int sector{0}; sector < relief_sectors(width); ++sector) {
      const int column{sector * sector_px};
      const int first_row{static_cast<int>(random() % static_cast<unsigned>(height + 1))};
      const auto rows = static_cast<std::size_t>(height - first_row);
      std::vector<float> expected(rows);
      plain::find_medians(obstacles, roads, column, {first_row, height}, expected.data());
      for (const std::int64_t target : vector_targets()) {
        const ForcedTarget forced{target};
        std::vector<float> actual(rows);
        find_medians(obstacles, roads, column, {first_row, height}, actual.data());
        EXPECT_EQ(expected, actual) << name_of_target(target) << ", " << width << " px";
      }
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
