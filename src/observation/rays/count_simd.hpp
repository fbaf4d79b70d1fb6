// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "observation/rays/rays.hpp"

namespace stereogrid {

/// Columns that are counted together: their counts stay in the first cache.
constexpr int ray_block_columns{16};

/// Counts the rays of columns begin … end − 1, at most ray_block_columns, in each bin: count_ray of every pixel.
/// `space.sums` has the counts of column u and bin k at (k + 1, u + 1).
void count_ray_block(const Matches& matches, int begin, int end, RaySpace& space);

}  // namespace stereogrid
