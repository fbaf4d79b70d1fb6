// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "label_geometry.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/evaluation/labels.hpp"

namespace stereogrid::evaluation {
namespace {

constexpr double column_reach{0.5};  // pixels lie side by side

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
      nearest.add(ahead, -(u - rig.cx_px) * z / rig.focal_px, column_reach);
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
