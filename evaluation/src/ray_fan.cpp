// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/ray_fan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "label_geometry.hpp"

namespace stereogrid::evaluation {
namespace {

/// Walks along a ray from cell to cell of a grid (Amanatides & Woo 1987), in units of cells.
class GridWalk {
 public:
  GridWalk(Point2 start, Point2 direction) : x_{along(start.x, direction.x)}, y_{along(start.y, direction.y)} {}

  [[nodiscard]] int ix() const { return x_.cell; }
  [[nodiscard]] int iy() const { return y_.cell; }
  /// Length at which the ray leaves this cell.
  [[nodiscard]] double leaves_at() const { return std::min(x_.next_border, y_.next_border); }
  void advance() {
    Axis& axis{x_.next_border < y_.next_border ? x_ : y_};
    axis.cell += axis.sign;
    axis.next_border += axis.per_cell;
  }

 private:
  struct Axis {
    int cell;
    int sign;
    double next_border;
    double per_cell;
  };
  static Axis along(double start, double direction) {
    const double cell{std::floor(start)};
    if (direction == 0) return {static_cast<int>(cell), 0, 1e30, 1e30};
    const double border{direction > 0 ? cell + 1 : cell};
    return {static_cast<int>(cell), direction > 0 ? 1 : -1, (border - start) / direction, 1 / std::abs(direction)};
  }

