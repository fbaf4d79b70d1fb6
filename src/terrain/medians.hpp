// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/image.hpp"

namespace stereogrid {

/// Rows begin … end − 1 of an image.
struct RowRange {
  int begin;
  int end;
};

/// Upper median of the disparities > 0 in columns `column` … column + sector_px − 1, at least three, of each row; 0:
/// fewer. A pixel has an obstacle's or a road disparity. Columns behind the image have none.
void find_medians(View<const float> obstacle, View<const float> road, int column, RowRange rows, float* medians);

/// The same in plain loops: the definition.
namespace plain {
void find_medians(View<const float> obstacle, View<const float> road, int column, RowRange rows, float* medians);
}

}  // namespace stereogrid
