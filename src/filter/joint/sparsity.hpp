// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "filter/filter.hpp"

namespace stereogrid {

struct ReferenceStep;

// Sparsity of the joint filter. The literal form (joint_cell) has a mass for every cell and velocity. Two rules leave
// most of them out; a test bounds the difference to the literal form:
//  1. Only blocks of which a cell moves keep masses. Elsewhere the moving mass is spread evenly over the moving
//  velocities.
//  2. A cell of which nothing was ever observed, and into which nothing moves, stays as it is.

/// P(occupied, v_k) of a cell before the step: kept, or spread evenly. `moving`: cells of each block that move.
[[nodiscard]] float sparse_mass(const FilterStep& constants, const FilterState& before, std::span<const CellBox> moving,
                                std::size_t k, int x, int y);

/// Cells that move, of each block of the window before. Empty for tay2008.
[[nodiscard]] std::vector<CellBox> moving_cells_of(const FilterState& before, const FilterStep& step, Scroll scroll);

/// Rule 1 for a cell of a block without masses: the sum of joint_cell over all moving velocities at once.
/// docs/method.md §8.7. `observed`: P(T_X) of the cell, 0.5 = unobserved.
[[nodiscard]] FilteredCell even_cell(const ReferenceStep& step, int x, int y, float observed, Likelihood likelihood);

}  // namespace stereogrid
