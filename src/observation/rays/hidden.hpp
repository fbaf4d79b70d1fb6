// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "observation/rays/model.hpp"

namespace stereogrid {

/// Tells of many cells together that no ray comes as far as any of them, so that each is ½ (occupancy_at): they lie
/// outside of the image, or hidden in it. What it does not say that of may still be hidden.
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
  std::array<int, groups_max> empty_bins_{};  // of each group of columns: the sums before so many have no arriving rays
};

}  // namespace stereogrid
