// SPDX-License-Identifier: Apache-2.0
//
// A round robot that finds its way through the scene "corridor" on the published grids: costs of Nav2's local costmap
// (nav2_costmap.hpp) with nav2_local_costmap(), A*, and a controller that follows the path. The scene is rendered from
// where the robot is.
#include <queue>

#include "nav2_costmap.hpp"
#include "stereogrid/messages/nav2_parameters.hpp"

#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using nav_msgs::OccupancyGrid;

constexpr double radius_m{0.25};
constexpr double blind_m{0.75};  // ground nearer than this is below the image
constexpr double ahead_m{0.9};   // part of the path that has to be free and seen
constexpr double most_mps{0.6};
constexpr double tolerance_m{0.5};  // default of Nav2's planners
constexpr double step_s{0.1};

double distance(Point2 a, Point2 b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

constexpr GridGeometry corridor{-1, -2, 0.05, 360, 80};

/// A* over eight neighbours. As in Nav2's NavFn unknown cells cost as much as the most expensive ones, and a goal that
/// cannot be reached is replaced by the nearest point within the tolerance that can. Empty: there is no path.
std::vector<Point2> path(const Nav2Costmap& map, Point2 from, Point2 to) {
  constexpr GridGeometry grid{corridor};
  const auto begin{grid.cell_at(from)};
  const auto end{grid.cell_at(to)};
  if (!begin || !end) return {};
  struct Open {
    double total;
    int cell;
    bool operator<(const Open& other) const { return total > other.total; }
  };
  const auto index = [&](CellIndex cell) { return cell.iy * grid.nx + cell.ix; };
  const auto size{static_cast<std::size_t>(grid.nx * grid.ny)};
  std::vector<double> costs(size, std::numeric_limits<double>::infinity());
  std::vector<int> before(size, -1);
  std::priority_queue<Open> open;
  costs[static_cast<std::size_t>(index(*begin))] = 0;
  open.push({0, index(*begin)});
  while (!open.empty()) {
    const int cell{open.top().cell};
    open.pop();
    if (cell == index(*end)) break;
    const int ix{cell % grid.nx};
    const int iy{cell / grid.nx};
    for (int k{0}; k < 9; ++k) {
      const CellIndex next{ix + k % 3 - 1, iy + k / 3 - 1};
      if (k == 4 || next.ix < 0 || next.ix >= grid.nx || next.iy < 0 || next.iy >= grid.ny) continue;
      const int there{map.cost_at(grid.centre(next.ix, next.iy))};
      const bool leaves{distance(grid.centre(next.ix, next.iy), from) < radius_m};  // it is too near
      if (there == cost::lethal || (there == cost::inscribed && !leaves)) continue;
      const double factor{1 + std::min(there, cost::inscribed) / 50.0};
      const auto at{static_cast<std::size_t>(index(next))};
      const double total{costs[static_cast<std::size_t>(cell)] + factor * std::hypot(next.ix - ix, next.iy - iy)};
      if (total >= costs[at]) continue;
      costs[at] = total;
      before[at] = cell;
      open.push({total + std::hypot(next.ix - end->ix, next.iy - end->iy), static_cast<int>(at)});
    }
  }
  CellIndex reached{*end};
  double off_m{std::isinf(costs[static_cast<std::size_t>(index(*end))]) ? tolerance_m : 0};
  for (int cell{0}; cell < grid.nx * grid.ny && off_m > 0; ++cell) {
    const CellIndex at{cell % grid.nx, cell / grid.nx};
    const double away_m{distance(grid.centre(at.ix, at.iy), to)};
    if (std::isinf(costs[static_cast<std::size_t>(cell)]) || away_m >= off_m) continue;
    off_m = away_m;
    reached = at;
  }
  std::vector<Point2> found;
  for (int cell{index(reached)}; cell >= 0; cell = before[static_cast<std::size_t>(cell)]) {
    found.push_back(grid.centre(cell % grid.nx, cell / grid.nx));
  }
  std::ranges::reverse(found);
  return found.size() > 1 ? found : std::vector<Point2>{};
}

/// A robot that follows paths: on ground that is free and was seen, once it is turned towards it. Its accelerations are
/// those of Nav2's examples, as is its recovery: after 5 s without motion it backs up by 0.3 m, so that cells below the
/// image come into view again.
struct Robot {
  Pose2 pose;
  double speed_mps{0};
  double turn_radps{0};
  int stopped{0};  ///< frames without motion
  int backing{0};  ///< frames of the recovery left

  [[nodiscard]] Point2 place() const { return {pose.x_m, pose.y_m}; }

  void follow(const std::vector<Point2>& path, const Nav2Costmap& map) {
    Point2 target{pose * Point2{1, 0}};
    double length_m{0};
    bool is_free{!path.empty()};
    for (std::size_t i{1}; i < path.size() && length_m < ahead_m; ++i) {
      length_m += distance(path[i - 1], path[i]);
      is_free = is_free && (map.cost_at(path[i]) < cost::inscribed || distance(path[i], place()) < blind_m);
      if (length_m < 0.8) target = path[i];
    }
    const double bearing{std::atan2(target.y - pose.y_m, target.x - pose.x_m) - pose.yaw_rad};
    const double error{std::remainder(bearing, 2 * 3.14159265358979323846)};
    change(turn_radps, std::clamp(1.5 * error, -1.0, 1.0), 2.5);
    change(speed_mps, is_free ? most_mps * std::max(0.0, 1 - std::abs(error) / 0.8) : 0, 2.5);
    const bool is_still{std::abs(speed_mps) < 0.01 && std::abs(turn_radps) < 0.01};
    stopped = is_still && backing == 0 ? stopped + 1 : 0;
    if (stopped * step_s > 5) backing = 30;
    if (backing > 0) {
      --backing;
      speed_mps = -0.1;
      turn_radps = 0;
    }
    pose = pose * Pose2{speed_mps * step_s, 0, turn_radps * step_s};
  }

 private:
  static void change(double& value, double wanted, double per_s) {
    value += std::clamp(wanted - value, -per_s * step_s, per_s * step_s);
  }
};

/// Distance between a point and a convex polygon; 0 inside.
double distance(Point2 point, const std::vector<Point2>& polygon) {
  double least{std::numeric_limits<double>::infinity()};
  bool is_inside{true};
  for (std::size_t i{0}; i < polygon.size(); ++i) {
    const Point2 a{polygon[i]};
    const Point2 b{polygon[(i + 1) % polygon.size()]};
    const Point2 side{b.x - a.x, b.y - a.y};
    const Point2 to{point.x - a.x, point.y - a.y};
    is_inside = is_inside && side.x * to.y - side.y * to.x >= 0;
    const double share{std::clamp((side.x * to.x + side.y * to.y) / (side.x * side.x + side.y * side.y), 0.0, 1.0)};
    least = std::min(least, distance(point, Point2{a.x + share * side.x, a.y + share * side.y}));
  }
  return is_inside ? 0 : least;
}

/// Objects and hazards, where they are at an instant.
class Surroundings {
 public:
  explicit Surroundings(const scenes::Scene& scene) : objects_{scene.truth(0).objects} {
    for (const TruthZone& zone : scene.truth_grid().zones) {
      TruthObject& object{objects_.emplace_back()};
      object.kind = zone.kind;
      object.footprint = {zone.low, {zone.high.x, zone.low.y}, zone.high, {zone.low.x, zone.high.y}};
    }
  }

  [[nodiscard]] double box_y_m() const {
    return std::ranges::find(objects_, "box", &TruthObject::kind)->world_from_object.y_m;
  }

  struct Nearest {
    std::string kind;
    double gap_m;
  };
  [[nodiscard]] Nearest nearest(Point2 robot, double time_s) const {
    Nearest found{"", std::numeric_limits<double>::infinity()};
    for (const TruthObject& object : objects_) {
      const Point2 relative{robot.x - object.vx_mps * time_s, robot.y - object.vy_mps * time_s};
      const double gap_m{distance(relative, object.footprint) - radius_m};
      if (gap_m < found.gap_m) found = {object.kind, gap_m};
    }
    return found;
  }

 private:
  std::vector<TruthObject> objects_;
};

class ClosedLoop : public testing::TestWithParam<int> {};

TEST_P(ClosedLoop, ArrivesAndTouchesNothing) {
  const scenes::Scene scene{scenes::parse_scene("corridor?camera=robot&seed=" + std::to_string(GetParam())), 2};
  const Surroundings surroundings{scene};
  const TruthZone stairs{scene.truth_grid().zones.front()};
  const Point2 goal{13.4, stairs.low.y < -1 ? 0.7 : -0.7};
  Pipeline pipeline{preset("robot"),
                    scene.rig(),
                    {.threads = 2, .stages = false, .horizons_s = {0.5, 1, 1.5, 2}, .in_world_of_poses = true}};
  Recorder recorder;
  FrameMessages messages{recorder, pipeline.rig(), {.scale = OccupancyScale::nav2}};
  const Nav2Options options{.source = Nav2Source::grid, .has_predictions = true};
  const YAML::Node file{YAML::Load(nav2_local_costmap(pipeline.rig(), pipeline.vehicle_grid(), options))};
  const YAML::Node parameters{file["local_costmap"]["local_costmap"]["ros__parameters"]};
  const auto topic{parameters["stereo_grid"]["map_topic"].as<std::string>()};
  Nav2Costmap map{parameters, radius_m + corridor.cell_size_m};
  const Point2 start{0, surroundings.box_y_m()};  // behind the box
  Robot robot{{start.x, start.y, 0}};
  Surroundings::Nearest closest{"", 10};
  std::size_t i{0};
  for (; i < scene.size() && closest.gap_m > 0 && distance(robot.place(), goal) > 0.2; ++i) {
    const StereoFrame frame{scene.load(i, robot.pose)};
    recorder.sent.clear();
    messages.send(pipeline.process(frame), {.stamp_ns = frame.stamp_ns});
    map.receive(topic, recorder.last<OccupancyGrid>(topic));
    map.update(robot.pose);
    robot.follow(path(map, robot.place(), goal), map);
    const auto nearest{surroundings.nearest(robot.place(), static_cast<double>(i + 1) * step_s)};
    if (nearest.gap_m < closest.gap_m) closest = nearest;
  }
  std::printf("seed %d: %zu frames, at (%.2f, %.2f); least gap %.2f m: %s\n", GetParam(), i, robot.pose.x_m,
              robot.pose.y_m, closest.gap_m, closest.kind.c_str());
  EXPECT_GT(closest.gap_m, 0) << closest.kind;
  EXPECT_LE(distance(robot.place(), goal), 0.2);
}

INSTANTIATE_TEST_SUITE_P(TenSeeds, ClosedLoop, testing::Range(1, 11));

}  // namespace
}  // namespace stereogrid::messages::test
