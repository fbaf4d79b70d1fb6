// SPDX-License-Identifier: Apache-2.0
#include "terrain/elevation_memory.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stereogrid {
namespace {

constexpr int cells{40};
constexpr float sigma_m{0.02f};

class ElevationMemoryTest : public testing::Test {
 protected:
  /// A frame that sees the cells before `end` of each row.
  template <class Elevation>
  void add(const Elevation& elevation_of, int end = cells) {
    for (int iy{0}; iy < cells; ++iy) {
      memory_.begin_row(iy);
      for (int ix{0}; ix < end; ++ix) memory_.see(ix, iy, elevation_of(ix, iy), sigma_m);
    }
    memory_.add();
    memory_.write(elevation_m_, sigma_m_);
  }
  void add_level(float elevation_m, int end = cells) {
    add([&](int, int) { return elevation_m; }, end);
  }

  ElevationMemory memory_{0.1, cells};
  Image<float> elevation_m_{cells, cells};
  Image<float> sigma_m_{cells, cells};
};

TEST_F(ElevationMemoryTest, IsEmptyBeforeTheFirstFrame) {
  memory_.write(elevation_m_, sigma_m_);
  EXPECT_TRUE(std::isnan(elevation_m_(3, 3)));
  EXPECT_TRUE(std::isnan(sigma_m_(3, 3)));
}

TEST_F(ElevationMemoryTest, AveragesFramesButNotForEver) {
  add_level(0.1f);
  EXPECT_FLOAT_EQ(elevation_m_(3, 3), 0.1f);
  EXPECT_FLOAT_EQ(sigma_m_(3, 3), sigma_m);
  for (int i{0}; i < 10; ++i) add_level(0.1f);
  EXPECT_NEAR(elevation_m_(3, 3), 0.1f, 1e-4f);
  EXPECT_NEAR(sigma_m_(3, 3), sigma_m / std::sqrt(2.0f), 1e-3f);
}

TEST_F(ElevationMemoryTest, CellsOutOfViewFollowThePlaneOfTheVehicle) {
  const auto tilted = [](int ix, int) { return -0.002f * (static_cast<float>(ix) - cells / 2.0f); };  // 1.1°
  add_level(0);
  add(tilted, cells / 2);
  const int far{cells - 2};
  EXPECT_NEAR(elevation_m_(far, 20), tilted(far, 20), 0.006f);
  EXPECT_GT(sigma_m_(far, 20), sigma_m_(cells / 2, 20));
  EXPECT_GT(sigma_m_(far, 20), sigma_m);
}

TEST_F(ElevationMemoryTest, AHeightThatContradictsReplacesTheMemory) {
  add_level(0);
  add([](int ix, int iy) { return ix == 7 && iy == 8 ? 0.5f : 0.0f; });
  EXPECT_FLOAT_EQ(elevation_m_(7, 8), 0.5f);
  EXPECT_FLOAT_EQ(sigma_m_(7, 8), sigma_m);
  EXPECT_NEAR(elevation_m_(8, 8), 0, 1e-3f);
}

TEST_F(ElevationMemoryTest, MovesWithTheWindow) {
  add_level(0.1f, cells / 2);
  memory_.move({5, 0});
  memory_.write(elevation_m_, sigma_m_);
  EXPECT_FLOAT_EQ(elevation_m_(cells / 2 - 6, 0), 0.1f);
  EXPECT_TRUE(std::isnan(elevation_m_(cells / 2 - 5, 0)));
}

}  // namespace
}  // namespace stereogrid
