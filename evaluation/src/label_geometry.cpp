// SPDX-License-Identifier: Apache-2.0
#include "label_geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "stereogrid/level_mapping.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr double first_gate_m{0.35};
constexpr double gate_m{0.12};
constexpr int rounds{3};

bool may_be_road(const CameraPoint& p) {
  return p.z_m > 4 && p.z_m < 30 && std::abs(p.x_m) < 8;
}

/// Solves A·s = b given as rows [A | b]; none: A is singular.
std::optional<std::array<double, 3>> solve(std::array<std::array<double, 4>, 3> rows) {
  for (std::size_t i{0}; i < 3; ++i) {
    std::size_t pivot{i};
    for (std::size_t k{i + 1}; k < 3; ++k) {
      if (std::abs(rows[k][i]) > std::abs(rows[pivot][i])) pivot = k;
    }
    std::swap(rows[i], rows[pivot]);
    if (std::abs(rows[i][i]) < 1e-9) return std::nullopt;
    for (std::size_t k{0}; k < 3; ++k) {
      if (k == i) continue;
      const double factor{rows[k][i] / rows[i][i]};
      for (std::size_t j{i}; j < 4; ++j) rows[k][j] -= factor * rows[i][j];
    }
  }
  return std::array{rows[0][3] / rows[0][0], rows[1][3] / rows[1][1], rows[2][3] / rows[2][2]};
}

}  // namespace

RoadPlane fit_road(std::span<const CameraPoint> points, const RoadPlane& start) {
  RoadPlane plane{start};
  for (int round{0}; round < rounds; ++round) {
    const double gate{round == 0 ? first_gate_m : gate_m};
    std::array<std::array<double, 4>, 3> normal{};
    for (const CameraPoint& p : points) {
      if (!may_be_road(p) || !(std::abs(plane.height_of(p)) < gate)) continue;
      const std::array<double, 4> row{p.x_m, p.z_m, 1, p.y_m};
      for (std::size_t i{0}; i < 3; ++i) {
        for (std::size_t j{0}; j < 4; ++j) normal[i][j] += row[i] * row[j];
      }
    }
    const auto solution{solve(normal)};
    if (!solution) return plane;
    plane = {(*solution)[0], (*solution)[1], (*solution)[2]};
  }
  return plane;
}

LevelFrame::LevelFrame(const Rig& rig) : rig_{rig} {
  const double turned_rad{LevelMapping{rig}.is_identity() ? 0 : rig.camera_pitch_rad};
  sin_ = std::sin(turned_rad);
  cos_ = std::cos(turned_rad);
}

std::vector<CameraPoint> LevelFrame::operator()(std::span<const CameraPoint> points) const {
  std::vector<CameraPoint> level;
  level.reserve(points.size());
  std::ranges::transform(points, std::back_inserter(level),
                         [this](const CameraPoint& point) { return (*this)(point); });
  return level;
}

// g·X = height, with g the unit vector to the road (docs/method.md §1.2).
RoadPlane LevelFrame::road(double camera_height_m) const {
  const double cos_pitch{std::cos(rig_.camera_pitch_rad)};
  const CameraPoint g{(*this)({cos_pitch * std::sin(rig_.camera_roll_rad), cos_pitch * std::cos(rig_.camera_roll_rad),
                               std::sin(rig_.camera_pitch_rad)})};
  return {-g.x_m / g.y_m, -g.z_m / g.y_m, camera_height_m / g.y_m};
}

NearestObstacle::NearestObstacle(const Rig& rig)
    : rig_{rig}, nearest_m_(static_cast<std::size_t>(rig.width_px), std::numeric_limits<double>::infinity()) {}

double NearestObstacle::column_of(double x_m, double y_m) const {
  return rig_.cx_px - rig_.focal_px * y_m / x_m;
}

void NearestObstacle::add(double x_m, double y_m, double columns) {
  const double u{column_of(x_m, y_m)};
  const double first{std::max(std::ceil(u - columns), 0.0)};
  const double last{std::min(std::floor(u + columns), rig_.width_px - 1.0)};
  for (double column{first}; column <= last; ++column) {
    double& nearest{nearest_m_[static_cast<std::size_t>(column)]};
    nearest = std::min(nearest, x_m);
  }
}

bool NearestObstacle::hides(const GridGeometry& grid, int ix, int iy) const {
  const double near_m{grid.x_min_m + ix * grid.cell_size_m};
  if (near_m <= hiding_margin_m) return false;
  const double far_m{near_m + grid.cell_size_m};
  const double right_m{grid.y_min_m + iy * grid.cell_size_m};
  const double left_m{right_m + grid.cell_size_m};
  const double from{std::min(column_of(near_m, left_m), column_of(far_m, left_m))};
  const double to{std::max(column_of(near_m, right_m), column_of(far_m, right_m))};
  const double first{std::max(std::floor(from + 0.5), 0.0)};
  const double last{std::min(std::floor(to + 0.5), rig_.width_px - 1.0)};
  if (first > last) return false;
  return std::all_of(nearest_m_.begin() + static_cast<std::ptrdiff_t>(first),
                     nearest_m_.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                     [&](double nearest) { return nearest < near_m - hiding_margin_m; });
}

void mark_partly_hidden(const NearestObstacle& nearest, Labels& labels) {
  for (int iy{0}; iy < labels.cells.height(); ++iy) {
    for (int ix{0}; ix < labels.cells.width(); ++ix) {
      if (labels.cells(ix, iy) == not_scored) continue;
      labels.partly_hidden(ix, iy) = nearest.hides(labels.geometry, ix, iy) ? 1 : 0;
    }
  }
}

}  // namespace stereogrid::evaluation
