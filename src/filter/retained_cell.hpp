// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stereogrid {

/// A cell of the window that stays occupied although the frame cannot observe it.
struct RetainedCell {
  int cell;         ///< iy · nx + ix of the window
  float occupancy;  ///< least P(occupied) that counts as observed
};

/// Most cells that are held at a time.
constexpr int retained_cells_max{8192};

}  // namespace stereogrid
