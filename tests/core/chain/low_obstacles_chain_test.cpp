// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Statements of docs/terrain.md about kerbs and low boxes, on the scene `boxes`.
#include <gtest/gtest.h>

#include <algorithm>

#include "chain_run.hpp"

namespace stereogrid::test {
namespace {

constexpr const char* kitti_camera{"boxes?width=1242&height=375"};
constexpr std::size_t frames{4};
constexpr float free_below{0.45f};
constexpr float occupied_above{0.55f};

/// Largest probability of the cells between two corners.
float highest(const FrameResult& result, const Image<float>& cells, Point2 low, Point2 high) {
  const GridGeometry& grid{result.vehicle.geometry};
  float found{0};
  for (int iy{0}; iy < grid.ny; ++iy) {
    const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
    for (int ix{0}; ix < grid.nx; ++ix) {
      const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m};
      if (x >= low.x && x <= high.x && y >= low.y && y <= high.y) found = std::max(found, cells(ix, iy));
    }
  }
  return found;
}

/// The filtered grid after some frames. Box i stands at (8.2, 2·i − 4) and (14.2, 2·i − 5).
class Boxes {
 public:
  explicit Boxes(const Config& config) : drive_{kitti_camera, config} {
    for (std::size_t i{0}; i < frames; ++i) result_ = &drive_.step(i);
  }

  [[nodiscard]] float near(int box) const { return at(8.2, 2.0 * box - 4); }
  [[nodiscard]] float far(int box) const { return at(14.2, 2.0 * box - 5); }
  [[nodiscard]] float kerb() const { return highest(*result_, result_->vehicle.occupancy, {10, -6.5}, {18, -5.6}); }

 private:
  [[nodiscard]] float at(double x, double y) const {
    return highest(*result_, result_->vehicle.occupancy, {x - 0.5, y - 0.4}, {x + 0.5, y + 0.4});
  }

  Drive drive_;
  const FrameResult* result_{nullptr};
};

enum Height { cm_10, cm_15, cm_20, cm_30, cm_50 };

TEST(LowObstacles, ByDefaultWhatAWheelClimbsIsRoad) {
  const Boxes boxes{preset("default")};
  EXPECT_LT(boxes.near(cm_10), free_below);
  EXPECT_LT(boxes.far(cm_10), free_below);
  EXPECT_LT(boxes.kerb(), free_below);
  for (const Height high : {cm_20, cm_30, cm_50}) EXPECT_GT(boxes.near(high), occupied_above) << high;
  EXPECT_GT(boxes.far(cm_50), occupied_above);
}

TEST(LowObstacles, OverAPlaneTwentyCentimetresAreRoad) {
  Config config{preset("default")};
  config.ground.model = GroundModel::plane;
  const Boxes boxes{config};
  for (const Height low : {cm_10, cm_15, cm_20}) {
    EXPECT_LT(boxes.near(low), free_below) << low;
    EXPECT_LT(boxes.far(low), free_below) << low;
  }
  EXPECT_LT(boxes.kerb(), free_below);
  EXPECT_GT(boxes.near(cm_30), occupied_above);
  EXPECT_GT(boxes.near(cm_50), occupied_above);
  EXPECT_GT(boxes.far(cm_50), occupied_above);
}

TEST(LowObstacles, WithoutALeastHeightFifteenCentimetresAndKerbsAreObstacles) {
  Config config{preset("default")};
  config.u_disparity.obstacle_min_height_m = 0;
  const Boxes boxes{config};
  for (const Height high : {cm_15, cm_20, cm_30, cm_50}) {
    EXPECT_GT(boxes.near(high), occupied_above) << high;
    EXPECT_GT(boxes.far(high), occupied_above) << high;
  }
  EXPECT_GT(boxes.kerb(), occupied_above);
}

}  // namespace
}  // namespace stereogrid::test
