// SPDX-License-Identifier: Apache-2.0
//
// Obstacles and their markers, in the world's frame while results are in the vehicle's.
#include "stereogrid/messages/definition.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/vision_msgs.hpp"
#include "stereogrid/messages/visualization_msgs.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using nav2_dynamic_msgs::ObstacleArray;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

Obstacle car() {
  Obstacle obstacle;
  obstacle.id = 258;
  obstacle.x_m = 4;
  obstacle.y_m = 1;
  obstacle.vx_mps = 3;
  obstacle.vy_mps = -4;
  obstacle.length_m = 4;
  obstacle.width_m = 2;
  obstacle.height_m = 1.5;
  obstacle.occupancy = 0.875;
  obstacle.confirmed = true;
  obstacle.moving = true;
  obstacle.outline = {{2, 0}, {6, 0}, {6, 2}};
  return obstacle;
}

Obstacle wall() {
  Obstacle obstacle;
  obstacle.id = 7;
  obstacle.confirmed = true;
  obstacle.kind = ObstacleKind::boundary;
  obstacle.outline = {{2, 3}, {6, 3}};
  return obstacle;
}

// The vehicle is at (10, 20), heading along y.
FrameResult with(std::vector<Obstacle> obstacles) {
  FrameResult result{small_result()};
  result.world_from_vehicle = {10, 20, std::numbers::pi / 2};
  result.obstacles = std::move(obstacles);
  return result;
}

ObstacleArray obstacles_of(const FrameResult& result, const std::string& node = "stereo_grid") {
  return sent_on<ObstacleArray>("/" + node + "/obstacles", result, {}, {.node = node});
}

MarkerArray markers_of(const FrameResult& result) {
  return sent_on<MarkerArray>("/stereo_grid/obstacle_markers", result);
}

std::vector<Marker> of_namespace(const MarkerArray& array, const std::string& name) {
  std::vector<Marker> found;
  std::ranges::copy_if(array.markers, std::back_inserter(found), [&](const Marker& one) { return one.ns == name; });
  return found;
}

