// SPDX-License-Identifier: Apache-2.0
//
// Interpretation of the grids by planners with the example parameters of ros2/planners, after
// nav2_costmap_2d/plugins/{static_layer,obstacle_layer}.cpp, Autoware's cost_value.hpp.
#include <yaml-cpp/yaml.h>

#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using nav_msgs::OccupancyGrid;
using sensor_msgs::LaserScan;

constexpr int free_space{0};
constexpr int inscribed{253};
constexpr int lethal{254};
constexpr int no_information{255};

YAML::Node costmap() {
  const YAML::Node file{YAML::LoadFile(STEREOGRID_PLANNERS "/nav2_local_costmap.yaml")};
  return file["local_costmap"]["local_costmap"]["ros__parameters"];
}

// The costmap's parameters that a static layer reads, and what it makes of a cell.
struct StaticLayer {
  explicit StaticLayer(const YAML::Node& node)
      : tracks_unknown{node["track_unknown_space"].as<bool>()},
        is_trinary{node["trinary_costmap"].as<bool>()},
        lethal_threshold{node["lethal_cost_threshold"].as<int>()},
        unknown_value{node["unknown_cost_value"].as<int>()} {}

  [[nodiscard]] int cost(std::int8_t cell) const {
    const int value{static_cast<std::uint8_t>(cell)};
    if (value == unknown_value) return tracks_unknown ? no_information : free_space;
    if (value == inscribed_value) return inscribed;
    if (value >= lethal_threshold) return lethal;
    if (is_trinary) return free_space;
    return static_cast<int>(static_cast<double>(value) / lethal_threshold * lethal);
  }

  static bool accepts(const OccupancyGrid& grid) {
    return grid.info.resolution > 1e-6f && grid.data.size() == std::size_t{grid.info.width} * grid.info.height;
  }

  bool tracks_unknown;
  bool is_trinary;
  int lethal_threshold;
  int unknown_value;
  int inscribed_value{99};  // newer versions
};

// A layer's cell goes into a rolling costmap.
int combined(const YAML::Node& layer, int before, int cost) {
  return layer["use_maximum"].as<bool>() ? std::max(before, cost) : cost;
}

// Range of a valid beam, m.
std::optional<float> end_of(float range, const LaserScan& scan, bool infinite_is_valid) {
  if (infinite_is_valid && !std::isfinite(range) && range > 0) range = scan.range_max - 1e-4f;
  const bool is_within{range >= scan.range_min && range < scan.range_max};
  return is_within ? std::optional{range} : std::nullopt;
}

bool marks(const YAML::Node& source, float range) {
  return source["marking"].as<bool>() && range < source["obstacle_max_range"].as<float>() &&
         range >= source["obstacle_min_range"].as<float>();
}

// Messages of a street with the default preset, scaled for Nav2.
const Recorder& driven_street() {
  static Recorder recorder;
  if (!recorder.sent.empty()) return recorder;
  const scenes::Scene scene{scenes::parse_scene("street?width=320&height=160&frames=12"), 2};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2, .horizons_s = {0.5, 1}}};
  FrameMessages messages{recorder, pipeline.rig(), {.scale = OccupancyScale::nav2}};
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const StereoFrame frame{scene.load(i)};
    messages.send(pipeline.process(frame), {.stamp_ns = frame.stamp_ns});
  }
  return recorder;
}

bool is_latched(const std::string& topic) {
  return std::ranges::any_of(driven_street().channels,
                             [&](const auto& one) { return one.topic == topic && one.latched; });
}

