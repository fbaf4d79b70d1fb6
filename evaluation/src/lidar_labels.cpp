// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "label_geometry.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/labels.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr double obstacle_from_m{0.3};
constexpr double obstacle_to_m{1.8};
constexpr double road_within_m{0.12};
constexpr int obstacle_points_min{2};
constexpr double ahead_min_m{1};
constexpr double hiding_from_m{3};   // nearer returns are often from the own vehicle
constexpr double column_reach{1.5};  // returns are about 2 columns apart on KITTI: no gaps within a surface
constexpr double bearing_step_deg{0.5};
constexpr double behind_from_m{0.25};
constexpr double behind_to_m{4};
constexpr int bearings_behind_min{2};

bool in_view(const CameraPoint& p, const Rig& rig) {
  const double u{rig.cx_px + rig.focal_px * p.x_m / std::max(p.z_m, 0.1)};
  return p.z_m > ahead_min_m && u > 0 && u < rig.width_px;
}

struct CellIndex {
  int ix{0};
  int iy{0};
};

std::optional<CellIndex> cell_of(const CameraPoint& p, const GridGeometry& grid) {
  const double ix{std::floor((p.z_m - grid.x_min_m) / grid.cell_size_m)};
  const double iy{std::floor((-p.x_m - grid.y_min_m) / grid.cell_size_m)};
  if (ix < 0 || iy < 0 || ix >= grid.nx || iy >= grid.ny) return std::nullopt;
  return CellIndex{static_cast<int>(ix), static_cast<int>(iy)};
}

/// Points that the camera could see and that lie on cells.
struct SeenPoints {
  std::vector<CameraPoint> obstacle;
  std::vector<CameraPoint> road;
};

/// `points` as the camera has them, and the same ones `level`.
SeenPoints sort_by_height(std::span<const CameraPoint> points, std::span<const CameraPoint> level,
                          const RoadPlane& road, const Labels& labels) {
  SeenPoints seen;
  for (std::size_t i{0}; i < points.size(); ++i) {
    const CameraPoint& p{level[i]};
    if (!in_view(points[i], labels.rig) || !cell_of(p, labels.geometry)) continue;
    const double height{road.height_of(p)};
    if (height > obstacle_from_m && height < obstacle_to_m) seen.obstacle.push_back(p);
    if (std::abs(height) < road_within_m) seen.road.push_back(p);
  }
  return seen;
}

Image<int> count(const std::vector<CameraPoint>& points, const GridGeometry& grid) {
  Image<int> counts{grid.nx, grid.ny};
  for (const CameraPoint& p : points) {
    const auto cell{cell_of(p, grid)};
    if (cell) ++counts(cell->ix, cell->iy);
  }
  return counts;
}

void label(const Image<int>& obstacle, const Image<int>& road, Image<std::int8_t>& cells) {
  for (std::size_t i{0}; i < cells.size(); ++i) {
    if (obstacle.data()[i] >= obstacle_points_min) {
      cells.data()[i] = labelled_occupied;
    } else if (obstacle.data()[i] == 0 && road.data()[i] > 0) {
      cells.data()[i] = labelled_free;
    }
  }
}

/// Nearest points on occupied cells.
NearestObstacle nearest_of(const std::vector<CameraPoint>& obstacle, const Labels& labels) {
  NearestObstacle nearest{labels.rig};
  for (const CameraPoint& p : obstacle) {
    const auto cell{cell_of(p, labels.geometry)};
    if (!cell || p.z_m < hiding_from_m || labels.cells(cell->ix, cell->iy) != labelled_occupied) continue;
    nearest.add(p.z_m, -p.x_m, column_reach);
  }
  return nearest;
}

/// A cell as the camera sees it from above the vehicle frame's origin.
struct Sight {
  int bearing{0};  ///< steps of bearing_step_deg, from 1 on, with a free one at either end
  double reach_m{0};
};
constexpr std::size_t bearings{static_cast<std::size_t>(360 / bearing_step_deg) + 3};

Sight sight_of(const GridGeometry& grid, int ix, int iy) {
  const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m};
  const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
  const double degrees{std::atan2(y, x) * 180 / std::numbers::pi};
  return {static_cast<int>(std::nearbyint(degrees / bearing_step_deg) + bearings / 2), std::hypot(x, y)};
}

