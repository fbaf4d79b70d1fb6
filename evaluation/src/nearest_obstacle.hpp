// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/evaluation/labels.hpp"

namespace stereogrid::evaluation {

/// Nearest obstacle of every image column, and the cells that it hides from methods which end at the nearest obstacle.
class NearestObstacle {
 public:
  explicit NearestObstacle(const Rig& rig);

  /// An obstacle at (x ahead, y to the left), vehicle frame. It covers the columns within `columns` of its own.
  void add(double x_m, double y_m, double columns);

  /// Every column that the cell covers has an obstacle nearer than its near edge by hiding_margin_m.
  [[nodiscard]] bool hides(const GridGeometry& grid, int ix, int iy) const;

 private:
  [[nodiscard]] double column_of(double x_m, double y_m) const;

  Rig rig_;
  std::vector<double> nearest_m_;
};

/// Fills `labels.partly_hidden` of the cells that are labelled.
void mark_partly_hidden(const NearestObstacle& nearest, Labels& labels);

}  // namespace stereogrid::evaluation
