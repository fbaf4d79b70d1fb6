// SPDX-License-Identifier: Apache-2.0
//
// ros2/stereogrid_nav2 in the update loop of Nav2's costmaps, as the stand-in has it.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grid_layer.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/occupancy_values.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid_nav2::testing {
namespace {

using nav2_costmap_2d::Costmap2D;
using nav2_costmap_2d::FREE_SPACE;
using nav2_costmap_2d::INSCRIBED_INFLATED_OBSTACLE;
using nav2_costmap_2d::LETHAL_OBSTACLE;
using nav2_costmap_2d::NO_INFORMATION;
using ::testing::Contains;
using ::testing::HasSubstr;
using Grid = nav_msgs::msg::OccupancyGrid;

constexpr const char* present{"/stereo_grid/occupancy_grid"};
constexpr const char* predicted{"/stereo_grid/planning_grid"};
constexpr double resolution_m{0.25};
constexpr std::int64_t second_ns{1'000'000'000};
constexpr std::int64_t begin_ns{100 * second_ns};

/// Another layer or filter: writes one cost to the rectangle of its cells [low, high).
class Painter final : public nav2_costmap_2d::Layer {
 public:
  Painter(unsigned char cost, int low, int high) : cost_{cost}, low_{low}, high_{high} {
    enabled_ = true;
    current_ = true;
  }
  void updateBounds(double, double, double, double*, double*, double*, double*) override {}
  void updateCosts(Costmap2D& master, int min_i, int min_j, int max_i, int max_j) override {
    for (int j{std::max(low_, min_j)}; j < std::min(high_, max_j); ++j) {
      for (int i{std::max(low_, min_i)}; i < std::min(high_, max_i); ++i) master.setCost(i, j, cost_);
    }
  }
  void reset() override {}
  bool isClearable() override { return false; }

 private:
  unsigned char cost_;
  int low_;
  int high_;
};

Grid grid_of(int columns, int rows, std::int8_t value, double x_m = 0, double y_m = 0) {
  Grid grid;
  grid.header.stamp.sec = static_cast<std::int32_t>(begin_ns / second_ns);
  grid.header.frame_id = "odom";
  grid.info.resolution = static_cast<float>(resolution_m);
  grid.info.width = static_cast<std::uint32_t>(columns);
  grid.info.height = static_cast<std::uint32_t>(rows);
  grid.info.origin.position = {x_m, y_m, 0};
  grid.data.assign(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), value);
  return grid;
}

void publish(const std::string& topic, const Grid& grid) {
  stand_in::world().subscribers.at(topic)(&grid);
}

/// Costmap of 8 m × 8 m from the origin on, robot at (4, 4), footprint of 0.5 m × 0.5 m.
class Nav2Layer : public ::testing::Test {
 protected:
  void SetUp() override {
    stand_in::world().subscribers.clear();
    stand_in::world().latched_subscribers.clear();
    stand_in::world().log.clear();
    stand_in::world().now_ns = begin_ns;
    stand_in::lookup() = nullptr;
  }

  void start(std::vector<rclcpp::Parameter> parameters = {}, double cell_m = resolution_m, bool is_rolling = false) {
    node_ =
        std::make_shared<nav2::LifecycleNode>("local_costmap", rclcpp::NodeOptions{}.parameter_overrides(parameters));
    costmap_ = std::make_unique<nav2_costmap_2d::LayeredCostmap>("odom", is_rolling, true);
    costmap_->setFootprint({{-0.25, -0.25, 0}, {0.25, -0.25, 0}, {0.25, 0.25, 0}, {-0.25, 0.25, 0}});
    const auto cells{static_cast<unsigned int>(std::lround(8 / cell_m))};
    costmap_->resizeMap(cells, cells, cell_m, 0, 0);
    layer_ = std::make_shared<GridLayer>();
    layer_->initialize(costmap_.get(), "stereo_grid", &transforms_, node_);
  }
  void add_layer() { costmap_->addPlugin(layer_); }
  void update() { costmap_->updateMap(4, 4, 0); }
  [[nodiscard]] int cost(unsigned int mx, unsigned int my) const { return costmap_->getCostmap()->getCost(mx, my); }
  [[nodiscard]] int cost_at(double x_m, double y_m) const {
    unsigned int mx{0};
    unsigned int my{0};
    return costmap_->getCostmap()->worldToMap(x_m, y_m, mx, my) ? cost(mx, my) : -1;
  }
  [[nodiscard]] int lethal_cells() const {
    const Costmap2D& map{*costmap_->getCostmap()};
    int cells{0};
    for (unsigned int my{0}; my < map.getSizeInCellsY(); ++my) {
      for (unsigned int mx{0}; mx < map.getSizeInCellsX(); ++mx) cells += map.getCost(mx, my) == LETHAL_OBSTACLE;
    }
    return cells;
  }