  Axis x_;
  Axis y_;
};

bool contains(const GridGeometry& grid, int ix, int iy) {
  return ix >= 0 && iy >= 0 && ix < grid.nx && iy < grid.ny;
}

}  // namespace

Fan::Fan(Point2 origin, std::vector<Point2> directions, double length, double step)
    : origin_{origin},
      directions_{std::move(directions)},
      step_{step},
      hits_{static_cast<int>(std::ceil(length / step)) + 1, static_cast<int>(directions_.size())},
      ends_{hits_} {}

void Fan::add(std::size_t direction, double length, bool is_hit) {
  Image<float>& counts{is_hit ? hits_ : ends_};
  const double place{length / step_};
  // rays that end beyond the grid pass through it
  const int i{place < counts.width() ? static_cast<int>(place) : counts.width() - 1};
  const bool beyond{i == counts.width() - 1};
  (beyond ? ends_ : counts)(i, static_cast<int>(direction)) += 1;
}

RayCounts Fan::cast(const GridGeometry& grid, const Pose2& grid_from_fan) const {
  RayCounts counts{Image<float>{grid.nx, grid.ny}, Image<float>{grid.nx, grid.ny}};
  for (std::size_t i{0}; i < directions_.size(); ++i) cast_direction(i, grid, grid_from_fan, counts);
  return counts;
}

float Fan::ending_beyond(const std::vector<float>& beyond, double length) const {
  const auto i{static_cast<std::size_t>(std::max(0.0, std::ceil(length / step_)))};
  return i < beyond.size() ? beyond[i] : 0;
}

void Fan::cast_direction(std::size_t direction, const GridGeometry& grid, const Pose2& grid_from_fan,
                         RayCounts& counts) const {
  const int row{static_cast<int>(direction)};
  std::vector<float> beyond(static_cast<std::size_t>(hits_.width()) + 1, 0.0F);
  for (int i{hits_.width() - 1}; i >= 0; --i) {
    const auto at{static_cast<std::size_t>(i)};
    beyond[at] = beyond[at + 1] + hits_(i, row) + ends_(i, row);
  }
  if (beyond[0] == 0) return;
  const auto in_cells = [&](double length) {
    const Point2 in_fan{origin_.x + length * directions_[direction].x, origin_.y + length * directions_[direction].y};
    const Point2 p{grid_from_fan * in_fan};
    return Point2{(p.x - grid.x_min_m) / grid.cell_size_m, (p.y - grid.y_min_m) / grid.cell_size_m};
  };
  const Point2 start{in_cells(0)};
  const Point2 end{in_cells(1)};
  const double length{hits_.width() * step_};
  GridWalk walk{start, {end.x - start.x, end.y - start.y}};
  for (double from{0}; from < length; walk.advance()) {
    const double to{walk.leaves_at()};
    const float through{ending_beyond(beyond, to)};
    if (contains(grid, walk.ix(), walk.iy())) counts.passes(walk.ix(), walk.iy()) += through;
    from = to;
    if (beyond[std::min(beyond.size() - 1, static_cast<std::size_t>(from / step_))] == 0) break;
  }
  for (int i{0}; i + 1 < hits_.width(); ++i) {
    if (hits_(i, row) == 0 && ends_(i, row) == 0) continue;
    const Point2 p{in_cells((i + 0.5) * step_)};
    const int ix{static_cast<int>(std::floor(p.x))};
    const int iy{static_cast<int>(std::floor(p.y))};
    if (!contains(grid, ix, iy)) continue;
    counts.hits(ix, iy) += hits_(i, row);
    counts.passes(ix, iy) += ends_(i, row);
  }
}

double farthest_corner_m(const GridGeometry& grid) {
  const double x{std::max(std::abs(grid.x_min_m), std::abs(grid.x_min_m + grid.nx * grid.cell_size_m))};
  const double y{std::max(std::abs(grid.y_min_m), std::abs(grid.y_min_m + grid.ny * grid.cell_size_m))};
  return std::hypot(x, y);
}

Image<float> log_odds_of(const RayCounts& counts, const LogOddsParameters& parameters) {
  Image<float> log_odds{counts.hits.width(), counts.hits.height()};
  for (std::size_t i{0}; i < log_odds.size(); ++i) {
    const double hits{static_cast<double>(counts.hits.data()[i])};
    const double passes{static_cast<double>(counts.passes.data()[i])};
    double sum{-passes * parameters.pass};
    if (hits >= parameters.points_min) {
      sum += parameters.any_hit + hits * parameters.hit;
    } else if (passes > 0) {
      sum -= parameters.any_pass;
    }
    log_odds.data()[i] = static_cast<float>(std::clamp(sum, parameters.lowest, parameters.highest));
  }
  return log_odds;
}

Image<float> probabilities_of(Image<float> log_odds) {
  for (float& value : log_odds) value = 1 / (1 + std::exp(-value));
  return log_odds;
}

namespace {

std::vector<Point2> directions_of(int beams) {
  std::vector<Point2> directions;
  for (int i{0}; i < beams; ++i) {
    const double angle{(i + 0.5) * 2 * std::numbers::pi / beams - std::numbers::pi};
    directions.push_back({std::cos(angle), std::sin(angle)});
  }
  return directions;
}

}  // namespace

Image<float> lidar_grid(std::span<const CameraPoint> points, const CameraPoint& lidar, const Rig& rig,
                        const GridGeometry& grid, double camera_height_m, const LidarModelParameters& parameters) {
  const LevelFrame level_frame{rig};
  const std::vector<CameraPoint> level{level_frame(points)};
  const CameraPoint sensor{level_frame(lidar)};
  const LogOddsParameters& log_odds{parameters.log_odds};
  const int beams{std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi / parameters.beam_rad)))};
  const Point2 origin{sensor.z_m, -sensor.x_m};
  Fan fan{origin, directions_of(beams), farthest_corner_m(grid) + std::hypot(origin.x, origin.y), grid.cell_size_m / 4};
  const RoadPlane road{fit_road(level, level_frame.road(camera_height_m))};
  for (const CameraPoint& point : level) {
    const double height_m{road.height_of(point)};
    const bool is_hit{height_m >= log_odds.height_min_m && height_m <= log_odds.height_max_m};
    if (!is_hit && std::abs(height_m) > log_odds.road_m) continue;
    const double x{point.z_m - origin.x};
    const double y{-point.x_m - origin.y};
    const int beam{static_cast<int>((std::atan2(y, x) / std::numbers::pi + 1) / 2 * beams)};
    fan.add(static_cast<std::size_t>(std::clamp(beam, 0, beams - 1)), std::hypot(x, y), is_hit);
  }
  return probabilities_of(log_odds_of(fan.cast(grid, {}), log_odds));
}

}  // namespace stereogrid::evaluation