TEST(DetectionMessage, HasEachFieldOfAnObstacle) {
  Obstacle turned{car()};
  turned.yaw_rad = std::numbers::pi / 2;  // π in the world
  turned.position_covariance = {.xx = 0.25, .xy = 0.1, .yy = 0.0625};
  turned.yaw_sigma_rad = 0.5;
  Obstacle unconfirmed{car()};
  unconfirmed.confirmed = false;
  const auto array{sent_on<vision_msgs::Detection3DArray>(
      "/stereo_grid/detections", with({turned, unconfirmed, wall()}), {.stamp_ns = 1'000'000'002})};
  EXPECT_EQ(array.header.frame_id, "odom");
  ASSERT_EQ(array.detections.size(), 2u);
  const vision_msgs::Detection3D& one{array.detections[0]};
  EXPECT_EQ(one.header.frame_id, "odom");
  EXPECT_EQ(one.header.stamp.sec, 1);
  EXPECT_EQ(one.header.stamp.nanosec, 2u);
  EXPECT_EQ(one.id, "258");
  EXPECT_NEAR(one.bbox.center.position.x, 9, 1e-9);
  EXPECT_NEAR(one.bbox.center.position.y, 24, 1e-9);
  EXPECT_NEAR(one.bbox.center.position.z, 0.75, 1e-9);
  EXPECT_NEAR(std::abs(one.bbox.center.orientation.z), 1, 1e-9);
  EXPECT_NEAR(one.bbox.center.orientation.w, 0, 1e-9);
  EXPECT_EQ(one.bbox.size.x, 4);
  EXPECT_EQ(one.bbox.size.y, 2);
  EXPECT_EQ(one.bbox.size.z, 1.5);
  ASSERT_EQ(one.results.size(), 1u);
  EXPECT_EQ(one.results[0].hypothesis.class_id, "object");
  EXPECT_EQ(one.results[0].hypothesis.score, 0.875);
  EXPECT_EQ(one.results[0].pose.pose.position.x, one.bbox.center.position.x);
  std::array<double, 36> covariance{};
  covariance[0] = 0.0625;
  covariance[1] = covariance[6] = -0.1;
  covariance[7] = covariance[35] = 0.25;
  for (std::size_t i{0}; i < 36; ++i) EXPECT_NEAR(one.results[0].pose.covariance.at(i), covariance.at(i), 1e-12) << i;
  EXPECT_EQ(array.detections[1].results.at(0).hypothesis.class_id, "boundary");
  EXPECT_EQ(array.detections[1].results[0].pose.covariance[35], 0);  // unknown
}

TEST(ObstacleMessage, IsInTheWorldsFrame) {
  const ObstacleArray array{obstacles_of(with({car()}))};
  EXPECT_EQ(array.header.frame_id, "odom");
  ASSERT_EQ(array.obstacles.size(), 1u);
  const nav2_dynamic_msgs::Obstacle& one{array.obstacles[0]};
  EXPECT_FLOAT_EQ(one.score, 0.875f);
  EXPECT_NEAR(one.position.x, 9, 1e-9);
  EXPECT_NEAR(one.position.y, 24, 1e-9);
  EXPECT_NEAR(one.position.z, 0.75, 1e-9);
  EXPECT_NEAR(one.velocity.x, 4, 1e-9);
  EXPECT_NEAR(one.velocity.y, 3, 1e-9);
}

// The type has no orientation: its box is along the axes, around the rotated one.
TEST(ObstacleMessage, HasABoxAlongTheAxes) {
  const nav2_dynamic_msgs::Obstacle along{obstacles_of(with({car()})).obstacles.at(0)};
  EXPECT_NEAR(along.size.x, 2, 1e-9);
  EXPECT_NEAR(along.size.y, 4, 1e-9);
  EXPECT_NEAR(along.size.z, 1.5, 1e-9);
  Obstacle turned{car()};
  turned.yaw_rad = std::numbers::pi / 4;
  const nav2_dynamic_msgs::Obstacle across{obstacles_of(with({turned})).obstacles.at(0)};
  EXPECT_NEAR(across.size.x, 6 / std::numbers::sqrt2, 1e-9);
  EXPECT_NEAR(across.size.y, 6 / std::numbers::sqrt2, 1e-9);
}

// The heading of small_result() is y: its x is the world's y, its y is −x.
TEST(ObstacleMessage, HasCovariancesInTheAxesOfTheWorld) {
  Obstacle seen{car()};
  seen.position_covariance = {.xx = 0.25, .xy = 0.1, .yy = 0.0625};
  seen.velocity_covariance = {.xx = 4, .xy = -0.5, .yy = 1};
  const nav2_dynamic_msgs::Obstacle one{obstacles_of(with({seen})).obstacles.at(0)};
  const std::array<double, 9> position{0.0625, -0.1, 0, -0.1, 0.25, 0, 0, 0, 0};
  const std::array<double, 9> velocity{1, 0.5, 0, 0.5, 4, 0, 0, 0, 0};
  for (std::size_t i{0}; i < 9; ++i) {
    EXPECT_NEAR(one.position_covariance.at(i), position.at(i), 1e-12) << i;
    EXPECT_NEAR(one.velocity_covariance.at(i), velocity.at(i), 1e-12) << i;
  }
  EXPECT_TRUE(definition_of<nav2_dynamic_msgs::Obstacle>().starts_with(
      "unique_identifier_msgs/UUID uuid\nfloat32 score\ngeometry_msgs/Point position\n"
      "geometry_msgs/Vector3 velocity\ngeometry_msgs/Vector3 size\nfloat64[9] position_covariance\n"
      "float64[9] velocity_covariance\n"));
}

TEST(ObstacleMessage, HasAnIdThatStaysAndIsItsOwn) {
  const auto id_of = [](const std::string& node, std::int64_t id) {
    Obstacle obstacle{car()};
    obstacle.id = id;
    return obstacles_of(with({obstacle}), node).obstacles.at(0).uuid.uuid;
  };
  EXPECT_EQ(id_of("front", 258), id_of("front", 258));
  EXPECT_EQ(id_of("front", 258)[14], 1);
  EXPECT_EQ(id_of("front", 258)[15], 2);
  EXPECT_NE(id_of("front", 258), id_of("front", 259));
  EXPECT_NE(id_of("front", 258), id_of("rear", 258));
}

TEST(ObstacleMessage, LeavesOutWhatIsNotConfirmed) {
  Obstacle unconfirmed{car()};
  unconfirmed.confirmed = false;
  EXPECT_EQ(obstacles_of(with({unconfirmed, wall()})).obstacles.size(), 1u);
  EXPECT_TRUE(of_namespace(markers_of(with({unconfirmed})), "outlines").empty());
}

TEST(ObstacleMarkers, BeginWithTheEndOfThoseBefore) {
  for (const FrameResult& result : {with({}), with({car()})}) {
    const MarkerArray array{markers_of(result)};
    ASSERT_FALSE(array.markers.empty());
    EXPECT_EQ(array.markers[0].action, 3);
    for (std::size_t i{1}; i < array.markers.size(); ++i) {
      EXPECT_EQ(array.markers[i].action, 0);
      EXPECT_EQ(array.markers[i].lifetime.sec, 1);
      EXPECT_EQ(array.markers[i].header.frame_id, "odom");
    }
  }
}

TEST(ObstacleMarkers, AreOutlineBoxAndSpeedOfWhatMoves) {
  const MarkerArray array{markers_of(with({car()}))};
  const auto outlines{of_namespace(array, "outlines")};
  ASSERT_EQ(outlines.size(), 1u);
  EXPECT_EQ(outlines[0].type, 4);
  EXPECT_EQ(outlines[0].id, 258);
  ASSERT_EQ(outlines[0].points.size(), 4u) << "closed";
  EXPECT_NEAR(outlines[0].points[1].x, 10, 1e-9);
  EXPECT_NEAR(outlines[0].points[1].y, 26, 1e-9);
  EXPECT_EQ(outlines[0].points[3].y, outlines[0].points[0].y);
  EXPECT_GT(outlines[0].color.a, 0);
  const auto boxes{of_namespace(array, "boxes")};
  ASSERT_EQ(boxes.size(), 1u);
  EXPECT_EQ(boxes[0].type, 1);
  EXPECT_NEAR(boxes[0].pose.orientation.z, std::sin(std::numbers::pi / 4), 1e-9);
  EXPECT_NEAR(boxes[0].scale.x, 4, 1e-9);
  const auto speeds{of_namespace(array, "speeds")};
  ASSERT_EQ(speeds.size(), 1u);
  EXPECT_EQ(speeds[0].type, 9);
  EXPECT_EQ(speeds[0].text, "5.0 m/s");
}

TEST(ObstacleMarkers, OfABoundaryAreAnOpenLineOnly) {
  const MarkerArray array{markers_of(with({wall()}))};
  EXPECT_EQ(array.markers.size(), 2u);
  EXPECT_EQ(of_namespace(array, "outlines").at(0).points.size(), 2u);
}

// Memory is used again, and must not show.
TEST(ObstacleMarkers, HaveNothingOfTheFrameBefore) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  messages.send(with({car(), car(), wall()}), {});
  messages.send(with({wall()}), {});
  const std::string topic{"/stereo_grid/obstacle_markers"};
  CdrWriter again;
  CdrWriter alone;
  EXPECT_TRUE(
      std::ranges::equal(again.encode(recorder.last<MarkerArray>(topic)), alone.encode(markers_of(with({wall()})))));
}

}  // namespace
}  // namespace stereogrid::messages::test