  tf2_ros::Buffer transforms_{std::make_shared<rclcpp::Clock>()};
  nav2::LifecycleNode::SharedPtr node_;
  std::unique_ptr<nav2_costmap_2d::LayeredCostmap> costmap_;
  std::shared_ptr<GridLayer> layer_;
};

TEST_F(Nav2Layer, GivesEachValueItsCost) {
  start();
  add_layer();
  EXPECT_THAT(stand_in::world().latched_subscribers, Contains(present));
  int before{0};
  for (int percent{0}; percent <= 100; ++percent) {
    publish(present, grid_of(8, 8, static_cast<std::int8_t>(percent)));
    update();
    EXPECT_EQ(cost(2, 2) == FREE_SPACE, percent <= 35) << percent;
    EXPECT_EQ(cost(2, 2) == LETHAL_OBSTACLE, percent >= 65) << percent;
    EXPECT_NE(cost(2, 2), INSCRIBED_INFLATED_OBSTACLE) << percent;
    EXPECT_GE(cost(2, 2), before);
    before = cost(2, 2);
  }
  publish(present, grid_of(8, 8, -1));
  update();
  EXPECT_EQ(cost(2, 2), NO_INFORMATION);
  EXPECT_EQ(cost(20, 20), NO_INFORMATION) << "outside of the grid";
}

TEST_F(Nav2Layer, LowersNothingUnlessItOverwrites) {
  for (const int method : {1, 0}) {
    start({{"stereo_grid.combination_method", method}});
    costmap_->addPlugin(std::make_shared<Painter>(100, 0, 4));
    add_layer();
    Grid grid{grid_of(8, 8, 0)};
    grid.data[0] = -1;
    grid.data[1] = 100;
    publish(present, grid);
    update();
    EXPECT_EQ(cost(0, 0), 100) << "unknown";
    EXPECT_EQ(cost(1, 0), LETHAL_OBSTACLE);
    EXPECT_EQ(cost(2, 0), method == 1 ? 100 : FREE_SPACE);
    EXPECT_EQ(cost(5, 0), FREE_SPACE) << "unknown to the other layer";
  }
}

TEST_F(Nav2Layer, AddsPredictions) {
  start({{"stereo_grid.prediction_topic", std::string{predicted}}, {"stereo_grid.prediction_cost", 200}});
  add_layer();
  Grid grid{grid_of(8, 8, 0)};
  grid.data[3] = 100;
  grid.data[4] = -1;
  publish(present, grid);
  update();
  EXPECT_FALSE(costmap_->isCurrent()) << "no prediction so far";
  Grid prediction{grid_of(8, 8, 50)};
  prediction.data[3] = prediction.data[4] = prediction.data[5] = 100;
  publish(predicted, prediction);
  update();
  EXPECT_TRUE(costmap_->isCurrent());
  EXPECT_EQ(cost(2, 0), FREE_SPACE) << "possible, not predicted";
  EXPECT_EQ(cost(3, 0), LETHAL_OBSTACLE) << "the present";
  EXPECT_EQ(cost(4, 0), 200);
  EXPECT_EQ(cost(5, 0), 200);
}

TEST_F(Nav2Layer, ResetsCellsThatTheGridHasLeft) {
  start({}, resolution_m, true);
  add_layer();
  publish(present, grid_of(8, 8, 100, 2, 2));
  update();
  EXPECT_EQ(cost_at(2.1, 2.1), LETHAL_OBSTACLE);
  publish(present, grid_of(8, 8, 100, 3, 2));
  update();
  EXPECT_EQ(cost_at(2.1, 2.1), NO_INFORMATION);
  EXPECT_EQ(cost_at(4.9, 2.1), LETHAL_OBSTACLE);
  node_->set_parameter({"stereo_grid.enabled", false});
  update();
  EXPECT_EQ(lethal_cells(), 0);
}

TEST_F(Nav2Layer, IsCurrentWhileGridsAreRecent) {
  start();
  add_layer();
  update();
  EXPECT_FALSE(costmap_->isCurrent());
  EXPECT_THAT(stand_in::world().log, Contains(HasSubstr("no grid on /stereo_grid/occupancy_grid")));
  publish(present, grid_of(8, 8, 100));
  EXPECT_FALSE(costmap_->isCurrent()) << "not before the next update";
  update();
  EXPECT_TRUE(costmap_->isCurrent());
  for (const auto& [age_s, is_current] : {std::pair{0.9, true}, {1.1, false}, {-1.1, false}}) {
    stand_in::world().now_ns = begin_ns + static_cast<std::int64_t>(age_s * 1e9);
    update();
    EXPECT_EQ(costmap_->isCurrent(), is_current) << age_s;
    EXPECT_EQ(cost(0, 0), LETHAL_OBSTACLE) << "obstacles stay";
  }
  EXPECT_THAT(stand_in::world().log, Contains(HasSubstr("is 1.1 s old (timeout 1.0 s)")));
  stand_in::world().now_ns = begin_ns;
  layer_->reset();
  EXPECT_FALSE(costmap_->isCurrent());
  update();
  EXPECT_TRUE(costmap_->isCurrent());
  EXPECT_FALSE(layer_->isClearable());
}

TEST_F(Nav2Layer, TransformsGridsOfAnotherFrame) {
  start();
  add_layer();
  Grid grid{grid_of(8, 8, 0, 1, 0)};
  grid.header.frame_id = "map";
  grid.data[7] = 100;  // x 2.75 to 3 m, y 0 to 0.25 m of map
  publish(present, grid);
  update();
  EXPECT_FALSE(costmap_->isCurrent());
  EXPECT_THAT(stand_in::world().log,
              Contains(HasSubstr("the place of the grid on /stereo_grid/occupancy_grid is unknown")));
  EXPECT_EQ(lethal_cells(), 0);
  stand_in::lookup() = [](const std::string& target, const std::string& source, std::int64_t stamp_ns) {
    EXPECT_EQ(target + " " + source, "odom map");
    EXPECT_EQ(stamp_ns, 0) << "the latest";
    return geometry_msgs::msg::Transform{{5, 2, 0}, {0, 0, std::sqrt(0.5), std::sqrt(0.5)}};  // to the left
  };
  update();
  EXPECT_TRUE(costmap_->isCurrent());
  EXPECT_EQ(lethal_cells(), 1);
  EXPECT_EQ(cost_at(4.875, 4.875), LETHAL_OBSTACLE);
  EXPECT_EQ(cost_at(4.875, 3.125), FREE_SPACE);
}

TEST_F(Nav2Layer, LosesNoObstacleInLargerCells) {
  start({}, 1);
  add_layer();
  Grid grid{grid_of(8, 8, 0)};
  grid.data[0] = 100;
  publish(present, grid);
  update();
  EXPECT_EQ(cost(0, 0), LETHAL_OBSTACLE);
  EXPECT_EQ(cost(1, 1), FREE_SPACE);
}

TEST_F(Nav2Layer, LeavesCostmapFiltersTheirCells) {
  start();
  add_layer();
  costmap_->addFilter(std::make_shared<Painter>(LETHAL_OBSTACLE, 2, 4));
  publish(present, grid_of(8, 8, 0));
  for (int i{0}; i < 2; ++i) {
    update();
    EXPECT_EQ(cost(3, 3), LETHAL_OBSTACLE);
    EXPECT_EQ(cost(5, 5), FREE_SPACE);
  }
  Costmap2D master{*costmap_->getCostmap()};
  publish(present, grid_of(8, 8, 100));
  update();
  layer_->updateCosts(master, 4, 4, 6, 6);
  EXPECT_EQ(master.getCost(5, 5), LETHAL_OBSTACLE);
  EXPECT_EQ(master.getCost(7, 7), FREE_SPACE) << "outside of the area";
}

TEST_F(Nav2Layer, FreesItsOwnCellsBelowTheRobot) {
  for (const bool clears : {true, false}) {
    start({{"stereo_grid.footprint_clearing_enabled", clears}});
    costmap_->addPlugin(std::make_shared<Painter>(LETHAL_OBSTACLE, 16, 17));
    add_layer();
    publish(present, grid_of(8, 8, 100, 3, 3));
    update();
    EXPECT_EQ(cost(15, 15), clears ? FREE_SPACE : LETHAL_OBSTACLE);
    EXPECT_EQ(cost(16, 16), LETHAL_OBSTACLE) << "of another layer";
    EXPECT_EQ(cost(18, 18), LETHAL_OBSTACLE) << "beside the robot";
  }
}

TEST_F(Nav2Layer, ChecksItsParameters) {
  for (const rclcpp::Parameter& wrong :
       {rclcpp::Parameter{"stereo_grid.lethal_threshold", 30}, rclcpp::Parameter{"stereo_grid.free_threshold", 50},
        rclcpp::Parameter{"stereo_grid.prediction_cost", 255}, rclcpp::Parameter{"stereo_grid.combination_method", 2},
        rclcpp::Parameter{"stereo_grid.timeout", 0.0}}) {
    EXPECT_THROW(start({wrong}), rclcpp::exceptions::InvalidParameterValueException) << wrong.get_name();
  }
  start();
  layer_.reset();
  layer_ = std::make_shared<GridLayer>();
  layer_->initialize(costmap_.get(), "stereo_grid", &transforms_, node_);  // the costmap is configured again
  add_layer();
  publish(present, grid_of(8, 8, 80));
  update();
  EXPECT_EQ(cost(2, 2), LETHAL_OBSTACLE);
  EXPECT_FALSE(node_->set_parameter({"stereo_grid.lethal_threshold", 101}).successful);
  EXPECT_FALSE(node_->set_parameter({"stereo_grid.topic", std::string{"/other"}}).successful);
  EXPECT_TRUE(node_->set_parameter({"stereo_grid.lethal_threshold", 90}).successful);
  update();
  EXPECT_EQ(cost(2, 2), 252 * (80 - 35) / (90 - 35));
}

TEST_F(Nav2Layer, DropsMalformedGrids) {
  start();
  add_layer();
  Grid grid{grid_of(8, 8, 100)};
  grid.data.pop_back();
  publish(present, grid);
  update();
  EXPECT_EQ(lethal_cells(), 0);
  EXPECT_THAT(stand_in::world().log, Contains(HasSubstr("malformed grid on /stereo_grid/occupancy_grid: 8 x 8 cells")));
}

/// Keeps the newest grid of each topic.
class Newest final : public stereogrid::messages::Sink {
 public:
  std::uint32_t add(const stereogrid::messages::Channel& channel) override {
    topics_.push_back(channel.topic);
    return static_cast<std::uint32_t>(topics_.size() - 1);
  }
  [[nodiscard]] bool wants(std::uint32_t channel) const override {
    return topics_.at(channel) == present || topics_.at(channel) == predicted;
  }
  void send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) override {
    stereogrid::messages::nav_msgs::OccupancyGrid message;
    stereogrid::messages::decode(cdr, message);
    Grid& grid{grids[topics_.at(channel)]};
    grid.header.stamp = {message.header.stamp.sec, message.header.stamp.nanosec};
    grid.header.frame_id = message.header.frame_id;
    grid.info.resolution = message.info.resolution;
    grid.info.width = message.info.width;
    grid.info.height = message.info.height;
    grid.info.origin.position = {message.info.origin.position.x, message.info.origin.position.y, 0};
    grid.data = message.data;
  }

