// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The scan, on the rules of REP 117: a number for an obstacle, +inf for free, NaN for unknown.
#include <cmath>
#include <limits>
#include <numbers>

#include "stereogrid/messages/sensor_msgs.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using sensor_msgs::LaserScan;

// 20 m × 20 m, all seen free; the rig's beams end at its sides after 14.1 m.
FrameResult all_free() {
  FrameResult result{small_result()};
  result.vehicle.geometry = {0, -10, 0.2, 100, 100};
  result.vehicle.occupancy = result.observed = Image<float>{100, 100, 0.1f};
  return result;
}

LaserScan scan_of(const FrameResult& result, const Rig& rig = small_rig()) {
  return sent_on<LaserScan>("/stereo_grid/scan", result, {}, {}, rig);
}

float range_at(const LaserScan& scan, double bearing_rad) {
  const double beam{(bearing_rad - static_cast<double>(scan.angle_min)) / static_cast<double>(scan.angle_increment)};
  return scan.ranges.at(static_cast<std::size_t>(std::lround(beam)));
}

void set(FrameResult& result, Point2 place, float occupancy) {
  const auto cell{result.vehicle.geometry.cell_at(place).value()};
  result.vehicle.occupancy(cell.ix, cell.iy) = occupancy;
}

TEST(LaserScanMessage, CoversTheFieldOfView) {
  const LaserScan scan{scan_of(all_free())};
  EXPECT_EQ(scan.header.frame_id, "base_link");
  EXPECT_NEAR(scan.angle_min, -std::numbers::pi / 4, 1e-6);
  EXPECT_NEAR(scan.angle_max, std::numbers::pi / 4, 1e-6);
  EXPECT_NEAR(scan.angle_min + static_cast<float>(scan.ranges.size() - 1) * scan.angle_increment, scan.angle_max, 1e-4);
  EXPECT_NEAR(scan.range_max, 10 * std::numbers::sqrt2, 1e-4);
  EXPECT_LE(scan.range_max * scan.angle_increment, 0.2f);
  EXPECT_TRUE(scan.intensities.empty());
}

TEST(LaserScanMessage, IsInfiniteWhereAllIsSeenFree) {
  for (const float range : scan_of(all_free()).ranges) EXPECT_EQ(range, std::numeric_limits<float>::infinity());
}

TEST(LaserScanMessage, IsUnknownWhereNothingWasSeen) {
  FrameResult result{all_free()};
  result.vehicle.occupancy.fill(0.5f);
  for (const float range : scan_of(result).ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(LaserScanMessage, HasTheNearestObstacleOfEachBearing) {
  FrameResult result{all_free()};
  set(result, {8.1, 0.1}, 0.9f);
  set(result, {12.1, 0.1}, 0.9f);
  const LaserScan scan{scan_of(result)};
  EXPECT_NEAR(range_at(scan, 0.1 / 8.1), 8.1, 0.2);
  EXPECT_EQ(range_at(scan, 0.2), std::numeric_limits<float>::infinity());
  EXPECT_EQ(range_at(scan, -0.2), std::numeric_limits<float>::infinity());
}

// So that a costmap marks that cell and no other.
TEST(LaserScanMessage, EndsWithinTheCellThatIsOccupied) {
  FrameResult result{all_free()};
  for (int iy{0}; iy < 100; ++iy) result.vehicle.occupancy(40, iy) = 0.9f;
  const LaserScan scan{scan_of(result)};
  for (std::size_t i{0}; i < scan.ranges.size(); ++i) {
    const double bearing_rad{static_cast<double>(scan.angle_min) +
                             static_cast<double>(i) * static_cast<double>(scan.angle_increment)};
    const double x_m{static_cast<double>(scan.ranges[i]) * std::cos(bearing_rad)};
    EXPECT_GE(x_m, 8.0 - 1e-4);
    EXPECT_LT(x_m, 8.2 + 1e-4);
  }
}

TEST(LaserScanMessage, IsUnknownBehindACellThatWasNotSeen) {
  FrameResult result{all_free()};
  set(result, {9.1, 0.1}, 0.5f);
  const LaserScan scan{scan_of(result)};
  EXPECT_TRUE(std::isnan(range_at(scan, 0.1 / 9.1)));
  EXPECT_EQ(range_at(scan, 0.2), std::numeric_limits<float>::infinity());
}

TEST(LaserScanMessage, HasAnObstacleBehindACellThatWasNotSeen) {
  FrameResult result{all_free()};
  set(result, {4.1, 0.1}, 0.5f);
  for (int iy{45}; iy < 56; ++iy) result.vehicle.occupancy(60, iy) = 0.9f;
  EXPECT_NEAR(range_at(scan_of(result), 0.1 / 4.1), 12.1, 0.15);
}

// 1.5 m above the ground and 26.6° down at the lowest row, the camera sees the ground from 3 m on.
TEST(LaserScanMessage, AsksNothingOfTheGroundBelowTheImage) {
  FrameResult result{all_free()};
  for (int iy{0}; iy < 100; ++iy) {
    for (int ix{0}; ix < 15; ++ix) result.vehicle.occupancy(ix, iy) = 0.5f;
  }
  for (const float range : scan_of(result).ranges) EXPECT_EQ(range, std::numeric_limits<float>::infinity());
  for (int iy{0}; iy < 100; ++iy) result.vehicle.occupancy(16, iy) = 0.5f;
  for (const float range : scan_of(result).ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(LaserScanMessage, IsUnknownWhereTheCameraSeesNoGround) {
  Rig rig{small_rig()};
  rig.camera_pitch_rad = -0.5;
  for (const float range : scan_of(all_free(), rig).ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(LaserScanMessage, IsUnknownOfAGridBesideItsView) {
  FrameResult result{all_free()};
  result.vehicle.geometry.y_min_m = 5;
  for (const float range : scan_of(result).ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(LaserScanMessage, EndsWhereTheFirstBeamLeavesTheGrid) {
  FrameResult result{all_free()};
  set(result, {15.1, 0.1}, 0.9f);  // within the grid, behind the range
  EXPECT_EQ(range_at(scan_of(result), 0), std::numeric_limits<float>::infinity());
  Rig narrow{small_rig()};
  narrow.focal_px = 400;
  narrow.camera_height_m = 1;
  const LaserScan scan{scan_of(result, narrow)};
  EXPECT_NEAR(scan.range_max, 20, 1e-4);
  EXPECT_NEAR(range_at(scan, 0.1 / 15.1), 15.1, 0.15);
}

}  // namespace
}  // namespace stereogrid::messages::test