TEST(Nav2Example, AsksForTopicsThatAreThere) {
  const YAML::Node node{costmap()};
  int static_layers{0};
  for (const YAML::Node& name : node["plugins"]) {
    const YAML::Node layer{node[name.as<std::string>()]};
    ASSERT_TRUE(layer) << name;
    if (layer["plugin"].as<std::string>() != "nav2_costmap_2d::StaticLayer") continue;
    const auto topic{layer["map_topic"].as<std::string>()};
    EXPECT_EQ(driven_street().type_of(topic), OccupancyGrid::type_name);
    EXPECT_EQ(layer["map_subscribe_transient_local"].as<bool>(), is_latched(topic)) << topic;
    const auto grid{driven_street().last<OccupancyGrid>(topic)};
    EXPECT_EQ(grid.header.frame_id, node["global_frame"].as<std::string>()) << topic;
    EXPECT_LE(node["resolution"].as<float>(), grid.info.resolution) << "cells of the costmap would step over some";
    ++static_layers;
  }
  EXPECT_EQ(static_layers, 3);
  const auto source{node["obstacles"]["observation_sources"].as<std::string>()};
  const YAML::Node scan{node["obstacles"][source]};
  EXPECT_EQ(driven_street().type_of(scan["topic"].as<std::string>()), LaserScan::type_name);
}

TEST(Nav2Example, GivesEachProbabilityItsCost) {
  const StaticLayer layer{costmap()};
  const auto cost = [&](float p) { return layer.cost(occupancy_value(p, OccupancyScale::nav2)); };
  EXPECT_EQ(cost(0.5f), free_space);  // unknown
  int before{0};
  for (int percent{0}; percent <= 100; ++percent) {
    const float p{static_cast<float>(percent) / 100};
    if (!is_known(p)) continue;
    EXPECT_GE(cost(p), before) << p;
    EXPECT_NE(cost(p), inscribed) << p << ": the robot's own radius is inflated by another layer";
    EXPECT_EQ(cost(p) == lethal, p >= 0.65f) << p;
    EXPECT_EQ(cost(p) == free_space, p <= 0.35f) << p;
    before = cost(p);
  }
  EXPECT_EQ(layer.cost(occupancy_value(0.99f, OccupancyScale::percent)), inscribed) << "why it is not this scale";
}

// The file's comment on track_unknown_space.
TEST(Nav2Example, DoesNotLoseObstaclesUnderUnknownPredictions) {
  const YAML::Node node{costmap()};
  StaticLayer layer{node};
  const auto of_all = [&](float now, float soon, float later) {
    int cost{no_information};
    const std::vector<std::pair<std::string, float>> cells{{"stereo_grid", now}, {"soon", soon}, {"later", later}};
    for (const auto& [name, p] : cells) {
      cost = combined(node[name], cost, layer.cost(occupancy_value(p, OccupancyScale::nav2)));
    }
    return cost;
  };
  EXPECT_EQ(of_all(0.9f, 0.5f, 0.1f), lethal);
  EXPECT_EQ(of_all(0.1f, 0.9f, 0.5f), lethal);
  EXPECT_EQ(of_all(0.1f, 0.1f, 0.1f), free_space);
  layer.tracks_unknown = true;
  EXPECT_EQ(of_all(0.9f, 0.5f, 0.1f), no_information) << "no longer needed where Nav2 does otherwise";
}

TEST(Nav2Example, AcceptsTheWindowAsItMoves) {
  std::set<double> corners;
  for (const Recorder::Sent& one : driven_street().sent) {
    if (one.topic != "/stereo_grid/occupancy_grid") continue;
    OccupancyGrid grid;
    decode(one.cdr, grid);
    EXPECT_TRUE(StaticLayer::accepts(grid));
    EXPECT_EQ(grid.info.origin.orientation.w, 1) << "a turn is ignored";
    const double resolution_m{static_cast<double>(grid.info.resolution)};
    for (const double corner_m : {grid.info.origin.position.x, grid.info.origin.position.y}) {
      EXPECT_NEAR(std::remainder(corner_m, resolution_m), 0, 1e-9);
    }
    corners.insert(grid.info.origin.position.x);
  }
  EXPECT_GT(corners.size(), 1u) << "it did not move";
}

