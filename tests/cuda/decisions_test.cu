// SPDX-License-Identifier: Apache-2.0
//
// Decisions of FramePipeline (ground plane, vertical misalignment, rejection) are the same on the GPU as on the
// reference back end.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "side_by_side.hpp"

namespace stereogrid::test {
namespace {

TEST(a_jolt_is_followed) {
  const Street level{small_rig()};
  const Street pitched{small_rig(), 0.03};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 5; ++index) pair.run((index < 2 ? level : pitched).frame(index));
  CHECK(pair.law.result.ground.estimated);
  CHECK_NEAR(pair.law.result.ground.pitch_rad, 0.03, 0.01);
}

TEST(a_mounting_is_found) {
  Config config{small_config()};
  config.matching.disparities = 32;
  Rig assumed{small_rig()};
  assumed.camera_height_m = 2.2;
  Pair pair{config, assumed, {}, GroundMode::assumed};
  pair.run(Street{small_rig(), 0.05}.frame(0));
  CHECK(pair.law.found && pair.gpu.found);
  if (!pair.law.found || !pair.gpu.found) return;
  compare(*pair.gpu.found, *pair.law.found);
  CHECK_NEAR(pair.law.found->height_m, small_rig().camera_height_m, 0.1);
  CHECK_NEAR(pair.law.found->pitch_rad, 0.05, 0.02);
}

TEST(rows_that_are_off_are_put_right) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) {
    StereoFrame frame{street.frame(index)};
    for (int v{height - 1}; v > 0; --v) std::copy_n(frame.right.row(v - 1), width, frame.right.row(v));
    pair.run(frame);
  }
  CHECK(pair.law.result.obstacle_density > 0.1);
}

TEST(after_a_reset_the_next_frame_is_a_first_one) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) pair.run(street.frame(index));
  pair.gpu.frames.reset();
  pair.law.frames.reset();
  Runner fresh{law_stages(small_config(), small_rig()), small_config(), small_rig()};
  for (int index{0}; index < 2; ++index) {
    StereoFrame frame{street.frame(index + 3)};
    frame.index = index;
    pair.run(frame);
    fresh.run(frame, index == 0 ? 0 : 0.1);
    CHECK_EQUAL(differences(pair.gpu.result.world.occupancy, fresh.result.world.occupancy), 0);
    CHECK_EQUAL(differences(pair.gpu.result.world.age_s, fresh.result.world.age_s), 0);
    CHECK_EQUAL(differences(pair.gpu.result.world.velocity_x, fresh.result.world.velocity_x), 0);
    compare(pair.gpu.result.ground, fresh.result.ground);
    CHECK_EQUAL(pair.gpu.result.obstacles.size(), fresh.result.obstacles.size());
  }
}

TEST(what_cannot_be_relied_on_is_unknown) {
  const Street street{small_rig()};
  Random random{7};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 5; ++index) {
    StereoFrame frame{street.frame(index)};
    if (index == 1) frame.right = frame.left;
    if (index == 2) frame.right.fill(9);
    if (index == 2) frame.other_grids.push_back({{0, -4, 0.8, 12, 10}, random.image(12, 10, 0, 1), {}});
    pair.run(frame);
    const FrameResult& result{pair.law.result};
    const bool is_known{index != 1 && index != 2};
    CHECK_EQUAL(result.status.size(), is_known ? 0U : 1U);
    if (!is_known && !result.status.empty()) {
      CHECK(result.status.front() == FrameStatus::few_matches);
    }
    if (index == 1) CHECK(result.observed == Image<float>(20, 16, 0.5f));
    if (index == 2) CHECK(!(result.observed == Image<float>(20, 16, 0.5f)));
  }
}

// The frame is matched again on the slope: the host must not continue with the matches of the plane.
TEST(a_slope_that_fills_the_view) {
  const Street level{small_rig()};
  Rig over_slope{small_rig()};
  over_slope.camera_height_m += 0.2;  // it begins 1.6 m ahead
  const Street slope{over_slope, 0.12};
  Config config{small_config()};
  config.matching.disparities = 32;
  Pair pair{config, small_rig()};
  int index{0};
  for (; index < 3; ++index) pair.run(level.frame(index));
  const double road_density{pair.law.result.road_density};
  for (; index < 6; ++index) {
    pair.run(slope.frame(index));
    CHECK(pair.law.result.status.empty());
    CHECK(pair.law.result.road_density > 0.7 * road_density);
    CHECK_NEAR(pair.law.result.ground.pitch_rad, 0.12, 0.02);
    CHECK(!pair.law.result.ground.estimated);
  }
  const Image<float>& elevation_m{pair.law.result.elevation_m};
  CHECK(std::ranges::any_of(elevation_m, [](float z) { return z > 0.3f; }));
}

