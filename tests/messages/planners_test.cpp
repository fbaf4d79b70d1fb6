// SPDX-License-Identifier: Apache-2.0
//
// Parameters of planners, and the grids as Nav2 (nav2_costmap.hpp) and Autoware (cost_value.hpp) read them with these.
#include <yaml-cpp/yaml.h>

#include "nav2_costmap.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav2_parameters.hpp"
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

constexpr double robot_radius_m{0.3};

// A scene through a pipeline, with the messages of each frame.
class Drive {
 public:
  Drive(const std::string& scene, const std::string& preset_name)
      : scene_{scenes::parse_scene(scene), 2},
        pipeline_{preset(preset_name), scene_.rig(), {.threads = 2, .horizons_s = {0.5, 1}}},
        messages_{recorder_, pipeline_.rig(), {.scale = OccupancyScale::nav2}} {}

  [[nodiscard]] std::size_t size() const { return scene_.size(); }
  [[nodiscard]] const Recorder& recorder() const { return recorder_; }
  [[nodiscard]] YAML::Node costmap(Nav2Source source) const {
    const Nav2Options options{.source = source, .has_predictions = true};
    const YAML::Node file{YAML::Load(nav2_local_costmap(pipeline_.rig(), pipeline_.vehicle_grid(), options))};
    return file["local_costmap"]["local_costmap"]["ros__parameters"];
  }

  // Pose of the vehicle.
  Pose2 next() {
    const StereoFrame frame{scene_.load(i_++)};
    const FrameResult& result{pipeline_.process(frame)};
    messages_.send(result, {.stamp_ns = frame.stamp_ns});
    return result.world_from_vehicle;
  }
  Pose2 last() {
    while (i_ + 1 < size()) static_cast<void>(next());
    return next();
  }

 private:
  scenes::Scene scene_;
  Pipeline pipeline_;
  Recorder recorder_;
  FrameMessages messages_;
  std::size_t i_{0};
};

Drive& driven_street() {
  static Drive drive{"street?width=320&height=160&frames=12", "default"};
  if (drive.recorder().sent.empty()) static_cast<void>(drive.last());
  return drive;
}

// A topic of the street with its type and durability.
void expect_topic(const std::string& topic, std::string_view type, bool is_latched) {
  const std::vector<Channel>& channels{driven_street().recorder().channels};
  const auto channel{std::ranges::find(channels, topic, &Channel::topic)};
  ASSERT_NE(channel, channels.end()) << topic;
  EXPECT_EQ(channel->type, type);
  EXPECT_EQ(channel->latched, is_latched) << topic;
}

TEST(Nav2Parameters, AskForTopicsThatAreThere) {
  const YAML::Node grid{driven_street().costmap(Nav2Source::grid)};
  const auto topic{grid["stereo_grid"]["map_topic"].as<std::string>()};
  expect_topic(topic, OccupancyGrid::type_name, grid["stereo_grid"]["map_subscribe_transient_local"].as<bool>());
  const auto message{driven_street().recorder().last<OccupancyGrid>(topic)};
  EXPECT_EQ(message.header.frame_id, grid["global_frame"].as<std::string>());
  EXPECT_EQ(grid["resolution"].as<float>(), message.info.resolution);
  const YAML::Node layer{driven_street().costmap(Nav2Source::layer)["stereo_grid"]};
  for (const char* name : {"topic", "prediction_topic"}) {
    expect_topic(layer[name].as<std::string>(), OccupancyGrid::type_name, true);
  }
  const YAML::Node scan{driven_street().costmap(Nav2Source::scan)["stereo_grid"]["scan"]};
  expect_topic(scan["topic"].as<std::string>(), LaserScan::type_name, false);
  const YAML::Node voxels{driven_street().costmap(Nav2Source::points)["stereo_grid"]};
  const auto tf{driven_street().recorder().last<tf2_msgs::TFMessage>("/tf_static")};
  for (const char* source : {"mark", "clear"}) {
    expect_topic(voxels[source]["topic"].as<std::string>(), sensor_msgs::PointCloud2::type_name, false);
    EXPECT_EQ(voxels[source]["sensor_frame"].as<std::string>(), tf.transforms.front().child_frame_id);
  }
  for (const YAML::Node& one : {grid, scan, voxels}) {
    EXPECT_FALSE(one["use_maximum"]) << "no layer of Nav2 reads it";
  }
}

