// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stereogrid {

/// About half a matching window: pixels so near an edge of depth …
constexpr int edge_reach_px{5};
/// … that lie between both surfaces by more than this belong to neither.
constexpr float edge_step_px{1.2f};

/// A row of disparities (px, 0 = none), without the pixels that have, within the reach, both a disparity larger and one
/// smaller than theirs by more than the step.
void leave_edges_out(const float* row, int width, float* kept);

}  // namespace stereogrid
