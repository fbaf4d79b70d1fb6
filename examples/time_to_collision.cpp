// SPDX-License-Identifier: Apache-2.0
//
// Time until the vehicle hits an obstacle if it goes straight on at constant speed. Searches its path in the predicted
// grids, each at its own instant, and intersects it with the outlines of obstacles at constant velocity.
//
// time_to_collision [SCENE]     SCENE: as in docs/input.md, without "scene:"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>
#include <vector>

#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace {

using namespace stereogrid;

constexpr double step_s{0.25};
constexpr double farthest_s{3};
constexpr double half_width_m{1};
constexpr double front_m{1};  // distance of the vehicle's front from the camera
constexpr float occupied_from{0.7f};

std::vector<double> horizons_s() {
  std::vector<double> all;
  for (double horizon_s{step_s}; horizon_s <= farthest_s; horizon_s += step_s) all.push_back(horizon_s);
  return all;
}

// The largest P(occupied) where the car's front passes between x_from_m and x_to_m.
float largest_on_path(const GridGeometry& grid, const Image<float>& occupancy, double x_from_m, double x_to_m) {
  float largest{0};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Point2 place{grid.centre(ix, iy)};
      const bool on_path{place.x >= x_from_m && place.x < x_to_m && std::abs(place.y) < half_width_m};
      if (on_path) largest = std::max(largest, occupancy(ix, iy));
    }
  }
  return largest;
}

std::optional<double> time_to_collision_s(const FrameResult& result, double speed_mps) {
  for (const Prediction& then : result.predictions) {
    const double front_then_m{front_m + speed_mps * then.horizon_s};
    const double swept_m{speed_mps * step_s + result.vehicle.geometry.cell_size_m};
    if (largest_on_path(result.vehicle.geometry, then.occupancy, front_then_m - swept_m, front_then_m) >
        occupied_from) {
      return then.horizon_s;
    }
  }
  return {};
}

// Distance from the front to the first point of the line from a to b on the path, m.
std::optional<double> on_path_m(Point2 a, Point2 b) {
  if (a.y > b.y) std::swap(a, b);
  const double from_y{std::max(a.y, -half_width_m)};
  const double to_y{std::min(b.y, half_width_m)};
  if (from_y > to_y) return {};
  const auto x_at = [&](double y) {
    return b.y > a.y ? a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y) : std::min(a.x, b.x);
  };
  const double nearest_m{std::min(x_at(from_y), x_at(to_y)) - front_m};
  return nearest_m >= 0 ? std::optional{nearest_m} : std::nullopt;
}

std::optional<double> on_path_m(const Obstacle& obstacle) {
  std::optional<double> nearest_m;
  const Outline& outline{obstacle.outline};
  const std::size_t first{obstacle.kind == ObstacleKind::object ? 0u : 1u};  // an open line
  for (std::size_t i{first}; i < outline.size(); ++i) {
    const std::optional<double> here_m{on_path_m(outline[i], outline[i == 0 ? outline.size() - 1 : i - 1])};
    if (here_m && (!nearest_m || *here_m < *nearest_m)) nearest_m = here_m;
  }
  return nearest_m;
}

// The obstacle that is met first, if each one keeps its velocity along the path.
void print_first_obstacle(const FrameResult& result, double speed_mps) {
  const Obstacle* first{nullptr};
  double first_m{0};
  double first_s{0};
  for (const Obstacle& obstacle : result.obstacles) {
    const double closing_mps{speed_mps - obstacle.vx_mps};
    const std::optional<double> away_m{obstacle.confirmed ? on_path_m(obstacle) : std::nullopt};
    if (!away_m || closing_mps <= 0 || (first != nullptr && *away_m / closing_mps >= first_s)) continue;
    first = &obstacle;
    first_m = *away_m;
    first_s = *away_m / closing_mps;
  }
  if (first == nullptr) return;
  std::printf("    obstacle %lld (%s) in %.1f m, %.2f s\n", static_cast<long long>(first->id),
              names_of(ObstacleKind{})[static_cast<std::size_t>(first->kind)].data(), first_m, first_s);
}

void drive(const FrameSource& source) {
  Config config;
  config.grid.length_m = 30;
  Pipeline pipeline{config, source.rig(), {.stages = false, .horizons_s = horizons_s()}};
  std::optional<StereoFrame> before;
  for (std::size_t i{0}; i < source.size(); ++i) {
    StereoFrame frame{source.load(i)};
    const FrameResult& result{pipeline.process(frame)};
    if (before) {
      const double dt_s{static_cast<double>(frame.stamp_ns - before->stamp_ns) * 1e-9};
      const Pose2 moved{inverse(*before->world_from_vehicle) * *frame.world_from_vehicle};
      const double speed_mps{std::hypot(moved.x_m, moved.y_m) / dt_s};
      const std::optional<double> time_s{time_to_collision_s(result, speed_mps)};
      std::printf("%s: %.1f m/s, %s", frame.name.c_str(), speed_mps, time_s ? "something in the way in " : "free\n");
      if (time_s) std::printf("%.2f s\n", *time_s);
      print_first_obstacle(result, speed_mps);
    }
    before = std::move(frame);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    drive(scenes::Scene{scenes::parse_scene(argc > 1 ? argv[1] : "street?frames=20")});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "time_to_collision: %s\n", error.what());
    return 65;
  }
  return 0;
}
