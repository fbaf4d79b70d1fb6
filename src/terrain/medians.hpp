// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/image.hpp"

namespace stereogrid {

/// Upper median of the disparities > 0 in columns `column` … column + sector_px − 1, at least three, of each row from
/// `first_row` on; 0: fewer. A pixel has an obstacle's or a road disparity. Columns behind the image have none.
void find_medians(View<const float> obstacle, View<const float> road, int column, int first_row, float* medians);

/// The same in plain loops: the definition.
namespace plain {
void find_medians(View<const float> obstacle, View<const float> road, int column, int first_row, float* medians);
}

}  // namespace stereogrid