/// External disparities of an edge 5 m ahead with a floor 1 m lower.
StereoFrame edge(int index) {
  StereoFrame frame{Street{small_rig()}.frame(index)};
  frame.right = {};
  frame.disparity = Image<float>{width, height};
  const Rig rig{small_rig()};
  const RoadPlane floor{road_plane(rig, {rig.camera_height_m})};
  const double edge_px{rig.focal_px * rig.baseline_m / 5};
  for (int v{0}; v < height; ++v) {
    for (int u{0}; u < width; ++u) {
      const double near_px{std::max(floor.disparity(u, v), 0.0)};
      const double lower{rig.camera_height_m / (rig.camera_height_m + 1)};
      frame.disparity(u, v) = static_cast<float>(near_px > edge_px ? near_px : lower * near_px);
    }
  }
  return frame;
}

TEST(an_edge_in_external_disparities) {
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 4; ++index) pair.run(edge(index));
  const FrameResult& result{pair.law.result};
  const RoadPlane floor{road_plane(small_rig(), {small_rig().camera_height_m})};
  const int beyond_v{static_cast<int>(small_rig().cy_px) + 16};  // 8 m ahead on the plane
  const float beyond_px{result.stages.obstacle_disparity(width / 2, beyond_v) +
                        result.stages.road_disparity(width / 2, beyond_v)};
  CHECK(beyond_px > 0);
  CHECK(beyond_px < floor.disparity(width / 2, beyond_v) - 1);
  int free{0};
  for (int iy{0}; iy < result.vehicle.geometry.ny; ++iy) {
    for (int ix{11}; ix < 16; ++ix) free += result.observed(ix, iy) < 0.45f ? 1 : 0;
  }
  CHECK_EQUAL(free, 0);
}

TEST(a_drive_that_begins_with_nothing) {
  const Street street{small_rig()};
  Pair pair{small_config(), small_rig()};
  for (int index{0}; index < 3; ++index) {
    StereoFrame frame{street.frame(index)};
    if (index == 0) frame.right = frame.left;
    pair.run(frame);
    CHECK_EQUAL(pair.law.result.status.size(), index == 0 ? 1U : 0U);
  }
}

/// A wall that fills the view, at a whole disparity; 0: the images have nothing in common.
StereoFrame wall(int index, int disparity, double driven_m) {
  Random random{static_cast<unsigned>(index)};
  StereoFrame frame;
  frame.index = index;
  frame.stamp_ns = index * 100'000'000LL;
  frame.world_from_vehicle = Pose2{driven_m, 0, 0};
  frame.left = frame.right = Image<std::uint8_t>{width, height};
  for (int v{0}; v < height; ++v) {
    std::vector<std::uint8_t> greys(2 * width);
    for (std::uint8_t& grey : greys) grey = static_cast<std::uint8_t>(random.whole(40, 220));
    std::copy_n(greys.data(), width, frame.left.row(v));
    std::copy_n(greys.data() + (disparity > 0 ? disparity : width), width, frame.right.row(v));
  }
  return frame;
}

TEST(what_is_too_close_is_held) {
  Pair pair{small_config(), small_rig()};
  const double focal_baseline_pxm{small_rig().focal_px * small_rig().baseline_m};
  int index{0};
  for (const int disparity : {9, 10, 11, 12, 13, 0, 0, 0}) {
    const double ahead_m{focal_baseline_pxm / (disparity > 0 ? disparity : 17)};
    pair.run(wall(index++, disparity, 10 - ahead_m));
    const std::vector<FrameStatus>& status{pair.law.result.status};
    CHECK_EQUAL(std::count(status.begin(), status.end(), FrameStatus::too_close), disparity == 0 ? 1 : 0);
  }
  const GridLayers& world{pair.law.result.world};
  const auto cell = world.geometry.cell_at({10.1, 0.1});
  CHECK(cell.has_value() && world.occupancy(cell->ix, cell->iy) > 0.55f);
}

}  // namespace
}  // namespace stereogrid::test