// Names that onInitialize() of SpatioTemporalVoxelLayer declares (2025), with that of the plugin.
TEST(Nav2Parameters, OfVoxelsAreDeclaredByTheirLayer) {
  const std::set<std::string> of_layer{
      "plugin",         "enabled",      "voxel_size",          "combination_method",
      "mark_threshold", "decay_model",  "track_unknown_space", "update_footprint_enabled",
      "voxel_decay",    "mapping_mode", "publish_voxel_map",   "observation_sources",
      "mark",           "clear"};
  const std::set<std::string> of_source{"topic",
                                        "sensor_frame",
                                        "data_type",
                                        "min_obstacle_height",
                                        "max_obstacle_height",
                                        "marking",
                                        "clearing",
                                        "obstacle_range",
                                        "min_z",
                                        "max_z",
                                        "vertical_fov_angle",
                                        "horizontal_fov_angle",
                                        "decay_acceleration",
                                        "clear_after_reading",
                                        "model_type"};
  const YAML::Node layer{driven_street().costmap(Nav2Source::points)["stereo_grid"]};
  for (const auto& one : layer) EXPECT_TRUE(of_layer.contains(one.first.as<std::string>())) << one.first;
  for (const char* source : {"mark", "clear"}) {
    for (const auto& one : layer[source]) EXPECT_TRUE(of_source.contains(one.first.as<std::string>())) << one.first;
  }
}

TEST(Nav2Parameters, OfVoxelsClearNothingOutsideOfTheImage) {
  const auto angle = [](const Rig& rig, const char* name) {
    const YAML::Node file{YAML::Load(nav2_local_costmap(rig, {0, -3, 0.05, 120, 120}, {.source = Nav2Source::points}))};
    return file["local_costmap"]["local_costmap"]["ros__parameters"]["stereo_grid"]["clear"][name].as<double>();
  };
  Rig rig{small_rig()};
  rig.cx_px = (rig.width_px - 1) / 2.0;
  rig.cy_px = (rig.height_px - 1) / 2.0;
  EXPECT_NEAR(angle(rig, "horizontal_fov_angle"), 2 * std::atan(rig.width_px / (2 * rig.focal_px)), 1e-4);
  EXPECT_NEAR(angle(rig, "vertical_fov_angle"), 2 * std::atan(rig.height_px / (2 * rig.focal_px)), 1e-4);
  rig.cx_px = 20;
  rig.cy_px = rig.height_px - 11;
  EXPECT_NEAR(angle(rig, "horizontal_fov_angle"), 2 * std::atan(20.5 / rig.focal_px), 1e-4);
  EXPECT_NEAR(angle(rig, "vertical_fov_angle"), 2 * std::atan(10.5 / rig.focal_px), 1e-4);
}

TEST(Nav2Parameters, AreThoseOfTheOptions) {
  const GridGeometry geometry{0, -3, 0.05, 120, 120};
  const Nav2Options options{.node = "robot1/grid", .world_frame = "robot1/odom", .robot_frame = "robot1/base"};
  const YAML::Node file{YAML::Load(nav2_local_costmap(small_rig(), geometry, options))};
  const YAML::Node node{file["local_costmap"]["local_costmap"]["ros__parameters"]};
  EXPECT_EQ(node["stereo_grid"]["map_topic"].as<std::string>(), "/robot1/grid/occupancy_grid");
  EXPECT_EQ(node["global_frame"].as<std::string>(), "robot1/odom");
  EXPECT_EQ(node["robot_base_frame"].as<std::string>(), "robot1/base");
  EXPECT_EQ(node["width"].as<int>(), 14) << "6 m ahead and 3 m aside are 6.7 m away";
  EXPECT_EQ(node["resolution"].as<std::string>(), "0.05");
  const YAML::Node fine{YAML::Load(nav2_local_costmap(small_rig(), {0, -3, 0.0625, 96, 96}, options))};
  EXPECT_EQ(fine["local_costmap"]["local_costmap"]["ros__parameters"]["resolution"].as<double>(), 0.0625);
  EXPECT_EQ(node["update_frequency"].as<std::string>(), "10.0") << "Nav2 rejects an integer";
}

TEST(Nav2Parameters, GiveEachProbabilityItsCost) {
  const Nav2Costmap costmap{driven_street().costmap(Nav2Source::grid), robot_radius_m};
  const auto cost_of = [&](float p) { return costmap.interpreted(occupancy_value(p, OccupancyScale::nav2)); };
  EXPECT_EQ(cost_of(0.5f), cost::no_information);
  int before{0};
  for (int percent{0}; percent <= 100; ++percent) {
    const float p{static_cast<float>(percent) / 100};
    if (!is_known(p)) continue;
    EXPECT_GE(cost_of(p), before) << p;
    EXPECT_NE(cost_of(p), cost::inscribed) << p << ": the robot's own radius is inflated by another layer";
    EXPECT_EQ(cost_of(p) == cost::lethal, p >= 0.65f) << p;
    EXPECT_EQ(cost_of(p) == cost::free_space, p <= 0.35f) << p;
    before = cost_of(p);
  }
  EXPECT_EQ(costmap.interpreted(occupancy_value(0.99f, OccupancyScale::percent)), cost::inscribed)
      << "why it is not this scale";
}

