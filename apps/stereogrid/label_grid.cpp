// SPDX-License-Identifier: Apache-2.0
#include "label_grid.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace stereogrid::app {
namespace {

constexpr float confidence_near{0.8F};  // cells that are deeper than a row of pixels
constexpr float occupied{0.9F};
constexpr int no_foot{-1};

struct Pixel {
  double u, v;
};

/// Pixel that shows a point of the ground; none: it is behind the camera.
std::optional<Pixel> pixel_of(const Rig& rig, double x_m, double y_m) {
  const double depth{x_m * std::cos(rig.camera_pitch_rad) + rig.camera_height_m * std::sin(rig.camera_pitch_rad)};
  const double below{rig.camera_height_m * std::cos(rig.camera_pitch_rad) - x_m * std::sin(rig.camera_pitch_rad)};
  if (!(depth > 0)) return std::nullopt;
  const double c{std::cos(rig.camera_roll_rad)};
  const double s{std::sin(rig.camera_roll_rad)};
  return Pixel{rig.cx_px + rig.focal_px * (s * below - c * y_m) / depth,
               rig.cy_px + rig.focal_px * (c * below + s * y_m) / depth};
}

bool is(std::uint8_t label, PixelLabel wanted) {
  return label == static_cast<std::uint8_t>(wanted);
}

/// Lowest row of an obstacle or a mover in each column.
std::vector<int> foot_rows(const Image<std::uint8_t>& labels) {
  std::vector<int> feet(static_cast<std::size_t>(labels.width()), no_foot);
  for (int v{0}; v < labels.height(); ++v) {
    for (int u{0}; u < labels.width(); ++u) {
      if (is(labels(u, v), PixelLabel::obstacle) || is(labels(u, v), PixelLabel::mover))
        feet[static_cast<std::size_t>(u)] = v;
    }
  }
  return feet;
}

/// Evidence of the labels for a cell.
struct Statement {
  float occupancy{0.5F};
  float confidence{0};
};

Statement statement_of(const Image<std::uint8_t>& labels, const std::vector<int>& feet, const Rig& rig, Point2 centre,
                       double half_m) {
  const auto middle{pixel_of(rig, centre.x, centre.y)};
  const auto near{pixel_of(rig, centre.x - half_m, centre.y)};
  const auto far{pixel_of(rig, centre.x + half_m, centre.y)};
  const auto left{pixel_of(rig, centre.x, centre.y + half_m)};
  const auto right{pixel_of(rig, centre.x, centre.y - half_m)};
  if (!middle || !near || !far || !left || !right) return {};
  const double u{std::round(middle->u)};
  const double v{std::round(middle->v)};
  if (!(u >= 0 && u < labels.width() && v >= 0 && v < labels.height())) return {};
  const double row_m{centre.x * centre.x / (rig.focal_px * rig.camera_height_m)};  // depth of a row of pixels
  const float confidence{confidence_near * static_cast<float>(std::min(1.0, 2 * half_m / row_m))};
  const int first{static_cast<int>(std::clamp(std::round(left->u), 0.0, u))};
  const int last{static_cast<int>(std::clamp(std::round(right->u), u, labels.width() - 1.0))};
  int nearest{no_foot};
  for (int column{first}; column <= last; ++column) nearest = std::max(nearest, feet[static_cast<std::size_t>(column)]);
  const bool is_cut{nearest == labels.height() - 1};  // the foot is below the image
  if (nearest >= far->v - 0.5 && nearest <= near->v + 0.5 && !is_cut) return {occupied, confidence};
  const bool is_before{nearest == no_foot || v > nearest};
  if (is_before && is(labels(static_cast<int>(u), static_cast<int>(v)), PixelLabel::passable))
    return {1 - occupied, confidence};
  return {};
}

}  // namespace

ObservedGrid label_grid(const Image<std::uint8_t>& labels, const Rig& rig, const GridGeometry& grid) {
  ObservedGrid made{grid, Image<float>{grid.nx, grid.ny}, Image<float>{grid.nx, grid.ny}};
  const std::vector<int> feet{foot_rows(labels)};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Point2 centre{grid.x_min_m + (ix + 0.5) * grid.cell_size_m, grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
      const Statement statement{statement_of(labels, feet, rig, centre, grid.cell_size_m / 2)};
      made.occupancy(ix, iy) = statement.occupancy;
      made.confidence(ix, iy) = statement.confidence;
    }
  }
  return made;
}

}  // namespace stereogrid::app