TEST(Nav2Example, MarksObstaclesOfTheScanAndNothingElse) {
  const YAML::Node source{costmap()["obstacles"]["scan"]};
  const bool infinite_is_valid{source["inf_is_valid"].as<bool>()};
  const auto scan{driven_street().last<LaserScan>("/stereo_grid/scan")};
  EXPECT_LT(source["obstacle_max_range"].as<float>(), scan.range_max);
  int marked{0};
  int cleared{0};
  for (const float range : scan.ranges) {
    const auto end{end_of(range, scan, infinite_is_valid)};
    EXPECT_EQ(end.has_value(), !std::isnan(range)) << range;
    if (!end) continue;
    cleared += source["clearing"].as<bool>() ? 1 : 0;
    if (!marks(source, *end)) continue;
    EXPECT_TRUE(std::isfinite(range)) << "an obstacle where all is free";
    ++marked;
  }
  EXPECT_GT(marked, 0);
  EXPECT_GT(cleared, marked);
}

TEST(Nav2Example, KeepsAScanThatLiesOnTheGround) {
  const YAML::Node layer{costmap()["obstacles"]};
  for (const YAML::Node& node : {layer, layer["scan"]}) {
    EXPECT_LT(node["min_obstacle_height"].as<double>(), 0);
    EXPECT_GT(node["max_obstacle_height"].as<double>(), 0);
  }
}

// Displays of RViz: each topic is one of ours, with its type and a compatible QoS.
TEST(RvizConfiguration, ShowsTopicsThatArePublished) {
  const std::map<std::string, std::string> types{{"Map", "nav_msgs/msg/OccupancyGrid"},
                                                 {"MarkerArray", "visualization_msgs/msg/MarkerArray"},
                                                 {"PointCloud2", "sensor_msgs/msg/PointCloud2"},
                                                 {"LaserScan", "sensor_msgs/msg/LaserScan"}};
  const YAML::Node file{YAML::LoadFile(STEREOGRID_PLANNERS "/../stereogrid_ros/config/stereo_grid.rviz")};
  const YAML::Node manager{file["Visualization Manager"]};
  EXPECT_EQ(manager["Global Options"]["Fixed Frame"].as<std::string>(), "odom");
  int displays{0};
  for (const YAML::Node& display : manager["Displays"]) {
    const YAML::Node topic{display["Topic"]};
    if (!topic) continue;
    ++displays;
    const std::string name{topic["Value"].as<std::string>()};
    const std::string kind{display["Class"].as<std::string>().substr(std::string{"rviz_default_plugins/"}.size())};
    const auto channel{std::ranges::find(driven_street().channels, name, &Channel::topic)};
    ASSERT_NE(channel, driven_street().channels.end()) << name;
    EXPECT_EQ(channel->type, types.at(kind)) << name;
    EXPECT_EQ(topic["Durability Policy"].as<std::string>() == "Transient Local", channel->latched) << name;
  }
  EXPECT_EQ(displays, 6);
}

TEST(AutowareExample, ReadsFreeUnknownAndOccupied) {
  const YAML::Node file{YAML::LoadFile(STEREOGRID_PLANNERS "/autoware.param.yaml")};
  const YAML::Node node{file["/**"]["ros__parameters"]};
  const int free_max{node["grid"]["free_space_max"].as<int>()};
  const int occupied_min{node["grid"]["occupied_min"].as<int>()};
  const auto value = [](float p) { return int{occupancy_value(p, OccupancyScale::autoware)}; };
  EXPECT_EQ(value(0.5f), 128 * 100 / 255);  // its "no information"
  for (int percent{0}; percent <= 100; ++percent) {
    const float p{static_cast<float>(percent) / 100};
    EXPECT_EQ(value(p), std::clamp(is_known(p) ? percent : 50, 1, 99));
    if (is_known(p)) continue;
    EXPECT_GT(value(p), free_max) << p;
    EXPECT_LT(value(p), occupied_min) << p;
  }
  EXPECT_LE(value(0.35f), free_max);
  EXPECT_GE(value(0.65f), occupied_min);
  const auto grid{sent_on<OccupancyGrid>("/stereo_grid/occupancy_grid", small_result())};
  EXPECT_EQ(node["map_frame"].as<std::string>(), grid.header.frame_id);
}

}  // namespace
}  // namespace stereogrid::messages::test
