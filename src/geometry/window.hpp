// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Whole cells by which the window has moved since the step before.
struct Scroll {
  int x;
  int y;
};

/// World-aligned window that covers a vehicle-frame grid in every heading. Its origin is a whole number of cells.
class Window {
 public:
  explicit Window(const GridGeometry& vehicle_grid);

  /// Number of cells along a side.
  [[nodiscard]] int cells() const { return cells_; }
  /// Geometry of the window for a pose of the car.
  [[nodiscard]] GridGeometry at(const Pose2& world_from_vehicle) const;

 private:
  double cell_size_m_;
  double ahead_m_;
  double aside_m_;
  int cells_;
};

/// From one place of the window to the next.
Scroll scroll_between(const GridGeometry& before, const GridGeometry& now);

}  // namespace stereogrid
