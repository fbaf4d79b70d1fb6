// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "observation/rays/model.hpp"

namespace stereogrid {

/// Detects groups of cells that no ray reaches, outside of the image or hidden, so that each is ½ (occupancy_at). Cells
/// of undetected groups may still be hidden.
class HiddenCells {
 public:
  HiddenCells(const RaySums<Host>& sums, const BinGeometry& geometry, const GridInVehicle& grid);

  /// The cells from (x_first, y_first) to (x_last, y_last).
  [[nodiscard]] bool are_hidden(int x_first, int y_first, int x_last, int y_last) const;

 private:
  static constexpr int groups_max{256};

  // No ray of the columns arrives before the bin `end`.
  [[nodiscard]] bool is_empty_before(int end, int first_column, int last_column) const;

  BinGeometry geometry_;
  GridInVehicle grid_;
  int width_;
  int bins_;
  int group_columns_;
  std::array<int, groups_max> empty_bins_{};  // by group of columns: number of sums without arriving rays
};

}  // namespace stereogrid