struct Compared {
  int lethal{0};    // cells of the message
  int lost{0};      // lethal in the message, less in the costmap
  int invented{0};  // the other way round
  int hidden{0};    // unknown in the message, free in the costmap
};

// Cells of a message beside those of a costmap without inflation.
void compare(const OccupancyGrid& grid, const Nav2Costmap& costmap, const Pose2& robot, Compared& compared) {
  const double resolution_m{static_cast<double>(grid.info.resolution)};
  for (std::size_t i{0}; i < grid.data.size(); ++i) {
    const Point2 place{grid.info.origin.position.x + (static_cast<double>(i % grid.info.width) + 0.5) * resolution_m,
                       grid.info.origin.position.y + (static_cast<double>(i / grid.info.width) + 0.5) * resolution_m};
    int mx{0};
    int my{0};
    const bool is_own{std::hypot(place.x - robot.x_m, place.y - robot.y_m) < robot_radius_m + resolution_m};
    if (is_own || !costmap.cells().world_to_map(place, mx, my)) continue;
    const bool is_lethal{costmap.cells().at(mx, my) == cost::lethal};
    compared.lethal += grid.data[i] == 100 ? 1 : 0;
    compared.lost += grid.data[i] == 100 && !is_lethal ? 1 : 0;
    compared.invented += grid.data[i] != 100 && is_lethal ? 1 : 0;
    compared.hidden += grid.data[i] == -1 && costmap.cells().at(mx, my) == cost::free_space ? 1 : 0;
  }
}

TEST(Nav2Parameters, LoseAndInventNoObstacles) {
  Drive drive{"crossing?width=320&height=160&frames=20", "default"};
  YAML::Node parameters{drive.costmap(Nav2Source::grid)};
  parameters["plugins"] = std::vector<std::string>{"stereo_grid"};  // without inflation
  const auto topic{parameters["stereo_grid"]["map_topic"].as<std::string>()};
  std::array<Nav2Costmap, 2> costmaps{Nav2Costmap{parameters, robot_radius_m, Nav2Version::jazzy},
                                      Nav2Costmap{parameters, robot_radius_m, Nav2Version::lyrical}};
  Compared planned;
  Compared present;
  for (std::size_t i{0}; i < drive.size(); ++i) {
    const Pose2 robot{drive.next()};
    const auto grid{drive.recorder().last<OccupancyGrid>(topic)};
    for (Nav2Costmap& costmap : costmaps) {
      costmap.receive(topic, grid);
      costmap.update(robot);
      compare(grid, costmap, robot, planned);
      compare(drive.recorder().last<OccupancyGrid>("/stereo_grid/occupancy_grid"), costmap, robot, present);
    }
  }
  std::printf("%d lethal cells: %d lost, %d invented; of %d of the present %d lost\n", planned.lethal, planned.lost,
              planned.invented, present.lethal, present.lost);
  EXPECT_GT(present.lethal, 1000);
  EXPECT_GT(planned.lethal, present.lethal) << "no predictions";
  EXPECT_EQ(planned.lost, 0);
  EXPECT_EQ(planned.invented, 0);
  EXPECT_EQ(planned.hidden, 0);
  EXPECT_EQ(present.lost, 0);
}

TEST(Nav2Parameters, MarkNothingWhereAllIsFree) {
  for (const auto& [scene, preset_name] : {std::pair{"street?width=320&height=160&frames=1", "default"},
                                           std::pair{"corridor?camera=robot&frames=1", "robot"}}) {
    Drive drive{scene, preset_name};
    const Pose2 robot{drive.last()};
    auto scan{drive.recorder().last<LaserScan>("/stereo_grid/scan")};
    std::ranges::fill(scan.ranges, std::numeric_limits<float>::infinity());
    YAML::Node parameters{drive.costmap(Nav2Source::scan)};
    const auto lethal_cells = [&] {
      Nav2Costmap costmap{parameters, robot_radius_m};
      costmap.receive("/stereo_grid/scan", scan, robot);
      costmap.update(robot);
      EXPECT_GT(std::ranges::count(costmap.cells().costs, cost::free_space), 100);
      return std::ranges::count(costmap.cells().costs, cost::lethal);
    };
    EXPECT_EQ(lethal_cells(), 0) << preset_name;
    parameters["stereo_grid"]["scan"]["obstacle_max_range"] = static_cast<double>(scan.range_max) + 1;
    EXPECT_GT(lethal_cells(), std::ssize(scan.ranges) / 4) << "walls that the ranges above prevent";
  }
}