  std::map<std::string, Grid> grids;

 private:
  std::vector<std::string> topics_;
};

TEST_F(Nav2Layer, LosesAndInventsNoObstacles) {
  namespace sg = stereogrid;
  const sg::scenes::Scene scene{sg::scenes::parse_scene("crossing?width=320&height=160&frames=20"), 2};
  sg::Pipeline pipeline{sg::Config{}, scene.rig(), {.threads = 2, .stages = false, .horizons_s = {0.5, 1}}};
  Newest newest;
  sg::messages::FrameMessages messages{newest, pipeline.rig()};
  start({{"stereo_grid.prediction_topic", std::string{predicted}}}, 0.2, true);
  add_layer();
  costmap_->setFootprint({});
  costmap_->resizeMap(400, 400, 0.2, -40, -40);
  int lethal{0};
  int lost{0};
  int invented{0};
  int hidden{0};  // unknown cells that are free
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const sg::StereoFrame frame{scene.load(i)};
    const sg::FrameResult& result{pipeline.process(frame)};
    messages.send(result, {.stamp_ns = frame.stamp_ns});
    stand_in::world().now_ns = frame.stamp_ns;
    for (const auto& [topic, grid] : newest.grids) publish(topic, grid);
    costmap_->updateMap(result.world_from_vehicle.x_m, result.world_from_vehicle.y_m,
                        result.world_from_vehicle.yaw_rad);
    EXPECT_TRUE(costmap_->isCurrent());
    const Grid& plan{newest.grids.at(predicted)};
    for (std::size_t k{0}; k < plan.data.size(); ++k) {
      const double x_m{plan.info.origin.position.x + (static_cast<double>(k % plan.info.width) + 0.5) * 0.2};
      const double y_m{plan.info.origin.position.y + (static_cast<double>(k / plan.info.width) + 0.5) * 0.2};
      const int cost{cost_at(x_m, y_m)};
      ASSERT_GE(cost, 0);
      lethal += plan.data[k] >= 65;
      lost += plan.data[k] >= 65 && cost != LETHAL_OBSTACLE;
      invented += plan.data[k] < 65 && cost == LETHAL_OBSTACLE;
      hidden += newest.grids.at(present).data[k] < 0 && cost == FREE_SPACE;
    }
  }
  std::printf("%d lethal cells: %d lost, %d invented, %d unknown ones free\n", lethal, lost, invented, hidden);
  EXPECT_GT(lethal, 1000);
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(invented, 0);
  EXPECT_EQ(hidden, 0);
}

}  // namespace
}  // namespace stereogrid_nav2::testing