void mark_hidden_ground(Labels& labels) {
  labels.hidden_ground = Image<std::uint8_t>{labels.geometry.nx, labels.geometry.ny};
  std::vector<std::vector<double>> occupied_m(bearings);
  const auto for_cells = [&](std::int8_t label, auto visit) {
    for (int iy{0}; iy < labels.geometry.ny; ++iy) {
      for (int ix{0}; ix < labels.geometry.nx; ++ix) {
        if (labels.cells(ix, iy) == label) visit(ix, iy, sight_of(labels.geometry, ix, iy));
      }
    }
  };
  for_cells(labelled_occupied, [&](int, int, const Sight& sight) {
    occupied_m[static_cast<std::size_t>(sight.bearing)].push_back(sight.reach_m);
  });
  for_cells(labelled_free, [&](int ix, int iy, const Sight& sight) {
    const auto first = occupied_m.begin() + sight.bearing - 1;
    const auto behind = std::count_if(first, first + 3, [&](const std::vector<double>& reaches_m) {
      return std::ranges::any_of(reaches_m, [&](double reach_m) {
        return reach_m >= sight.reach_m - behind_to_m && reach_m <= sight.reach_m - behind_from_m;
      });
    });
    labels.hidden_ground(ix, iy) = behind >= bearings_behind_min ? 1 : 0;
  });
}

constexpr double pixel_reach{0.5};  // pixels lie side by side

/// Pixels of obstacles between the height limits.
NearestObstacle nearest_seen(const FrameTruth& truth, const TruthGrid& grid, const Rig& rig) {
  NearestObstacle nearest{rig};
  const double c{std::cos(rig.camera_pitch_rad)};
  const double s{std::sin(rig.camera_pitch_rad)};
  for (int v{0}; v < truth.label.height(); ++v) {
    for (int u{0}; u < truth.label.width(); ++u) {
      const double disparity{truth.disparity(u, v)};
      if (truth.label(u, v) != static_cast<std::uint8_t>(TruthLabel::obstacle) || disparity <= 0) continue;
      const double z{rig.focal_px * rig.baseline_m / disparity};
      const double y{(v - rig.cy_px) * z / rig.focal_px};
      const double height{rig.camera_height_m - z * s - y * c};
      const double ahead{z * c - y * s};
      if (height < grid.height_min_m || height > grid.height_max_m || ahead <= 0) continue;
      nearest.add(ahead, -(u - rig.cx_px) * z / rig.focal_px, pixel_reach);
    }
  }
  return nearest;
}

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

}  // namespace

Labels lidar_labels(std::span<const CameraPoint> points, const Rig& rig, const GridGeometry& grid,
                    double camera_height_m) {
  Labels labels{grid, rig, {grid.nx, grid.ny, not_scored}, {grid.nx, grid.ny}};
  const LevelFrame level_frame{rig};
  const std::vector<CameraPoint> level{level_frame(points)};
  const SeenPoints seen{sort_by_height(points, level, fit_road(level, level_frame.road(camera_height_m)), labels)};
  label(count(seen.obstacle, grid), count(seen.road, grid), labels.cells);
  mark_partly_hidden(nearest_of(seen.obstacle, labels), labels);
  mark_hidden_ground(labels);
  return labels;
}

CellShift shift_between(const GridGeometry& grid, const GridGeometry& truth) {
  const double x{(truth.x_min_m - grid.x_min_m) / grid.cell_size_m};
  const double y{(truth.y_min_m - grid.y_min_m) / grid.cell_size_m};
  const auto is_whole = [](double cells) { return std::abs(cells - std::round(cells)) < 1e-6; };
  if (std::abs(grid.cell_size_m - truth.cell_size_m) > 1e-9 || !is_whole(x) || !is_whole(y)) {
    const std::string size{text_of(truth.cell_size_m)};
    throw InputError{"The grid's cells (" + text_of(grid.cell_size_m) + " m) do not coincide with the truth's (" +
                     size + " m). Run with --set grid.cell_size_m=" + size + "."};
  }
  return {static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))};
}

Labels truth_labels(const FrameTruth& truth, const TruthGrid& truth_grid, const Rig& rig, const GridGeometry& grid) {
  Labels labels{grid, rig, {grid.nx, grid.ny, not_scored}, {grid.nx, grid.ny}};
  const CellShift shift{shift_between(grid, truth_grid.geometry)};
  for (int ty{0}; ty < truth.state.height(); ++ty) {
    for (int tx{0}; tx < truth.state.width(); ++tx) {
      const int ix{tx + shift.x};
      const int iy{ty + shift.y};
      const auto state{static_cast<TruthCell>(truth.state(tx, ty))};
      if (ix < 0 || iy < 0 || ix >= grid.nx || iy >= grid.ny || state == TruthCell::hidden) continue;
      labels.cells(ix, iy) = state == TruthCell::seen_occupied ? labelled_occupied : labelled_free;
    }
  }
  mark_partly_hidden(nearest_seen(truth, truth_grid, rig), labels);
  return labels;
}

}  // namespace stereogrid::evaluation