TEST(Nav2Parameters, MarkTheObstaclesOfTheScan) {
  Drive drive{"street?width=320&height=160&frames=8", "default"};
  const Pose2 robot{drive.last()};
  const auto scan{drive.recorder().last<LaserScan>("/stereo_grid/scan")};
  const YAML::Node parameters{drive.costmap(Nav2Source::scan)};
  Nav2Costmap costmap{parameters, robot_radius_m};
  costmap.receive("/stereo_grid/scan", scan, robot);
  costmap.update(robot);
  const auto far_m{parameters["stereo_grid"]["scan"]["obstacle_max_range"].as<float>()};
  int hits{0};
  for (std::size_t i{0}; i < scan.ranges.size(); ++i) {
    const auto range_m{static_cast<double>(scan.ranges[i])};
    if (!(scan.ranges[i] < far_m)) continue;
    const auto bearing_rad{static_cast<double>(scan.angle_min + static_cast<float>(i) * scan.angle_increment)};
    const Point2 hit{range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad)};
    EXPECT_EQ(costmap.cost_at(robot * hit), cost::lethal);
    ++hits;
  }
  EXPECT_GT(hits, std::ssize(scan.ranges) / 10);
  EXPECT_LE(std::ranges::count(costmap.cells().costs, cost::lethal), hits);
}

TEST(Nav2Parameters, AcceptTheWindowAsItMoves) {
  std::set<double> corners;
  for (const Recorder::Sent& one : driven_street().recorder().sent) {
    if (one.topic != "/stereo_grid/occupancy_grid") continue;
    OccupancyGrid grid;
    decode(one.cdr, grid);
    EXPECT_EQ(grid.data.size(), std::size_t{grid.info.width} * grid.info.height);
    EXPECT_EQ(grid.info.origin.orientation.w, 1) << "a turn is ignored";
    const double resolution_m{static_cast<double>(grid.info.resolution)};
    for (const double corner_m : {grid.info.origin.position.x, grid.info.origin.position.y}) {
      EXPECT_NEAR(std::remainder(corner_m, resolution_m), 0, 1e-9);
    }
    corners.insert(grid.info.origin.position.x);
  }
  EXPECT_GT(corners.size(), 1u) << "it did not move";
}

TEST(Nav2Parameters, KeepAScanThatLiesOnTheGround) {
  const YAML::Node layer{driven_street().costmap(Nav2Source::scan)["stereo_grid"]};
  for (const YAML::Node& node : {layer, layer["scan"]}) {
    EXPECT_LT(node["min_obstacle_height"].as<double>(), 0);
    EXPECT_GT(node["max_obstacle_height"].as<double>(), 0);
  }
}

// Points in a rectangle of the vehicle frame, as nav2_collision_monitor counts them (scan.cpp, polygon.cpp).
int points_within(const LaserScan& scan, Point2 low, Point2 high) {
  int points{0};
  for (std::size_t i{0}; i < scan.ranges.size(); ++i) {
    if (!(scan.ranges[i] >= scan.range_min && scan.ranges[i] <= scan.range_max)) continue;
    const auto range_m{static_cast<double>(scan.ranges[i])};
    const auto bearing_rad{static_cast<double>(scan.angle_min + static_cast<float>(i) * scan.angle_increment)};
    const Point2 point{range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad)};
    points += point.x > low.x && point.x < high.x && point.y > low.y && point.y < high.y ? 1 : 0;
  }
  return points;
}

TEST(Nav2CollisionMonitor, StopsBeforeADrop) {
  constexpr int min_points{4};  // its default
  Drive drive{"terrain?kind=edge&depth=0.9&at=8&frames=20", "default"};
  static_cast<void>(drive.last());
  const auto scan{drive.recorder().last<LaserScan>("/stereo_grid/scan")};
  EXPECT_GE(points_within(scan, {5, -1}, {9, 1}), min_points);
  EXPECT_EQ(points_within(scan, {0, -1}, {5, 1}), 0) << "the road before it";
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
    expect_topic(name, types.at(kind), topic["Durability Policy"].as<std::string>() == "Transient Local");
  }
  EXPECT_EQ(displays, 6);
}

TEST(AutowareExample, ReadsFreeUnknownAndOccupied) {
  const YAML::Node file{YAML::LoadFile(STEREOGRID_PLANNERS "/autoware.param.yaml")};
  const YAML::Node node{file["/**"]["ros__parameters"]};
  const YAML::Node grid{node["occlusion_spot"]["grid"]};
  const int free_max{grid["free_space_max"].as<int>()};
  const int occupied_min{grid["occupied_min"].as<int>()};
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
}

}  // namespace
}  // namespace stereogrid::messages::test
